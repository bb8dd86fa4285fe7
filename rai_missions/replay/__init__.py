# SPDX-License-Identifier: Apache-2.0
"""A journal again: rebuilt as it was, replayed step by step, resumed in another process, migrated to another mission.

Imports `engine`, `guards`, `journal`, `mission`, `model`, `planning`, `profile`, `states` and `trees`, and the
modules of the root. Performs nothing.
"""

__all__ = ()

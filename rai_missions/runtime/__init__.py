# SPDX-License-Identifier: Apache-2.0
"""A run: one loop with a mailbox and a clock, which performs what the engine decides and feeds back what comes of it.

Imports `connectors`, `engine`, `guards`, `journal`, `mission`, `profile`, `replay`, `states` and `trees`, and the
modules of the root. Connectors and answerers are known by their protocols only.
"""

__all__ = ()

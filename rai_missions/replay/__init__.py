# SPDX-License-Identifier: Apache-2.0
"""A journal again: rebuilt as it was, replayed step by step, resumed in another process, migrated to another mission.

Imports the engine, the journal and profiles; performs nothing.
"""

__all__ = ()

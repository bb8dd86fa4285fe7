# SPDX-License-Identifier: Apache-2.0
"""A run: one loop with a mailbox and a clock, which performs what the engine decides and feeds back what comes of it.

Imports the engine, the journal, profiles and trees; knows connectors and answerers by their protocols only.
"""

__all__ = ()

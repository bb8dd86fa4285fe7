# SPDX-License-Identifier: Apache-2.0
"""From what a run and the robot report to words: answers to questions, and orders as they are read back.

Imports `conversation.grammar`, `conversation.language`, `conversation.sentences`, `conversation.view`
and `profile`, and the modules of the root.
"""

__all__ = ()

# SPDX-License-Identifier: Apache-2.0
"""From words to what they may mean: orders, answers to a question, corrections, and questions of state.

Imports `conversation.language`, `conversation.view`, `engine`, `planning` and `profile`, and the modules of the root.
"""

__all__ = ()

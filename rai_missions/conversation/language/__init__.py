# SPDX-License-Identifier: Apache-2.0
"""A language as data: its phrases and templates, and values, a run and its questions in its words.

Imports `conversation.view`, `engine`, `mission` and `planning`, and the modules of the root.
"""

__all__ = ()

# SPDX-License-Identifier: Apache-2.0
"""Claims: which sentences of a model report something of the robot or its work.

Imports `conversation.language`, `conversation.sentences`, `conversation.view` and `planning`, and the modules of the
root.
"""

__all__ = ()

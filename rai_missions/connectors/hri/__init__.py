# SPDX-License-Identifier: Apache-2.0
"""What a person and a robot send each other, over any connector: messages, their parts, and how they travel.

Imports the modules of the root only.
"""

__all__ = ()

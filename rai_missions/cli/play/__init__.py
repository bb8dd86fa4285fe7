# SPDX-License-Identifier: Apache-2.0
"""A play at the terminal and in the browser: the same play, shown twice.

Imports `check`, `engine`, `journal`, `mission`, `replay`, `runtime`, `states` and `visualize`, and the modules of
the root.
"""

__all__ = ()

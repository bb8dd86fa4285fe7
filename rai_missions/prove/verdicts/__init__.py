# SPDX-License-Identifier: Apache-2.0
"""What the states show: each claim proved, or refuted by a shortest run.

Imports `check`, `engine`, `guards`, `journal`, `mission`, the other parts of `prove`, and the modules of the root.
"""

__all__ = ()

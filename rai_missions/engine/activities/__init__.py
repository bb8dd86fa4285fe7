# SPDX-License-Identifier: Apache-2.0
"""What states do while they are active: a pure machine a kind, under the same file names as in `states`.

Imports `guards`, `mission`, `planning` and `states`, and the modules of the root.
"""

__all__ = ()

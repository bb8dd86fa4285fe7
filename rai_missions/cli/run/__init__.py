# SPDX-License-Identifier: Apache-2.0
"""A run from the command line: the run itself, its live page, its node, its migration, and the journal that is meant.

Imports `agents`, `answerers`, `check`, `connectors`, `conversation`, `embodiment`, `engine`, `journal`, `mission`,
`node`, `profile`, `recording`, `replay`, `runtime`, `voice` and `visualize`, and the modules of the root.
"""

__all__ = ()

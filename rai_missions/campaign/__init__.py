# SPDX-License-Identifier: Apache-2.0
"""Campaigns: which model may decide, with which embodiment, measured on scenes that physics has labelled.

Imports `agents`, `answerers`, `check`, `connectors`, `embodiment`, `engine`, `guards`, `journal`, `mission`, `model`,
`profile`, `replay`, `runtime`, `states`, `tools` and `worlds`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()

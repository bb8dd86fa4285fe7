# SPDX-License-Identifier: Apache-2.0
"""Tools over a connector, for models and for programs; each part is loaded when it is first used.

Imports `connectors` and the modules of the root.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rai_missions.tools.allowlist import Allowed
    from rai_missions.tools.result import ToolResult
    from rai_missions.tools.tool import RobotTool
    from rai_missions.tools.toolbox import Toolbox

__all__ = ("Allowed", "RobotTool", "ToolResult", "Toolbox")

ROOMS = {"Allowed": "allowlist", "RobotTool": "tool", "ToolResult": "result", "Toolbox": "toolbox"}


def __getattr__(name: str) -> Any:
    if name not in ROOMS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{ROOMS[name]}"), name)

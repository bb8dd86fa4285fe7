# SPDX-License-Identifier: Apache-2.0
"""Tools over a connector, for models and for programs; each part is loaded when it is first used.

Imports `connectors`, `embodiment` and the modules of the root.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.tools.allowlist import Allowlist
    from rai_missions.tools.recall import recall_tool
    from rai_missions.tools.result import ToolResult
    from rai_missions.tools.tool import RobotTool
    from rai_missions.tools.toolbox import Toolbox

__all__ = ("Allowlist", "RobotTool", "ToolResult", "Toolbox", "recall_tool")

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "allowlist": ("Allowlist",),
            "recall": ("recall_tool",),
            "result": ("ToolResult",),
            "tool": ("RobotTool",),
            "toolbox": ("Toolbox",),
        },
    )

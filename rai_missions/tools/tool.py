# SPDX-License-Identifier: Apache-2.0
"""One tool as langchain has it: words for a model, data for a program, and a fault as an answer like any other.

Rule: whatever goes wrong is returned to the caller, as data; no exception of ours or of the robot's ends an agent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from langchain_core.tools import BaseTool, ToolException
from pydantic import Field, ValidationError

from rai_missions.errors import MissionError, raised_text
from rai_missions.redaction import cut, logger
from rai_missions.tools.arguments import arguments_of
from rai_missions.tools.result import ToolResult

__all__ = ("RobotTool", "is_read_only")

log = logger(__name__)


def _failed(fault: ToolException) -> str:
    """A fault may quote what the robot reported: it is data as well."""
    return ToolResult("This was not done:", {}, str(fault)).text()


def _not_understood(fault: Any) -> str:
    """What is wrong with the arguments, each by its name."""
    problems = [f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in fault.errors()[:5]]
    return ToolResult("This was not done; the arguments are not right:", {}, cut("; ".join(problems), 500)).text()


class RobotTool(BaseTool):
    """A tool over a connector; `metadata["read_only"]` states whether it only looks.

    What it gives a model marks the robot's data as such (`metadata["marks_data"]`).
    """

    act: Callable[..., ToolResult] = Field(exclude=True, repr=False)
    """What it does; may be called directly by a program, and then raises `MissionError`."""
    response_format: Literal["content", "content_and_artifact"] = "content_and_artifact"
    handle_tool_error: bool | str | Callable[[ToolException], str] | None = _failed
    handle_validation_error: Any = _not_understood

    @property
    def is_read_only(self) -> bool:
        """Whether it only looks."""
        return is_read_only(self)

    def _run(self, *given: Any, **words: Any) -> tuple[str | list[dict[str, Any]], Any]:
        try:
            result = self.act(*given, **words)
            return result.content(), result.data
        except MissionError as fault:
            raise ToolException(str(fault)) from fault
        except ValidationError as fault:  # a fault of ours, and none of the arguments
            raise ToolException(f"failed: {cut(fault, 200)}") from fault
        except Exception as fault:
            log.exception("the tool %s failed", self.name)
            raise ToolException(f"failed: {cut(raised_text(fault), 200)}") from fault


def is_read_only(tool: BaseTool) -> bool:
    """Whether a tool is marked as one that only looks: `metadata={"read_only": True}`."""
    return (tool.metadata or {}).get("read_only") is True


def robot_tool(act: Callable[..., ToolResult], *, read_only: bool) -> RobotTool:
    """A function as a tool: its name, its docstring and its signature are what a model is shown of it."""
    return RobotTool(
        name=act.__name__,
        description=" ".join((act.__doc__ or "").split()),
        args_schema=arguments_of(act),
        act=act,
        metadata={"read_only": read_only, "marks_data": True},
    )

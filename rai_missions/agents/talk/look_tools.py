# SPDX-License-Identifier: Apache-2.0
"""What a model may look at in a conversation: who the robot is, its documents, what its rules report, its pictures.

Rule: a tool reads values and changes nothing. What the robot reported is quoted, as data.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from langchain_core.tools import BaseTool, StructuredTool

from rai_missions.conversation import StatusView
from rai_missions.embodiment.identity import Identity
from rai_missions.image import Image
from rai_missions.plain_data import listed
from rai_missions.tools import recall_tool

__all__ = ("look_tools",)

ONLY_LOOKS = {"read_only": True}


def look_tools(
    identity: Identity | None, view: Callable[[], StatusView], others: Sequence[BaseTool] = ()
) -> list[BaseTool]:
    """The tools of one request.

    Args:
        identity: Who the robot is; None where its profile has none.
        view: The run as it is when a tool looks.
        others: Read-only tools over the robot's connector, as far as the profile allows.
    """

    def who_am_i() -> str:
        return identity.words() if identity is not None else "The robot's profile has no identity."

    def status() -> str:
        return _status_words(view())

    def picture(key: str) -> Any:
        return _picture(view(), key)

    made: list[BaseTool] = [
        _tool(who_am_i, "who_am_i", "Who this robot is: its description and body."),
        _tool(status, "status", "What the robot's rules report now: mode, states, keys with their ages."),
        _tool(picture, "picture", "The newest picture under a key of the blackboard, if there is one."),
    ]
    if identity is not None and identity.library is not None:
        made.append(recall_tool(identity.library))
    names = {tool.name for tool in made}
    return [*made, *(tool for tool in others if tool.name not in names)]


def _tool(do: Callable[..., Any], name: str, about: str) -> BaseTool:
    return StructuredTool.from_function(do, name=name, description=about, metadata=ONLY_LOOKS)


def _status_words(view: StatusView) -> str:
    keys = [
        f"{name}: {listed(key.value) if key.is_fresh else 'unknown'}"
        + (f", {key.age_s:.1f} s old" if key.age_s is not None else "")
        for name, key in view.keys.items()
        if not isinstance(key.value, Image)
    ]
    head = f"mode: {view.mode or 'no run'}; states: {', '.join(view.active) or 'none'}; control: {view.control}"
    end = f"; it ended {view.outcome}: {view.why}" if view.outcome else ""
    return "\n".join((f"{head}{end}", *keys))


def _picture(view: StatusView, key: str) -> Any:
    found = view.keys.get(key)
    if found is None or not isinstance(found.value, Image):
        names = [name for name, each in view.keys.items() if each.type == "image"]
        return f"no picture under '{key}'; there is: {', '.join(names) or 'none'}"
    if not found.is_fresh:
        return f"the picture under '{key}' is too old to be believed"
    return [{"type": "text", "text": f"{key}:"}, found.value.file().block()]

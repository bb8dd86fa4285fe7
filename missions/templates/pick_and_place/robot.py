# SPDX-License-Identifier: Apache-2.0
"""The arm, simulated: three parts on a table, the second of which slips from above.

Each function is called by its name in the mission. Put your arm's own calls into the bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions import PythonRobot
from rai_missions.connectors.python_robot import ActionRun

PARTS: tuple[Mapping[str, Any], ...] = (
    {"kind": "cube", "width_mm": 40.0, "free_side": True},
    {"kind": "wet cube", "width_mm": 40.0, "free_side": True},
    {"kind": "cylinder", "width_mm": 30.0, "free_side": False},
)
EMPTY: Mapping[str, Any] = {"kind": "none", "width_mm": 0.0, "free_side": False}
MOVE_S = 0.4

RULES: dict[str, list[Mapping[str, Any]]] = {
    "choosing": [
        {"when": {"key": "part.free_side", "==": True}, "answer": "grip_side"},
        {"when": {"key": "skipped", "<": 2}, "answer": "skip"},
    ]
}
"""Who answers as `rules`; where no rule fits, the next in the decision's `ask` is asked."""

CONVERSATION: Mapping[str, Any] = {
    "phrases": {"(put|place|pick) {wanted} parts [(in|into) the tray]": {}},
    "spoken": {"put {wanted} parts into the tray": {}},
    "questions": {"how many [parts] are in the tray": "in_tray"},
}
"""What people may order and ask in words of their own, with `run --talk`."""


class Cell:
    """What is simulated: the parts on the table, in the gripper and in the tray."""

    held: Mapping[str, Any] | None = None
    in_tray = 0

    def __init__(self) -> None:
        self.table = list(PARTS)

    def nearest(self) -> Mapping[str, Any]:
        """What the camera sees."""
        return self.table[0] if self.table else EMPTY


def robot() -> PythonRobot:
    """An arm for each run."""
    made, cell = PythonRobot("arm, simulated", rules=RULES, conversation=CONVERSATION), Cell()

    made.fact("in_tray", every_s=1)(lambda: cell.in_tray)
    made.fact("holding", every_s=0.5)(lambda: cell.held is not None)
    made.fact("part", every_s=1)(cell.nearest)

    @made.action("pick", uses=["arm"])
    def pick(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Grip the nearest part; an exception is the action's failure, and its text is the reason."""
        run.sleep(MOVE_S)
        if run.canceled:
            return run.cancel()
        if not cell.table:
            raise LookupError("the table is empty")
        if cell.nearest()["kind"].startswith("wet") and goal["grip"] == "top":
            raise RuntimeError("the part slipped out of the gripper")
        cell.held = cell.table.pop(0)
        made.write("holding", True)
        return None

    @made.action("place", uses=["arm"])
    def place(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Put what is held into the tray."""
        run.sleep(MOVE_S)
        if run.canceled:
            return run.cancel()
        cell.held, cell.in_tray = None, cell.in_tray + 1
        made.write("holding", False)
        made.write("in_tray", cell.in_tray)
        return None

    @made.service("push_aside")
    def push_aside(request: Mapping[str, Any]) -> None:
        """Move the nearest part out of reach."""
        cell.table = cell.table[1:]

    return made

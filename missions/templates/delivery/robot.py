# SPDX-License-Identifier: Apache-2.0
"""The robot of the delivery, simulated: a corridor of six metres with a box at four.

Each function is called by its name in the mission. Put your robot's own calls into the bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions import PythonRobot
from rai_missions.connectors.python_robot import ActionRun

BOX = {"kind": "box", "living": False, "gap_m": 1.2}
BOX_AT_M = 4.0
STEP_S, SPEED_M_S = 0.1, 4.0

RULES: dict[str, list[Mapping[str, Any]]] = {
    "assessing": [
        {"when": {"all": [{"not": {"fresh": "obstacle"}}, {"key": "waits", "<": 3}]}, "answer": "wait"},
        {"when": {"all": [{"key": "obstacle.living", "==": True}, {"key": "waits", "<": 3}]}, "answer": "wait"},
        {"when": {"key": "obstacle.living", "==": True}, "answer": "turn_back"},
        {"when": {"key": "obstacle.gap_m", ">": 0.8}, "answer": "go_around"},
    ]
}
"""Who answers as `rules`; where no rule fits, the next in the decision's `ask` is asked."""

CONVERSATION: Mapping[str, Any] = {
    "phrases": {"deliver [the] parcel": {}, "deliver [the] parcel [to] {destination_m} away": {}},
    "spoken": {"deliver the parcel {destination_m} away": {}, "deliver the parcel": {}},
    "questions": {"what is in (the|your) way": "obstacle.kind", "(is|was) the parcel *": "delivered"},
}
"""What people may order and ask in words of their own, with `run --talk`."""


class Corridor:
    """What is simulated: where the robot is, and what it carries."""

    position_m = 0.0
    has_parcel = True
    is_blocked = True

    def seen(self) -> dict[str, Any] | None:
        """What the detector reports within a metre and a half; None for nothing new."""
        return BOX if abs(BOX_AT_M - self.position_m) < 1.5 else None

    def move(self, to_m: float) -> None:
        """One step towards a place."""
        step_m = SPEED_M_S * STEP_S
        self.position_m += max(-step_m, min(step_m, to_m - self.position_m))


def robot() -> PythonRobot:
    """A robot for each run."""
    made = PythonRobot("delivery robot, simulated", rules=RULES, conversation=CONVERSATION)
    corridor = Corridor()

    made.fact("position_m", every_s=0.2)(lambda: round(corridor.position_m, 2))
    made.fact("delivered", every_s=0.5)(lambda: not corridor.has_parcel)
    made.fact("obstacle", every_s=0.2)(corridor.seen)

    @made.fact("battery", every_s=2)
    def battery() -> float:
        return 0.9

    @made.action("drive", uses=["base"])
    def drive(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Drive to a place; the mission cancels it when the way is blocked."""
        while abs(goal["to_m"] - corridor.position_m) > 0.01:
            if run.canceled:
                return run.cancel()
            if goal["to_m"] > corridor.position_m > BOX_AT_M - 1.0 and corridor.is_blocked:
                made.write("obstacle", corridor.seen())
                made.raise_event("blocked")
                run.sleep(30)  # a cancel ends the wait
                continue
            corridor.move(goal["to_m"])
            run.sleep(STEP_S)
        made.write("position_m", round(corridor.position_m, 2))
        return None

    @made.action("go_around", uses=["base"])
    def go_around(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Pass the box at a walk."""
        while corridor.position_m < BOX_AT_M + 0.4:
            if run.canceled:
                return run.cancel()
            corridor.move(BOX_AT_M + 0.5)
            run.sleep(2 * STEP_S)
        corridor.is_blocked = False
        return None

    @made.action("hand_over", uses=["tray"])
    def hand_over(goal: Mapping[str, Any], run: ActionRun) -> None:
        """Open the tray and wait until it is empty."""
        run.sleep(0.5)
        corridor.has_parcel = False
        made.write("delivered", True)

    return made

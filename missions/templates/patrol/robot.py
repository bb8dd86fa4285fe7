# SPDX-License-Identifier: Apache-2.0
"""The robot of the patrol, simulated: three places, and a door in the hall that is open and should not be.

Each function is called by its name in the mission. Put your robot's own calls into the bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions import PythonRobot
from rai_missions.connectors.python_robot import ActionRun

SIGHTS: Mapping[str, Mapping[str, Any]] = {
    "gate": {"what": "a closed gate", "unusual": False, "moving": False},
    "hall": {"what": "an open door", "unusual": True, "moving": False},
    "yard": {"what": "an empty yard", "unusual": False, "moving": False},
}
WAY_S = 0.5

RULES: dict[str, list[Mapping[str, Any]]] = {
    "judging": [
        {"when": {"key": "sight.moving", "==": True}, "answer": "call_guard"},
        {"when": {"key": "looks", "<": 2}, "answer": "look_again"},
        {"when": {"key": "sight.moving", "==": False}, "answer": "note"},
    ]
}
"""Who answers as `rules`; where no rule fits, the next in the decision's `ask` is asked."""

CONVERSATION: Mapping[str, Any] = {
    "phrases": {"(patrol|make (the|your) round|look at (the|all) places)": {}},
    "spoken": {"patrol all places": {}},
    "questions": {"what (do|can) you see *": "sight.what", "how many places are left": "left"},
}
"""What people may order and ask in words of their own, with `run --talk`."""


class Round:
    """What is simulated: where the robot is, and where it has looked."""

    at = "dock"

    def __init__(self) -> None:
        self.left = set(SIGHTS)

    def sight(self) -> Mapping[str, Any]:
        """What the camera shows."""
        return SIGHTS.get(self.at, {"what": "the dock", "unusual": False, "moving": False})


def robot() -> PythonRobot:
    """A robot for each run."""
    made, tour = PythonRobot("patrol robot, simulated", rules=RULES, conversation=CONVERSATION), Round()

    made.fact("at", every_s=0.5)(lambda: tour.at)
    made.fact("left", every_s=1)(lambda: len(tour.left))
    made.fact("sight", every_s=1)(tour.sight)

    @made.fact("battery", every_s=2)
    def battery() -> float:
        return 0.8

    @made.action("go_to", uses=["base"])
    def go_to(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Drive to a place; the mission cancels it when it wants the robot elsewhere."""
        run.sleep(WAY_S)
        if run.canceled:
            return run.cancel()
        tour.at = str(goal["place"])
        made.write("at", tour.at)
        return None

    @made.action("look", uses=["camera"])
    def look(goal: Mapping[str, Any], run: ActionRun) -> None:
        """Take a picture and report what it shows."""
        run.sleep(0.3)
        made.write("sight", tour.sight())
        tour.left.discard(tour.at)
        made.write("left", len(tour.left))

    @made.service("lights", repeat=True)
    def lights(request: Mapping[str, Any]) -> None:
        """Switch the lights on or off."""

    @made.service("radio")
    def radio(request: Mapping[str, Any]) -> None:
        """Call a person to a place."""

    return made

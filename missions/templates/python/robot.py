# SPDX-License-Identifier: Apache-2.0
"""The robot of the greenhouse, simulated: three beds, one dry, one wet and one in between.

Each function is called by its name in the mission. Put your robot's own calls into the bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions import PythonRobot
from rai_missions.connectors.python_robot import ActionRun

RULES: dict[str, list[Mapping[str, Any]]] = {
    "judging": [
        {"when": {"key": "moisture", "<": 0.45}, "answer": "water"},
        {"when": {"key": "moisture", ">=": 0.45}, "answer": "leave"},
    ]
}
"""Who answers as `rules`; where no rule fits, the next in the decision's `ask` is asked."""

CONVERSATION: Mapping[str, Any] = {
    "phrases": {"water [(the|all)] [the] beds": {}, "water [the] greenhouse": {}},
    "spoken": {"water the beds": {}},
    "questions": {"how many beds are [still] dry": "dry", "how (dry|wet) is the (soil|bed)": "moisture"},
}
"""What people may order and ask in words of their own, with `run --talk`."""


class Greenhouse:
    """What is simulated: the soil of each bed, the water in the tank, and where the robot is."""

    at = "door"
    tank_l = 0.5

    def __init__(self) -> None:
        self.moisture = {"herbs": 0.1, "tomatoes": 0.4, "beans": 0.8}

    def dry(self) -> int:
        """How many beds need water."""
        return sum(moisture < 0.3 for moisture in self.moisture.values())


def robot() -> PythonRobot:
    """A robot for each run."""
    made, house = PythonRobot("greenhouse robot, simulated", rules=RULES, conversation=CONVERSATION), Greenhouse()

    made.fact("at", every_s=0.5)(lambda: house.at)
    made.fact("moisture", every_s=0.2)(lambda: house.moisture.get(house.at, 1.0))
    made.fact("tank_l", every_s=1)(lambda: house.tank_l)
    made.fact("dry", every_s=1)(house.dry)

    @made.action("go_to", uses=["base"])
    def go_to(goal: Mapping[str, Any], run: ActionRun) -> Any:
        """Drive to a bed; the mission cancels it when it wants the robot elsewhere."""
        run.sleep(0.4)
        if run.canceled:
            return run.cancel()
        house.at = str(goal["bed"])
        made.write("at", house.at)
        return None

    @made.action("pour", uses=["pump"])
    def pour(goal: Mapping[str, Any], run: ActionRun) -> None:
        """Water the bed at which the robot is."""
        run.sleep(0.4)
        house.tank_l -= float(goal["litres"])
        house.moisture[house.at] = 0.7
        made.write("tank_l", house.tank_l)
        made.write("dry", house.dry())

    @made.service("refill")
    def refill(request: Mapping[str, Any]) -> None:
        """Fill the tank."""
        house.tank_l = 5.0
        made.write("tank_l", house.tank_l)

    @made.service("close_valve", repeat=True)
    def close_valve(request: Mapping[str, Any]) -> None:
        """Close the valve."""

    return made

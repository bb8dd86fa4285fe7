# SPDX-License-Identifier: Apache-2.0
"""The shipped patrol in a simulated house of one's own choice, with a look at what the robot has done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import Prepared, Setting, prepare
from rai_missions.event import Event
from rai_missions.json_text import parse_json
from rai_missions.robot import Robot
from rai_missions.runner import Result
from rai_missions.step import Step

ROSBOT = Path(__file__).parents[2] / "missions" / "rosbot"


class Patrol:
    """One run of the patrol.

    Args:
        house: What the world takes; no camera unless it says so.
        moments: When → what happens then.
        words: Fields of `Setting`.
    """

    def __init__(
        self, house: Mapping[str, Any], moments: Mapping[float, Callable[[Patrol], object]], **words: Any
    ) -> None:
        profile = parse_json((ROSBOT / "robot.sim.json").read_bytes(), "robot.sim.json")
        profile["connector"] |= {"camera": False, **house}
        self.moments, self.steps = sorted(moments.items()), list[Step]()
        self.prepared: Prepared = prepare(
            Setting(ROSBOT / "mission.json", Robot.model_validate(profile), on_step=self._see, **words)
        )
        self.world: Any = self.prepared.world
        self.runner = self.prepared.runner

    def _see(self, step: Step) -> None:
        self.steps.append(step)
        while self.moments and self.moments[0][0] <= step.at:
            self.moments.pop(0)[1](self)

    def run(self) -> Result:
        return self.runner.run()

    def post(self, name: str) -> None:
        self.runner.post(Event(name, self.runner.clock.now()))

    @property
    def entered(self) -> list[str]:
        return [name for step in self.steps for name in step.entered]

    @property
    def answers(self) -> list[str]:
        """The options that were taken."""
        notes = [note for step in self.steps for note in step.notes if note.endswith(": accepted")]
        return [note.split("'")[1] for note in notes]


@pytest.fixture
def patrol() -> Any:
    """Makes patrols, and closes them."""
    made: list[Patrol] = []

    def make(
        moments: Mapping[float, Callable[[Patrol], object]] | None = None,
        words: Mapping[str, Any] | None = None,
        **house: Any,
    ) -> Patrol:
        made.append(Patrol(house, moments or {}, **(words or {})))
        return made[-1]

    yield make
    for one in made:
        one.prepared.close()

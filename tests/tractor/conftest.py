# SPDX-License-Identifier: Apache-2.0
"""The shipped mission in a simulated orchard of one's own choice, with a look at what the tractor has done."""

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

TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"


class Drive:
    """One run of the tractor's mission.

    Args:
        orchard: What the world takes; no camera, but the detector, unless it says so.
        moments: When → what happens then.
        events_of: The profile whose anomaly is listened for.
        words: Fields of `Setting`.
    """

    def __init__(
        self, orchard: Mapping[str, Any], moments: Mapping[float, Callable[[Drive], object]], *,
        events_of: str = "robot.sim.json", **words: Any,
    ) -> None:  # fmt: skip
        profile = parse_json((TRACTOR / "robot.sim.json").read_bytes(), "robot.sim.json")
        profile["connector"] |= orchard
        profile["events"]["anomaly"] = parse_json((TRACTOR / events_of).read_bytes(), events_of)["events"]["anomaly"]
        self.moments, self.steps = sorted(moments.items()), list[Step]()
        alleys = {"alleys": orchard["alleys"]} if "alleys" in orchard else {}
        words = {"arguments": alleys, **words}
        self.prepared: Prepared = prepare(
            Setting(TRACTOR / "mission.json", Robot.model_validate(profile), on_step=self._see, **words)
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
def drive() -> Any:
    """Makes drives, and closes them."""
    made: list[Drive] = []

    def make(
        moments: Mapping[float, Callable[[Drive], object]] | None = None,
        words: Mapping[str, Any] | None = None,
        **orchard: Any,
    ) -> Drive:
        made.append(Drive(orchard, moments or {}, **(words or {})))
        return made[-1]

    yield make
    for one in made:
        one.prepared.close()

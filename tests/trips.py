# SPDX-License-Identifier: Apache-2.0
"""One run of a shipped mission in its simulated world, with moments of one's own and a look at what was done."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from rai_missions.agents.mission import PreparedRun, RunConfig, prepare
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.json_reader import parse_json
from rai_missions.profile import Robot
from rai_missions.runtime.result import Result

__all__ = ("Moments", "Trip", "profile_of", "taken_options", "trips")

Moments = Mapping[float, Callable[[Any], object]]
"""When → what happens then, to the trip."""


def profile_of(mission: Path, name: str = "robot.sim.json") -> dict[str, Any]:
    """A shipped profile, as JSON has it."""
    profile: dict[str, Any] = parse_json((mission / name).read_bytes(), name)
    return profile


class Trip:
    """A run, prepared.

    Args:
        mission: The folder of the shipped mission.
        profile: The robot, as JSON has it.
        moments: When → what happens then.
        file: The mission in it.
        words: Fields of `RunConfig`.
    """

    def __init__(
        self, mission: Path, profile: Mapping[str, Any], moments: Moments, *, file: str = "mission.json", **words: Any
    ) -> None:
        self.moments, self.steps = sorted(moments.items()), list[Step]()
        self.prepared: PreparedRun = prepare(
            RunConfig(mission / file, Robot.model_validate(profile), on_step=self._see, **words)
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
        self.runner.post(Event(name, self.runner.view.now()))

    @property
    def entered(self) -> list[str]:
        return [name for step in self.steps for name in step.entered]

    @property
    def answers(self) -> list[str]:
        """The options that were taken."""
        return taken_options(self.steps)


def taken_options(steps: Iterable[Step]) -> list[str]:
    """The options that were proposed and taken, in their order."""
    return [verdict.option for step in steps for verdict in step.verdicts if verdict.accepted]


Kind = TypeVar("Kind", bound=Trip)


def trips(kind: Callable[..., Kind]) -> Iterator[Callable[..., Kind]]:
    """For a fixture: makes trips of a kind, and closes them."""
    made: list[Kind] = []

    def make(moments: Moments | None = None, words: Mapping[str, Any] | None = None, **world: Any) -> Kind:
        made.append(kind(world, moments or {}, **(words or {})))
        return made[-1]

    yield make
    for one in made:
        one.prepared.close()

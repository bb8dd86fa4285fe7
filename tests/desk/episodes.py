# SPDX-License-Identifier: Apache-2.0
"""One request at one desk, run and judged: for tests, drills and the benchmark."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.engine.step import Step
from rai_missions.planning import Goal, read_goal
from rai_missions.worlds.desk.truth import DeskTruth
from tests.desk.judge import is_so, true_names
from tests.trips import Moments, Trip, profile_of

__all__ = ("DESK_MISSIONS", "ArrangeTrip", "Episode", "episode")

DESK_MISSIONS = Path(__file__).parents[2] / "missions" / "desk"


class ArrangeTrip(Trip):
    """One run of the mission at a desk of one's own choice.

    Args:
        world: What the world takes; no camera unless named here.
        moments: When → what happens then.
        words: Fields of `RunConfig`.
    """

    def __init__(self, world: Mapping[str, Any], moments: Moments | None = None, **words: Any) -> None:
        self.seen: dict[str, Any] = {}
        self.wanted: Any = None
        self.report = ""
        self.truth: DeskTruth | None = None
        self.first: tuple[dict[str, Any], DeskTruth] | None = None
        profile = profile_of(DESK_MISSIONS)
        profile["connector"] |= {"camera": False, **world}
        super().__init__(DESK_MISSIONS, profile, moments or {}, file=words.pop("file", "arrange.json"), **words)

    def _see(self, step: Step) -> None:
        for name, value in step.writes:
            if name == "objects":
                self.seen, self.truth = value, self.world.truth()
            elif name.rpartition("/")[2] == "report":
                self.report = value
            elif name.rpartition("/")[2] == "reading":
                self.report = value.get("question") or value.get("about") or ""
            elif name.rpartition("/")[2] == "wanted":
                self.wanted = value
                self.first = (self.seen, self.world.truth())
        super()._see(step)


class Episode(NamedTuple):
    """How one request ended, and what is so."""

    outcome: str
    state: str
    is_so: bool | None
    """By the truth at the last picture used; None where no goal was read."""
    moves: int
    simulated_s: float
    cpu_s: float
    why: str

    @property
    def is_false_success(self) -> bool:
        return self.outcome == "succeeded" and not self.is_so

    @property
    def is_false_failure(self) -> bool:
        return self.outcome != "succeeded" and self.is_so is True


def episode(request: str, world: Mapping[str, Any], moments: Moments | None = None, **words: Any) -> Episode:
    """Run a request to its end, and judge it."""
    begun = time.process_time()
    one = ArrangeTrip(world, moments, arguments={"request": request}, speed=None, **words)
    try:
        result = one.run()
        found = judged(one)
        return Episode(
            result.outcome,
            "/".join(result.state),
            found,
            one.entered.count("moving"),
            one.world.at,
            time.process_time() - begun,
            one.report or result.why,
        )
    finally:
        one.prepared.close()


def judged(one: ArrangeTrip) -> bool | None:
    """Whether what a run wanted is so by the truth; None where it never came to want anything."""
    if one.wanted is None or one.first is None or one.truth is None:
        return None
    goal = read_goal(one.wanted)
    if not isinstance(goal, Goal):
        return None
    return is_so(goal, one.seen, true_names(*one.first), one.truth)

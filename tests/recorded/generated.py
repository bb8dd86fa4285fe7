# SPDX-License-Identifier: Apache-2.0
"""Runs of generated missions and of generated trees, recorded: each whole, and the missions with deaths as well."""

from __future__ import annotations

import random
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as fixed

from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from tests.recorded.small import Run
from tests.replay.farm import FARMER, Farm
from tests.replay.mortal import ONLOOKER, Fate, Wish, live
from tests.replay.trial import tried, worth_a_trial
from tests.rigs.runs import ReplyingAnswerer
from tests.trees.growing import FACTS, rich_trees

__all__ = ("generated",)

MISSIONS, TREES = 30, 16
SEED, EXAMPLES = 11, 1200
MOST_CHARACTERS = 7500
"""A mission that is written with more is left out: its runs would be large."""
TREE_ENDS_S, MOST_STEPS = 15.0, 40


def generated() -> Iterator[Run]:
    """All of them."""
    found = [each for each in worth_a_trial(SEED, EXAMPLES) if len(dump(each)) <= MOST_CHARACTERS]
    for number, mission in enumerate(varied(found)[:MISSIONS]):
        kind = "killed" if number % 2 else "whole"
        yield f"generated/{number:02}-{kind}", trial(mission, number, kind)
    for number, mission in enumerate(varied(groves())[:TREES]):
        yield f"trees/{number:02}", grown(mission, number)


def varied(missions: list[Mission]) -> list[Mission]:
    """Missions in an order in which each adds as many words of the format as it can to those before it."""
    left, known, ordered = [(mission, words_of(mission)) for mission in missions], set[str](), list[Mission]()
    while left:
        best = max(range(len(left)), key=lambda at: (len(left[at][1] - known), -at))
        mission, words = left.pop(best)
        known = known | words if words - known else set(words)  # all seen: begin again
        ordered.append(mission)
    return ordered


def words_of(mission: Mission) -> set[str]:
    """The words of the format that a mission uses, and what follows each."""
    found = set[str]()

    def look(value: Any, word: str) -> None:
        if isinstance(value, dict):
            for key, inside in value.items():
                found.add(f"{word}/{key}")
                look(inside, key)
        elif isinstance(value, list):
            for each in value:
                look(each, word)

    look(mission.model_dump(), "")
    return found


def trial(mission: Mission, seed: int, kind: str) -> Callable[[Path], object]:
    """Records a run without a death, or one with several."""

    def record(path: Path) -> None:
        with tempfile.TemporaryDirectory() as folder:
            tried(Path(folder), mission, seed)
            shutil.copyfile(Path(folder) / ("whole.journal" if kind == "whole" else "run.journal"), path)

    return record


KEYS = {
    **{name: {"type": "boolean", "source": "robot", "max_age_s": 3, "optional": True} for name in ("a", "b")},
    "c": {"type": "boolean", "source": "mission", "initial": False},
    "n": {"type": "integer", "source": "mission", "initial": 0},
    "m": {"type": "integer", "source": "argument", "initial": 2},
    "spoken": {"type": "string", "source": "mission", "initial": ""},
}
FORESTER = FARMER.model_copy(
    update={
        "blackboard": {
            name: FARMER.blackboard["clear"].model_copy(update={"topic": f"/{name}"}) for name in ("a", "b")
        },
        "actions": {"drive": FARMER.actions["drive"]},
        "topics": {"spoken": FARMER.topics["lamp"]},
        "events": {"poke": FARMER.events["poke"]},
    }
)


def groves() -> list[Mission]:
    """Missions of one tree each, with everything that a tree can have."""
    found = list[Mission]()

    @fixed(SEED)
    @settings(
        max_examples=150,
        database=None,
        phases=[Phase.generate],
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(rich_trees)
    def draw(tree: dict[str, Any]) -> None:
        ends = [{"on": "succeeded", "to": "done"}, {"on": ["failed", "timed_out"], "to": "again"}]
        again = [{"after_s": 1, "to": "growing"}]
        found.append(
            Mission.model_validate(
                {
                    "name": "grove",
                    "blackboard": KEYS,
                    "events": {"poke": {}},
                    "initial": "growing",
                    "states": {
                        "growing": {"tree": tree, "timeout_s": 8, "transitions": ends},
                        "again": {"transitions": again},
                        "done": {"final": "canceled"},
                    },
                }
            )
        )

    draw()
    return found


class Grove(Farm):
    """A land whose facts come and go by chance."""

    def __init__(self, seed: int) -> None:
        self._chance = random.Random(seed)
        super().__init__(
            [Wish(TREE_ENDS_S, lambda runner: runner.cancel(), lambda runner: runner.view.outcome is not None)],
            {"drive": self._chance.choice([0.5, 2.0, 5.0])},
            {"drive": self._chance.choice(["succeeded", "failed"])},
        )

    def look(self, step: Step) -> None:
        if step.seq > MOST_STEPS and step.outcome is None and self.runner is not None:
            self.runner.kill(ONLOOKER)

    def live_on(self) -> None:
        super().live_on()
        for name in FACTS[:2]:
            if self._chance.random() < 0.3:
                self.connector.publish(f"/{name}", "std_msgs/msg/Bool", {"data": self._chance.random() < 0.6})
        if self.runner is not None and self._chance.random() < 0.1:
            self.runner.post(Event("poke", self.runner.view.now()))


def by_chance(seed: int) -> ReplyingAnswerer:
    """Answers with an option by chance, sometimes with one that is none."""
    chance = random.Random(seed)
    return ReplyingAnswerer(lambda question: chance.choice(["left", "right", "up"]))


def grown(mission: Mission, seed: int) -> Callable[[Path], object]:
    who = {name: by_chance(seed) for name in ("agent", "operator")}
    return lambda path: live(path, Grove(seed), mission, FORESTER, who, Fate())

# SPDX-License-Identifier: Apache-2.0
"""A gripper that reports for ever that it holds something: the arm is moved a few times, and the mission ends."""

from __future__ import annotations

import random

import pytest

from rai_missions.check.scc import knots
from rai_missions.engine import Chart
from rai_missions.engine.step import StartGoal, Step
from rai_missions.event import Event, Tick
from rai_missions.mission.files import load
from rai_missions.states import Action, Tree
from rai_missions.states.effects import Set
from tests.desk.episodes import DESK_MISSIONS
from tests.planning.scenes import thing

LONGEST_S, PERIOD_S = 2_000.0, 0.4
MOST_MOVES = 12


class HeldRun:
    """A desk of two cubes that never change, and an arm whose moves end as drawn.

    Args:
        seed: Of how they end.
        since: After so many moves the gripper holds something for ever.
    """

    def __init__(self, seed: int, since: int) -> None:
        self.rng, self.since, self.at = random.Random(f"held {seed}"), since, 0.0
        self.share = (1.0, 0.7, 0.4)[seed % 3]
        """Of the moves that succeed by their server."""
        self.moves: list[str] = []
        self.chart = Chart(load(DESK_MISSIONS / "arrange.json"))

    def run(self) -> Chart:
        self.chart.write("request", "put the red cube on the blue cube", 0.0)
        self._see()
        self._follow(self.chart.start(0.0))
        while self.chart.outcome is None and self.at < LONGEST_S:
            self.at += PERIOD_S
            self._see()
            if self.chart.outcome is None:
                self._follow(self.chart.send(Tick(self.at)))
        return self.chart

    def _see(self) -> None:
        is_holding = len(self.moves) >= self.since
        things = [
            thing(name, 0.5, y, looks=30, agreeing=24).model_dump(mode="json") | {"colour": name.partition("_")[0]}
            for name, y in (("red_cube", 0.1), ("blue_cube", -0.12))
        ]
        seen = {
            "things": things,
            "gripper": "holding" if is_holding else "empty",
            "unsure": 0,
            "looks": 30,
            "stamp_s": self.at,
        }
        felt = {"width_m": 0.04, "holding": is_holding, "left_n": 1.0, "right_n": 1.0}
        for key, value in (("objects", seen), ("gripper", felt)):
            if self.chart.outcome is None:
                self._follow(self.chart.write(key, value, self.at))

    def _follow(self, step: Step) -> None:
        for effect in step.effects:
            if isinstance(effect, StartGoal) and self.chart.outcome is None:
                self.moves.append(effect.action)
                self._follow(self.chart.send(Event("accepted", self.at, {}, "accepted", effect.number)))
                end = "succeeded" if self.rng.random() < self.share else "failed"
                if self.chart.outcome is None:
                    self._follow(self.chart.send(Event(end, self.at, {}, "result", effect.number)))


@pytest.mark.parametrize("since", [0, 1, 2])
def test_a_gripper_that_holds_something_for_ever_ends_the_mission(since: int) -> None:
    for seed in range(3):
        run = HeldRun(seed, since)
        assert run.run().outcome == "failed", (seed, run.moves)
        assert len(run.moves) <= MOST_MOVES, (seed, run.moves)


@pytest.mark.parametrize("name", ["arrange", "sort", "stack", "swap"])
def test_every_cycle_that_moves_the_arm_is_counted(name: str) -> None:
    """In each cycle of states some key is counted and, in the same cycle, never set back."""
    mission = load(DESK_MISSIONS / f"{name}.json")
    acting = {each for _, each, state in mission.walk() if isinstance(state, Action | Tree)}
    edges = [
        (each, to, frozenset(effect for effect in transition.do if isinstance(effect, Set)))
        for _, each, state in mission.walk()
        for transition in state.transitions
        for to in transition.to
    ]
    parts = [edges]
    while parts:
        part = parts.pop()
        after: dict[str, list[str]] = {}
        for source, target, _ in part:
            after.setdefault(source, []).append(target)
            after.setdefault(target, [])
        for knot in knots(after):
            inner = [each for each in part if each[0] in knot and each[1] in knot]
            if not inner or acting.isdisjoint(knot):
                continue
            effects = [effect for *_, found in inner for effect in found]
            counted = {each.set for each in effects if each.add} - {each.set for each in effects if not each.add}
            left = [each for each in inner if all(effect.set not in counted for effect in each[2])]
            assert len(left) < len(inner), sorted(knot)
            parts.append(left)

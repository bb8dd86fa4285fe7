# SPDX-License-Identifier: Apache-2.0
"""A behaviour written in Python runs next to its mission, on the run's clock."""

from __future__ import annotations

from typing import Any, ClassVar

import py_trees
import pytest

from rai_missions.mission.mission import Mission
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner
from rai_missions.states import Final, Transition, Tree
from rai_missions.states.tree import Behaviour, Sequence, Wait


class Count(py_trees.behaviour.Behaviour):
    """Runs for a number of ticks."""

    made: ClassVar[list[Count]] = []

    def __init__(self, ticks: int, ends: py_trees.common.Status) -> None:
        super().__init__("count")
        self.left, self.ends, self.stopped = ticks, ends, False
        Count.made.append(self)

    def update(self) -> py_trees.common.Status:
        self.left -= 1
        return self.ends if self.left <= 0 else py_trees.common.Status.RUNNING

    def terminate(self, new_status: py_trees.common.Status) -> None:
        self.stopped = self.stopped or new_status == py_trees.common.Status.INVALID


def ran(ticks: int, ends: py_trees.common.Status = py_trees.common.Status.SUCCESS, **words: Any) -> Result:
    tree = Sequence([Behaviour(lambda: Count(ticks, ends), 0.5), Wait(1.0)])
    transitions = [Transition("succeeded", to="good"), Transition(["failed", "timed_out"], to="bad")]
    mission = Mission(
        "counting",
        initial="work",
        states={
            "work": Tree(tree, timeout_s=60, transitions=transitions, **words),
            "good": Final("aborted"),
            "bad": Final("failed"),
        },
    )
    return Runner(mission, clock=SimulatedClock()).run()


def test_a_behaviour_is_ticked_at_its_pace_until_it_succeeds() -> None:
    result = ran(5)
    assert result.state == ("good",)
    assert result.duration_s == pytest.approx(4 * 0.5 + 1.0)


def test_its_failure_is_its_leaf_s() -> None:
    assert ran(3, py_trees.common.Status.FAILURE).state == ("bad",)


def test_one_that_continues_when_its_state_is_left_is_interrupted() -> None:
    Count.made.clear()
    assert ran(10_000).state == ("bad",)
    assert [each.stopped for each in Count.made] == [True]

# SPDX-License-Identifier: Apache-2.0
"""A proof explores the operator's stop wherever it does more than a pause."""

from __future__ import annotations

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Edge, Space
from tests.rigs.charts import mission

STOP = "the operator stops the robot"


class GoalSpace(Space):
    """A space that remembers what leads to which phases of goals, and in which mode."""

    def __init__(self, keep: frozenset[str]) -> None:
        made = mission({"a": {"action": "go", "timeout_s": 60}})
        super().__init__(Environment(made, robot_facts=RobotFacts(keep=keep)), 500)
        self.found: set[tuple[str, str, tuple[str, ...]]] = set()

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        super().learn(source, way, is_paused=is_paused)
        state = self.environment.chart.state
        self.found.add((way.words, state.mode, tuple(goal.phase for goal in state.goals.values())))


def test_a_stop_is_explored_where_a_pause_keeps_a_goal_both_while_it_runs_and_while_it_is_paused() -> None:
    space = GoalSpace(frozenset({"go"}))
    space.explore()
    assert space.is_whole
    assert ("the operator pauses", "paused", ("running",)) in space.found, "the pause keeps it"
    assert (STOP, "paused", ("canceling",)) in space.found


def test_a_stop_that_is_a_pause_is_not_explored_twice() -> None:
    space = GoalSpace(frozenset())
    space.explore()
    assert STOP not in {way for way, _, _ in space.found}

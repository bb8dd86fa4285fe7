# SPDX-License-Identifier: Apache-2.0
"""An event is handled at its own instant: one jump in time is many small ticks, and no one looks too seldom."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.compiled.configuration import CompiledMove
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.semantics import macrostep as microsteps
from rai_missions.engine.semantics import timing as instants
from rai_missions.engine.semantics.macrostep import complete
from rai_missions.engine.semantics.running import poll
from rai_missions.engine.semantics.stepping import close
from rai_missions.engine.state import RunState
from rai_missions.engine.step import Move, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.laws.drawn import GRID_S, DrawnEvent, document, happenings, is_far, robot_facts
from tests.rigs.charts import ScriptedRobot, chart, sent, ticked, transition

Json = dict[str, Any]
PASSING = ("seq", "_wake", "_quick", "_listening", "_asked")
"""What a snapshot has of how the run was looked at, not of the run; who was asked for control depends on the steps."""
AFTER_S = 5.0
"""Seconds that are still watched once everything has happened."""
seeds = st.integers(0, 2**32)


class Trail(Surroundings):
    """Notes at which instant each move is made."""

    def __init__(self) -> None:
        self.moves: list[tuple[float, Move]] = []

    def before_move(self, state: RunState, move: CompiledMove) -> bool:
        self.moves.append((state.at, move.value))
        return True


class Recorded(Chart):
    """A chart that notes at which instant each move was made."""

    def __init__(self, mission: Mission, ticker: Any, **given: Any) -> None:
        self.notes = Trail()
        super().__init__(mission, ticker, surroundings=self.notes, **given)

    @property
    def trail(self) -> list[tuple[float, Move]]:
        return self.notes.moves


class Diligent(Recorded):
    """The same chart without its economies: it looks at everything, after each event and each instant of the grid."""

    def send(self, event: Event) -> Step:
        program, state = self.program, self.state
        state.quick, state.watched = False, frozenset({"*"})
        step = super().send(event)
        if state.outcome is None and state.mode in ("running", "canceling"):
            nodes = program.graph.nodes
            state.draft.due = frozenset(name for name in state.running if nodes[name].state.word != "tree")
            poll(program, state)
            complete(program, state, None)
            close(program, state, Tick(state.at))
        return step


def play(
    seed: int, kind: type[Recorded], *, ticks: bool, events: list[Event] | None = None
) -> tuple[Recorded, list[Event], list[Any]]:
    """A run of what a number draws.

    Args:
        seed: The number.
        kind: The chart.
        ticks: Time is reported at each instant of the grid; else in one jump from event to event.
        events: Raw events to repeat; drawn by default.
    """
    rng = random.Random(seed)
    made, script, robot = document(rng), happenings(rng), robot_facts(rng)
    one, answers, seen = started(made, robot, kind), ScriptedRobot("agent"), list[Any]()
    answers.follow(one.start(0.0))
    for happening in [*script, DrawnEvent(("tick",), script[-1].at + AFTER_S)]:
        while ticks and one.at + GRID_S < happening.at:
            answers.follow(one.send(Tick(one.at + GRID_S)))
        event = events[len(seen)] if events is not None else answers.event(*happening)
        answers.follow(one.send(event))
        seen.append((event, one.active, one.outcome, dict(one.view.board)))
    return one, [each[0] for each in seen], seen


def started(made: Json, robot: RobotFacts, kind: type[Recorded]) -> Recorded:
    return kind(Mission.model_validate(made), CompiledTrees(), robot_facts=robot, named={"is_far": is_far})


def remembered(one: Chart) -> Json:
    return {name: value for name, value in one.snapshot().items() if name not in PASSING}


def agree(seed: int, kind: type[Recorded]) -> bool:
    """A jumping chart, given the events of a chart that is ticked, makes the same moves at the same instants.

    Returns:
        Whether the two can be compared: where a cycle without end is noticed depends on the step.
    """
    with pytest.MonkeyPatch.context() as limits:  # what goes round for ever is found sooner
        for module in (microsteps, instants):
            limits.setattr(module, "MOST_MICROSTEPS", 100)
        small, events, seen = play(seed, kind, ticks=True)
        far, _, others = play(seed, Recorded, ticks=False, events=events)
    if "cycle" in (small.cause, far.cause):
        return False
    assert others == seen
    assert remembered(far) == remembered(small)
    return True


@given(seeds)
@settings(max_examples=15)
def test_one_jump_in_time_is_many_small_ticks(seed: int) -> None:
    assume(agree(seed, Recorded))


@given(seeds)
@settings(max_examples=15)
def test_who_looks_at_everything_all_the_time_sees_nothing_else_happen(seed: int) -> None:
    assume(agree(seed, Diligent))


@pytest.mark.drill
@pytest.mark.parametrize("kind", [Recorded, Diligent])
def test_ten_thousand_runs_agree(kind: type[Recorded]) -> None:
    compared = sum(agree(seed, kind) for seed in range(10_000))
    assert compared > 8_500


# -- the smallest cases -----------------------------------------------------------------------------------------------


def test_a_write_that_comes_after_a_due_timer_is_looked_at() -> None:
    states = {
        "s1": {"transitions": [transition(to="s2", after_s=1)]},
        "s2": {"transitions": [transition(to="s3", when={"key": "a", "==": True})]},
        "s3": {},
    }
    made = chart(states, blackboard={"a": {"type": "boolean"}})
    assert made.write("a", True, at=2.0).entered == ("s2", "s3")


def test_a_guard_that_must_have_held_is_watched_where_only_an_event_asks_for_it() -> None:
    states = {"a": {"transitions": [transition("e", "b", when={"held": {"fresh": "x"}, "for_s": 2})]}, "b": {}}
    keys = {"x": {"type": "integer", "max_age_s": 1}}
    made = chart(states, blackboard=keys)
    made.write("x", 1, at=0.5)
    made.write("x", 1, at=2.0)  # stale for half a second before
    assert sent(made, "e", at=2.75).entered == ()


def test_a_final_inside_that_waits_for_its_requires_sees_the_instant_at_which_time_makes_it_true() -> None:
    inside = {"x": {"final": "succeeded", "requires": {"elapsed_s": 1}}}
    states = {"a": {"initial": "x", "states": inside, "transitions": [transition("succeeded", "b")]}, "b": {}}
    made = chart(states, settle_s=5)
    assert ticked(made, 1.5).entered == ("b",)


def test_leaving_a_state_wakes_a_tree_that_asks_for_it() -> None:
    tree = {"eternal_guard": {"in": "x1"}, "child": {"wait_s": 60}}
    regions = {
        "r1": {"initial": "x1", "states": {"x1": {"transitions": [transition("e", "x2")]}, "x2": {}}},
        "r2": {"initial": "t", "states": {"t": {"tree": tree, "transitions": [transition("failed", "u")]}, "u": {}}},
    }
    made = Chart(mission_of(regions), CompiledTrees())
    made.start(0.0)
    assert "u" in made.send(Event("e", 1.0)).entered


@pytest.mark.parametrize("settle_s", [0, 9])
def test_entering_a_state_wakes_an_action_whose_achieved_asks_for_it(settle_s: float) -> None:
    action = {"action": "go", "achieved": {"in": "x2"}, "settle_s": settle_s}
    states = {
        "t": {**action, "transitions": [transition("succeeded", "u"), transition("unverified", "v")]},
        "u": {},
        "v": {},
    }
    regions = {
        "r1": {"initial": "x1", "states": {"x1": {"transitions": [transition("e", "x2")]}, "x2": {}}},
        "r2": {"initial": "t", "states": states},
    }
    made = Chart(mission_of(regions))
    made.start(0.0)
    (number,) = made.awaited
    made.send(Event("succeeded", 1.0, {}, "result", number))
    made.send(Event("e", 2.0))
    assert ("u" in made.active) is (settle_s > 0)


def mission_of(regions: Json) -> Mission:
    states = {"p": {"parallel": regions}}
    return Mission.model_validate({"name": "tried", "initial": "p", "states": states, "events": ["e"]})

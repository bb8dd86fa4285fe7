# SPDX-License-Identifier: Apache-2.0
"""What holds for every chart, whatever happens to it."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import CancelGoal, StartGoal, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.oracles.documents import Taste, charts, lineage, scripts
from tests.rigs.charts import ScriptedRobot
from tests.strategies import EVENTS, KEYS, OPTIONS, SIGHTS, mission_documents

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck))
TIMED = Taste(delayed=True, root_transitions=True, wildcard=True, outcomes=True)


# -- what happens ----------------------------------------------------------------------------------------------


def values(key: str) -> st.SearchStrategy[Any]:
    kinds: dict[str, st.SearchStrategy[Any]] = {
        "integer": st.integers(0, 3), "boolean": st.booleans(), "number": st.sampled_from([0.1, 0.5]),
        "string": st.sampled_from(["a", "b"]), "list": st.lists(st.sampled_from(["a", "b"]), max_size=2),
        "pose": st.just({"x": 1.0, "y": 0.0}),
        "object": st.fixed_dictionaries(
            {"kind": st.just("log"), "height_m": st.sampled_from([0.1, 0.3]), "living": st.booleans()}
        ),
    }  # fmt: skip
    return st.sampled_from(SIGHTS) if key == "objects" else kinds[KEYS[key]["type"]]


def writes() -> st.SearchStrategy[tuple[Any, ...]]:
    return st.sampled_from(sorted(KEYS)).flatmap(lambda key: st.tuples(st.just("write"), st.just(key), values(key)))


def happenings(*, commands: bool = True) -> st.SearchStrategy[list[tuple[Any, ...]]]:
    """Raw events; numbers are reported from what the chart has started, as (how far back) in the list of them."""
    back = st.integers(0, 3)
    results = st.sampled_from(["succeeded", "failed", "canceled", "rejected"])
    kinds: list[st.SearchStrategy[tuple[Any, ...]]] = [
        st.tuples(st.just("event"), st.sampled_from(EVENTS)),
        st.tuples(st.just("tick"), st.just("")),
        writes(),
        st.tuples(st.just("accepted"), back),
        st.tuples(st.just("result"), back, results),
        st.tuples(st.just("proposal"), back, st.sampled_from([*OPTIONS, "nonsense"])),
        st.tuples(st.just("control"), st.sampled_from(["autonomy", "agent", "operator", "nobody"])),
    ]
    if commands:
        kinds.append(
            st.tuples(st.just("command"), st.sampled_from(["pause", "stop", "resume", "resume", "cancel", "kill"]))
        )
    waits = st.sampled_from([0.0, 0.0, 0.5, 2.0, 6.0, 25.0])
    return st.lists(st.tuples(st.one_of(kinds), waits), max_size=14)


def ticker() -> Any:
    return CompiledTrees()


def run(document: Json, script: list[tuple[Any, float]], *, fresh: bool = False) -> tuple[Chart, list[Step]]:
    """Let it all happen; with `fresh`, each event to a new chart that is restored from the last one's snapshot."""
    mission = Mission.model_validate(document)
    chart, robot, at = Chart(mission, ticker()), ScriptedRobot(), 0.0
    steps = [robot.follow(chart.start(0.0))]
    for drawn, wait in script:
        at += wait
        if fresh:
            chart = Chart.restore(mission, copy.deepcopy(dict(chart.snapshot())), ticker())
        steps.append(robot.follow(chart.send(robot.event(drawn, at))))
    return chart, steps


def comparable(step: Step) -> Step:
    """A step without the instant at which to wake: a chart may wake too early, never too late."""
    return step._replace(wake_at=None)


# -- the graph -------------------------------------------------------------------------------------------------


def assert_legal(document: Json, active: frozenset[str]) -> None:
    """One child a compound state, all regions of a parallel one, and nothing without what it is in."""
    states, above = lineage(document)
    assert all(set(above[name]) <= active for name in active)
    assert not any("history" in states[name] for name in active)
    for name, state in [("", document), *((name, states[name]) for name in active)]:
        if "parallel" in state:
            assert set(state["parallel"]) <= active
        elif "states" in state:
            inside = [child for child in state["states"] if child in active]
            assert len(inside) == 1 or ("each" in state and not inside), name


def assert_accounted(before: frozenset[str], step: Step, after: frozenset[str]) -> None:
    """What the moves state was left and entered is what has changed."""
    now = set(before)
    for move in step.moves:
        assert set(move.exited) <= now
        now -= set(move.exited)
        assert not now & set(move.entered)
        now |= set(move.entered)
    assert now == after


@lenient
@given(mission_documents(), happenings())
def test_no_event_leaves_the_graph_and_nothing_raises(document: Json, script: list[tuple[Any, float]]) -> None:
    mission, robot, at = Mission.model_validate(document), ScriptedRobot(), 0.0
    chart, names = Chart(mission, ticker()), [name for _, name, _ in mission.walk()]
    before, outcome, step = frozenset[str](), None, chart.start(0.0)
    for drawn, wait in [(None, 0.0), *script]:
        at += wait
        if drawn is not None:
            step = chart.send(robot.event(drawn, at))
        robot.follow(step)
        assert_accounted(before, step, chart.active)
        assert_legal(document, chart.active)
        assert chart.active_in_order == tuple(name for name in names if name in chart.active)
        assert outcome in (None, chart.outcome)
        assert not step.ignored or chart.active == before
        assert step.wake_at is None or step.wake_at >= chart.at
        before, outcome = chart.active, chart.outcome


@lenient
@given(mission_documents(), happenings())
def test_the_same_events_give_the_same_steps(document: Json, script: list[tuple[Any, float]]) -> None:
    assert run(document, script)[1] == run(document, script)[1]


@lenient
@given(mission_documents(), happenings())
def test_a_chart_restored_before_every_event_does_the_same(document: Json, script: list[tuple[Any, float]]) -> None:
    steps, others = run(document, script)[1], run(document, script, fresh=True)[1]
    assert list(map(comparable, steps)) == list(map(comparable, others))


@lenient
@given(charts(TIMED), scripts(timed=True, writes=True))
def test_what_is_remembered_of_the_way_changes_nothing(document: Json, script: list[tuple[Any, ...]]) -> None:
    mission = Mission.model_validate(document)
    one, at = Chart(mission), 0.0
    one.start(0.0)
    for word, what, wait in script * 2:
        at += wait
        event = (
            Event(what[0], at, {"value": what[1]}, "write")
            if word == "write"
            else Event(what, at)
            if word == "event"
            else Tick(at)
        )
        other = Chart.restore(mission, one.snapshot())
        assert comparable(one.send(event)) == comparable(other.send(event))
        assert one.active == other.active


# -- time ------------------------------------------------------------------------------------------------------


@lenient
@given(mission_documents(), happenings(commands=False), st.sampled_from([3.0, 40.0, 200.0]))
def test_waking_at_every_instant_leads_where_one_long_wait_leads(
    document: Json, script: list[tuple[Any, float]], wait_s: float
) -> None:
    far, _ = run(document, script)
    often, _ = run(document, script)
    end = far.at + wait_s
    far.send(Tick(end))
    assume("without end" not in far.why)  # where it is noticed depends on what the step has done before
    for _ in range(2000):
        if often.wake_at is None or often.wake_at > end:
            break
        often.send(Tick(often.wake_at))
    often.send(Tick(end))
    ours, theirs = dict(far.snapshot()), dict(often.snapshot())
    for passing in ("seq", "_wake", "_quick"):
        ours.pop(passing, None), theirs.pop(passing, None)
    assert ours == theirs


# -- what is owed ----------------------------------------------------------------------------------------------


@lenient
@given(mission_documents(), happenings())
def test_every_goal_ends_or_is_canceled_once_no_one_owns_it(document: Json, script: list[tuple[Any, float]]) -> None:
    chart, steps = run(document, script)
    if chart.outcome is None:
        steps = [*steps, chart.send(Event("kill", chart.at, {}, "command"))]
    started = {effect.number: effect for step in steps for effect in step.effects if isinstance(effect, StartGoal)}
    canceled = {effect.number for step in steps for effect in step.effects if isinstance(effect, CancelGoal)}
    ended = {step.event.number for step in steps if step.event.kind == "result"}
    for number in sorted(started.keys() - canceled - ended):
        step = chart.send(Event("drive", chart.at, {}, "accepted", number))
        assert any(isinstance(effect, CancelGoal) and effect.number == number for effect in step.effects)


@pytest.mark.parametrize("kind", ["event", "result", "proposal", "accepted", "control"])
@given(mission_documents())
@lenient
def test_what_concerns_no_one_changes_nothing(kind: str, document: Json) -> None:
    chart = Chart(Mission.model_validate(document), ticker())
    chart.start(0.0)
    before = chart.snapshot()
    name = {"event": "never_declared", "control": "autonomy"}.get(kind, "succeeded")
    if kind == "control" and chart.holder != "autonomy":
        return
    step = chart.send(Event(name, 0.0, {"option": "x"}, kind, 99_999))
    after = dict(chart.snapshot())
    assert step.moves == () and step.effects == ()
    assert after | {"seq": 0, "_quick": 0} == dict(before) | {"seq": 0, "_quick": 0}

# SPDX-License-Identifier: Apache-2.0
"""Laws of `check`: it never raises, reports each thing once and in order, and what it reports never happens never
does."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from rai_missions.check import check
from rai_missions.check.finding import document_order
from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.guards import Guard, Site, Truth
from rai_missions.guards.implication import form, implies, never
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from tests.strategies import EVENTS, KEYS, guards, mission_documents, missions

DESIGN: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "data" / "tractor_design.json").read_text(encoding="utf-8")
)
WORDS = (
    "working", "driving", "assessing", "nowhere", "obstacle", "battery", "battery.x", "event.x", "answer.y", "done",
    "failed", "*", "abort", "resume", "aborted", "succeeded", "anomaly", "signals", "alleys", "obstacle.living",
)  # fmt: skip
PIECES: tuple[Any, ...] = (
    {"key": "battery", "<": 1}, {"any": []}, {"all": []}, {"not": {"fresh": "camera"}}, {"in": "resume"},
    {"elapsed_s": 0}, {"held": {"key": "signals", ">": 1}, "for_s": 0},
    {"possible": {"key": "obstacle.living", "==": True}},
    {"near": ["camera", "battery"], "within_m": 1}, {"named": "x", "with": {"a": {"from": "q"}}}, {"history": "deep"},
    {"final": "succeeded"}, {"key": "camera", "==": "x"}, {"key": "signals", "in": {"key": "alleys"}}, True, 3,
    {"set": "signals", "from": "event.x"}, {"raise": "anomaly", "after_s": 1, "id": "x"}, {"drop": "y"},
    {"parallel": {"left": {}, "right": {"initial": "deeper", "states": {"deeper": {}}}}}, ["done", "driving"],
)  # fmt: skip
Path_ = tuple[str | int, ...]


def paths(value: Any, here: Path_ = ()) -> Iterator[Path_]:
    if here:
        yield here
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for word, item in items:
        yield from paths(item, (*here, word))


def at(value: Any, path: Path_) -> Any:
    for word in path:
        value = value[word]
    return value


def spoilt(data: st.DataObject, document: dict[str, Any]) -> dict[str, Any]:
    """The document with one thing taken away, renamed, or replaced by something else."""
    path = data.draw(st.sampled_from(list(paths(document))))
    parent, word = at(document, path[:-1]), path[-1]
    what = data.draw(st.sampled_from(["delete", "word", "word", "piece", "copy", "rename"]))
    if what == "delete":
        del parent[word]
    elif what == "word":
        old = parent[word]
        parent[word] = data.draw(st.sampled_from(WORDS)) if isinstance(old, str) else old
    elif what == "piece":
        parent[word] = copy.deepcopy(data.draw(st.sampled_from(PIECES)))
    elif what == "copy":
        parent[word] = copy.deepcopy(at(document, data.draw(st.sampled_from(list(paths(document))))))
    elif isinstance(parent, dict):
        parent[data.draw(st.sampled_from(WORDS))] = parent.pop(word)
    return document


@settings(max_examples=6 * settings.default.max_examples)
@given(st.data())
def test_whatever_is_done_to_a_mission_check_finds_and_never_raises(data: st.DataObject) -> None:
    document = copy.deepcopy(DESIGN)
    for _ in range(data.draw(st.integers(1, 4))):
        changed = spoilt(data, copy.deepcopy(document))
        try:
            mission = Mission.model_validate(changed)
        except (ValidationError, TypeError):
            continue  # what is no mission is for `load` to refuse
        document = changed
        for finding in check(mission, named=data.draw(st.sampled_from([None, (), ("x",)]))):
            assert finding.sentence
            assert "None" not in finding.sentence


@given(missions())
def test_each_thing_is_reported_once_and_in_document_order(mission: Mission) -> None:
    found = check(mission)
    order = document_order(mission)
    assert len(set(found)) == len(found)
    assert [order(each.place) for each in found] == sorted(order(each.place) for each in found)
    assert all(-1 not in order(each.place) for each in found)


@given(mission_documents(), st.data())
def test_a_second_mission_equal_to_the_first_is_sent_the_same(document: dict[str, Any], data: st.DataObject) -> None:
    mission = Mission.model_validate(document)
    assert check(Mission.model_validate(mission.written())) == check(mission)


# -- what is reported never to happen never does
# --------------------------------------------------------------------------


def happenings(mission: Mission) -> st.SearchStrategy[list[Any]]:
    """What may happen to a run: events, facts, time, and ends of whatever runs."""
    values: dict[str, list[Any]] = {
        "battery": [0.05, 0.3],
        "clear": [True, False],
        "pose": [{"x": 0.0, "y": 0.0}],
        "obstacle": [{"kind": "log", "height_m": 0.2, "living": False}, {"kind": "dog", "living": True}],
    }
    facts = st.sampled_from([(key, value) for key, given in values.items() for value in given])
    ends = st.sampled_from(["succeeded", "failed", "rejected"])
    answers = st.sampled_from(["drive_over", "replan", "wait", "give_up"])
    return st.lists(
        st.one_of(
            st.sampled_from(EVENTS).map(lambda name: ("event", name)),
            facts.map(lambda fact: ("write", fact)),
            st.sampled_from([1.0, 3.0, 11.0]).map(lambda wait: ("wait", wait)),
            ends.map(lambda end: ("result", end)),
            answers.map(lambda option: ("answer", option)),
        ),
        min_size=5,
        max_size=25,
    )


def ran(mission: Mission, happened: list[Any]) -> tuple[set[str], set[str], set[str]]:
    """The transitions taken, the states entered, and those left for another, in a run."""
    chart = Chart(mission, ticker=CompiledTrees())
    steps, now = [chart.start(at=0.0)], 0.0
    starts: list[tuple[int, str]] = []
    for kind, what in happened:
        starts += [(effect.number, type(effect).__name__) for effect in steps[-1].effects if hasattr(effect, "number")]
        questions = [step.question for step in steps if step.question is not None]
        if kind == "wait":
            now += what
            steps.append(chart.send(Tick(now)))
        elif kind == "write":
            steps.append(chart.write(what[0], what[1], at=now))
        elif kind == "event":
            steps.append(chart.send(Event(what, now)))
        elif kind == "result" and starts:
            steps.append(chart.send(Event(what, now, {}, "result", starts[-1][0])))
        elif kind == "answer" and questions:
            answer = {"option": what, "parameters": {}, "why": ""}
            steps.append(chart.send(Event("agent", now, answer, "proposal", questions[-1].number)))
        if chart.outcome is not None:
            break
    taken = {place for step in steps for move in step.moves for place in move.taken}
    return (
        taken,
        {name for step in steps for name in step.entered},
        {name for step in steps for name in step.exited if name not in step.entered},
    )


@given(missions(), st.data())
def test_what_never_happens_by_check_never_happens_in_a_run(mission: Mission, data: st.DataObject) -> None:
    names = {place: name for place, name, _ in mission.walk()}
    found = check(mission)
    dead = {each.place for each in found if each.rule == "overlapping-transition"}
    dead |= {each.place.removesuffix("/when") for each in found if each.rule == "impossible-guard"}
    lost = {names[each.place] for each in found if each.rule == "unreachable-state"}
    stuck = {names[each.place] for each in found if each.rule == "dead-end"}
    if not (dead or lost or stuck):
        return
    taken, entered, left = ran(mission, data.draw(happenings(mission)))
    assert not dead & taken
    assert not lost & entered
    assert not stuck & left


class Known:
    """What a guard may see, as plain values."""

    def __init__(self, board: dict[str, Any], active: frozenset[str], at: float) -> None:
        self.board = {key: Stamped(value, 0.0) for key, value in board.items()}
        self.active, self.at = active, at
        self.entered: dict[str, float] = {"": 0.0}
        self.true_since: dict[str, float] = {}
        self.event: dict[str, Any] = {}
        self.answer: dict[str, Any] = {}

    def named(self, name: str, arguments: Any) -> Truth:
        return None

    def note(self, text: str) -> None:
        return None


boards = st.fixed_dictionaries(
    {},
    optional={
        "alleys": st.integers(0, 3),
        "count": st.integers(-1, 4),
        "armed": st.booleans(),
        "clear": st.booleans(),
        "battery": st.sampled_from([0.05, 0.1, 0.2, 0.25, 0.4, 0.5, 0.6]),
        "pose": st.just({"x": 0.0, "y": 0.0}),
        "obstacle": st.fixed_dictionaries(
            {},
            optional={
                "kind": st.sampled_from(["log", "dog"]),
                "height_m": st.sampled_from([0.05, 0.1, 0.2, 0.25, 0.3]),
                "living": st.booleans(),
            },
        ),
    },
)
KEYS_OF_MISSION = Mission.model_validate(
    {"name": "keys", "blackboard": KEYS, "initial": "here", "states": {"here": {}}}
).blackboard


def value_of(guard: Guard, known: Known) -> Truth:
    return guard.compile(Site("", KEYS_OF_MISSION))(known)


@settings(max_examples=12 * settings.default.max_examples)
@given(guards(("here", "there"), timed=False), guards(("here", "there"), timed=False), st.data())
def test_what_follows_from_a_guard_is_true_wherever_it_is(one: Any, other: Any, data: st.DataObject) -> None:
    weaker = data.draw(st.sampled_from([other, {"any": [other, one]}, {"not": {"all": [other, {"not": one}]}}]))
    first, second = Guard.read(one), Guard.read(weaker)
    follows, impossible = implies(form(first), form(second)), never(form(first))
    if not (follows or impossible):
        return
    known = Known(
        data.draw(boards),
        data.draw(st.sampled_from([frozenset({"here"}), frozenset()])),
        data.draw(st.sampled_from([0.0, 2.0, 20.0])),
    )
    if value_of(first, known) is True:
        assert not impossible
        assert value_of(second, known) is True or not follows


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_places_is_that_of_the_written_mission(seed: int) -> None:
    mission = Mission.model_validate(DESIGN)
    places = ["/".join(["", *map(str, path)]) for path in paths(mission.written())]
    order = document_order(mission)
    assert len({order(place) for place in places}) == len(places)
    states = [place for place, _, _ in mission.walk()]
    assert sorted(states[seed:] + states[:seed], key=order) == states

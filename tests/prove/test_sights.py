# SPDX-License-Identifier: Apache-2.0
"""What is seen is left open question by question: that finds what trying every value at once finds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.guards.goal import judged
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Truth, as_counted
from rai_missions.keys import Key, Stamped
from rai_missions.mission.mission import Mission
from rai_missions.planning.examples import GOALS, REQUESTS
from rai_missions.planning.scene import judged_by
from rai_missions.prove import prove
from rai_missions.prove.abstraction.open_sight import OpenSight, Sights
from rai_missions.prove.analysis.comparisons import Comparisons
from rai_missions.prove.analysis.representatives import Values
from rai_missions.prove.environment.environment import Environment
from tests.engine.test_goals import ASKED_FOR, FEASIBLE, KEYS, REACHED
from tests.prove.explored import RecordingSpace
from tests.prove.test_goals import moving
from tests.prove.test_laws import hold_against_forgetless, hold_against_patient
from tests.rigs.laws import drill
from tests.strategies import mission_documents

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
MOST = 400
GUARDS: list[Json] = [
    REACHED, FEASIBLE, ASKED_FOR, {**ASKED_FOR, "in": "sentence"}, {**ASKED_FOR, "over": "objects"},
    {"key": "objects.gripper", "==": "holding"},
    {"key": "objects.looks", ">=": 10}, {"fresh": "objects"}, {"held": REACHED, "for_s": 1},
]  # fmt: skip
OBJECTS: Json = {"type": "object", "source": "robot", "max_age_s": 2,
                 "fields": {"things": "list", "gripper": "string", "looks": "integer"}}  # fmt: skip
READING: Json = {"goal": "object", "question": "string", "candidates": "list", "reason": "string", "about": "string",
                 "covers_all": "boolean"}  # fmt: skip


class WholeSight(OpenSight):
    """A sight of which one value is chosen as soon as anything is asked."""

    def get(self, field: str, default: Any = None) -> Any:
        if not hasattr(self, "chosen"):
            self.chosen = self.sights.one_of(self)
        self.looked.add(field)
        bit = self.sights.values.index(self.chosen)
        self[field] = next(answer for answer, bits in self.sights.answers(field) if bits >> bit & 1)
        return default if self[field] is None else self[field]

    def fresh(self, known: Any = None) -> OpenSight:
        made = WholeSight(self.sights)
        made.update(self if known is None else known)
        return made


class WholeSights(Environment):
    """Every value of what is seen is tried at once."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.world.shapes = {
            key: WholeSight(each.sights) if isinstance(each, OpenSight) else each
            for key, each in self.world.shapes.items()
        }


@st.composite
def guards(draw: st.DrawFn) -> Json:
    parts = draw(st.lists(st.sampled_from(GUARDS), min_size=1, max_size=2))
    parts = [{"not": each} if draw(st.booleans()) and "held" not in each else each for each in parts]
    return parts[0] if len(parts) == 1 else {draw(st.sampled_from(["any", "all"])): parts}


@st.composite
def sighted(draw: st.DrawFn) -> Json:
    """A mission whose rules ask about what is seen; whatever needs no event leads forward."""
    names = ["one", "two", "three", "aborted"]
    states: Json = {}
    for at, name in enumerate(names[:-1]):
        to = st.sampled_from([*names[at + 1 :], "done"])
        states[name] = {
            "transitions": [
                *({"when": draw(guards()), "to": draw(to)} for _ in range(draw(st.integers(1, 2)))),
                {"on": "next", "when": draw(guards()), "to": draw(st.sampled_from([*names[:-1], "done"]))},
                {"after_s": 5, "to": draw(to)},
            ]
        }
    if draw(st.booleans()):
        states["two"] = {
            "plan": "wanted", "over": "objects", "into": "plan", "transitions": [
                {"on": "succeeded", "when": {"fresh": "plan.next"}, "to": "three"},
                {"on": "failed", "when": {"key": "plan.reason", "==": "unclear"}, "to": "three"},
                {"on": ["succeeded", "failed", "rejected"], "to": "aborted",
                 "do": [{"set": "report", "from": "plan.about"}]},
            ],
        }  # fmt: skip
    if draw(st.booleans()):
        source = draw(st.sampled_from(["sentence", "request"]))
        states["three"] = {
            "read": source, "over": "objects", "into": "reading", "transitions": [
                {"on": "succeeded", "when": draw(guards()), "to": draw(st.sampled_from(["done", "aborted"]))},
                {"on": ["succeeded", "unclear", "rejected"], "to": "aborted"},
                {"on": "refused", "to": "aborted", "do": [{"set": "report", "from": "reading.about"}]},
            ],
        }  # fmt: skip
        each = draw(st.sampled_from(["one", "two"]))
        states[each]["transitions"][0].setdefault("do", []).append({"set": "sentence", "from": "request"})
    invariants = {"kept": {"not": {"all": [{"in": "three"}, draw(guards())]}}} if draw(st.booleans()) else {}
    held = [name for name, each in invariants.items() if "held" in str(each)]
    wanted = {"type": "object", "source": draw(st.sampled_from(["argument", "mission"]))}
    return {
        "name": "sighted",
        "initial": "one",
        "events": {"next": {}},
        "blackboard": {
            **KEYS,
            "objects": OBJECTS,
            "wanted": wanted,
            "report": {"type": "string", "initial": ""},
            "sentence": {"type": "string"},
            "reading": {"type": "object", "fields": READING},
            "plan": {"type": "object", "fields": {"next": "object", "reason": "string", "about": "string"}},
        },
        "invariants": {name: each for name, each in invariants.items() if name not in held},
        "states": states
        | {
            "done": {"final": "succeeded", "requires": draw(guards().filter(lambda each: "held" not in str(each)))},
            "aborted": {"final": "aborted", "entry": [{"publish": "report", "message": {"data": {"from": "report"}}}]},
        },
    }


def space_of(mission: Mission, kind: type[Environment] = Environment) -> RecordingSpace:
    space = RecordingSpace(kind(mission), MOST, work=1000)
    space.explore()
    return space


def lengths(space: RecordingSpace) -> dict[str, int]:
    return {name: len(space.path(flaw.state)) for name, flaw in space.findings.flaws.items()}


def counts_at(place: str) -> Truth:
    """What counts of a guard: that of an option or transition is true, of an invariant false; of an end each value."""
    is_enabling = place.endswith("/when") or "/transitions/" in place
    return True if is_enabling else False if place.startswith("/invariants/") else None


def counted(space: RecordingSpace) -> dict[str, set[Truth]]:
    """Place of a guard → what it was, as far as that counts."""
    seen = space.environment.instruments.seen
    return {place: {as_counted(each, counts_at(place)) for each in values} for place, values in seen.items()}


def hold_alike(few: RecordingSpace, every: RecordingSpace) -> None:
    """They find the same."""
    assume(few.is_whole and every.is_whole)
    assert few.seen == every.seen
    for what in ("taken", "entered", "in_pause"):
        assert getattr(few.findings, what) == getattr(every.findings, what), what
    assert counted(few) == counted(every)
    assert few.findings.flaws.keys() == every.findings.flaws.keys()


def hold_against_whole(document: Json) -> None:
    mission = Mission.model_validate(document)
    few, every = space_of(mission), space_of(mission, WholeSights)
    hold_alike(few, every)
    assert (few.states, lengths(few)) == (every.states, lengths(every)) and few.steps <= every.steps


def hold_against_plain(document: Json) -> None:
    """Against plain values, which are kept from step to step as they are: then a run may need one more report."""
    mission = Mission.model_validate(document)
    few = space_of(mission)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Values, "is_sight", lambda self, key: False)
        every = space_of(mission)
    hold_alike(few, every)
    assert all(length <= lengths(every)[name] for name, length in lengths(few).items())


FIELDS: list[Json] = [
    {"key": "obstacle.kind", "in": ["log", "branch"]}, {"key": "obstacle.kind", "==": "log"},
    {"key": "obstacle.living", "==": True}, {"key": "obstacle.height_m", "<": 0.1},
    {"key": "obstacle.height_m", ">=": 0.25}, {"not": {"key": "obstacle.living", "==": False}},
]  # fmt: skip


def junctions() -> st.SearchStrategy[Json]:
    """An `all` or `any` of fields of one object, one inside another."""
    parts = st.lists(st.sampled_from(FIELDS), min_size=2, max_size=3)
    flat = st.builds(lambda word, parts: {word: parts}, st.sampled_from(["all", "any"]), parts)
    return st.one_of(
        flat,
        st.builds(
            lambda outer, inner, part: {outer: [inner, part]},
            st.sampled_from(["all", "any"]),
            flat,
            st.sampled_from(FIELDS),
        ),
    )


def looking(given: Any, guards: list[Json]) -> Any:
    """A mission whose comparisons of some keys look into an object instead."""
    if isinstance(given, list):
        return [looking(each, guards) for each in given]
    if not isinstance(given, dict):
        return given
    if given.get("key") in ("battery", "clear", "obstacle.living"):
        return guards[len(str(given)) % len(guards)]
    return {word: looking(each, guards) for word, each in given.items()}


def hold_against_asked(document: Json) -> None:
    """Against every value of what no guard looks at, too."""
    mission = Mission.model_validate(document)
    few = space_of(mission)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Comparisons, "is_asked", lambda self, path: True)
        every = space_of(mission)
    hold_alike(few, every)
    assert lengths(few) == lengths(every) and few.states <= every.states


@settings(lenient, max_examples=3)
@given(sighted())
def test_a_sight_that_is_left_open_finds_what_every_sight_finds(document: Json) -> None:
    hold_against_whole(document)


test_a_sight_that_is_left_open_finds_what_every_sight_finds_however_often_it_is_tried = drill(
    hold_against_whole, sighted(), tried=settings(lenient, max_examples=1000)
)


test_a_sight_that_is_left_open_finds_what_plain_values_find = drill(
    hold_against_plain, sighted(), tried=settings(lenient, max_examples=300)
)


@settings(lenient, max_examples=5)
@given(sighted())
def test_what_is_not_read_makes_no_difference(document: Json) -> None:
    hold_against_forgetless(document, MOST)


@pytest.mark.drill
@settings(lenient, max_examples=300)
@given(sighted())
def test_what_is_not_read_makes_no_difference_however_often_it_is_tried(document: Json) -> None:
    hold_against_forgetless(document, MOST)
    hold_against_patient(document, MOST)


def test_what_is_reported_next_comes_in_one_order_whatever_was_asked_first() -> None:
    """A state that is found by a stale sight has asked for `reached` first, the others for `feasible`."""
    hold_against_patient(
        {
            "name": "seen_in_turn",
            "initial": "one",
            "events": {"next": {}},
            "blackboard": {
                "request": {"type": "string", "source": "argument", "initial": REQUESTS[0]},
                "objects": OBJECTS,
                "wanted": {"type": "object", "source": "argument"},
                "sentence": {"type": "string"},
                "reading": {"type": "object", "fields": READING},
            },
            "states": {
                "one": {
                    "transitions": [
                        {"when": FEASIBLE, "to": "two", "do": [{"set": "sentence", "from": "request"}]},
                        {"when": REACHED, "to": "two"},
                    ]
                },
                "two": {
                    "transitions": [
                        {"when": REACHED, "to": "three"},
                        {"on": "next", "when": {"any": [REACHED, ASKED_FOR]}, "to": "one"},
                    ]
                },
                "three": {"read": "sentence", "over": "objects", "into": "reading"},
            },
        },
        MOST,
        work=math.inf,
    )


@settings(lenient, max_examples=2)
@given(sighted())
def test_what_no_guard_looks_at_has_one_value(document: Json) -> None:
    hold_against_asked(document)


test_what_no_guard_looks_at_has_one_value_however_often_it_is_tried = drill(
    hold_against_asked, sighted(), tried=settings(lenient, max_examples=300)
)


def test_goals_are_judged_by_what_their_scene_is_compared_by() -> None:
    values = Values(
        Mission.model_validate(moving(blackboard={**KEYS, "objects": OBJECTS})),
        Environment(Mission.model_validate(moving())).chart.robot_facts,
    ).of("objects")
    seen = [dict(each, looks=looks, stamp_s=1.0) for each in values if each is not None for looks in (0, 7)]
    by_scene: dict[str, set[Any]] = {}
    for each in seen:
        answers = tuple(judged(aspect, GOALS[0], each, REQUESTS[0]) for aspect in ("reached", "feasible", "said"))
        by_scene.setdefault(judged_by(each), set()).add(answers)
    assert len(by_scene) > 1 and all(len(each) == 1 for each in by_scene.values())


def test_questions_leave_the_values_that_answer_them_alike() -> None:
    sights = Sights([{"a": 1, "b": 1}, {"a": 1}, {"a": True, "b": 1}], lambda answers: answers[-1])
    sight = OpenSight(sights)
    assert sight.get("b") is None and sight.get("a") == 1
    assert sight.example() == {"a": 1} and sight.whole() == {"a": 1}
    assert [dict(each) for each in sight.mixtures()] == [{"a": 1, "b": 1}, {"a": 1, "b": None}, {"a": True, "b": 1}]


LIVING: Json = {"key": "obstacle.living", "==": True}
FREE: Json = {"key": "n", "<": 2}
LOW: Json = {"key": "obstacle.height_m", "<": 0.1}


@pytest.mark.parametrize(("guard", "counts", "asked"), [
    (LIVING, None, [[True, False, None]]),
    (LIVING, True, [[True, False]]),
    (LIVING, False, [[True, False]]),
    ({"not": LIVING}, True, [[True, False]]),
    ({"possible": LIVING}, True, [[True, False, None]]),
    ({"held": LIVING, "for_s": 1}, True, [[True, False, None]]),
    ({"all": [LOW, LIVING]}, None, [[False, True, None]]),
    ({"all": [LOW, LIVING]}, True, [[False, True]]),
    ({"all": [LOW, FREE, LIVING]}, True, [[False, True]]),
    ({"any": [{"not": LOW}, FREE, {"all": [LIVING, FREE, {"not": LOW}]}]}, True, [[False, True]]),
])  # fmt: skip
def test_a_sight_is_asked_once_for_what_counts_of_the_parts_of_a_guard_that_look_into_it(
    guard: Json, counts: Truth, asked: list[list[Truth]]
) -> None:
    picked: list[Any] = []

    def pick(answers: Sequence[Any]) -> Any:
        picked.append(answers)
        return answers[-1]

    values: list[Json] = [{"living": True, "height_m": 1.0}, {"living": True, "height_m": 0.0}, {"living": False}, {}]
    sight = OpenSight(Sights(values, pick))
    keys = {"obstacle": Key(dict, source="robot"), "n": Key(int, initial=0)}
    test, state = Guard.read(guard).compiled(Site("", keys), counts), Chart(Mission.model_validate(moving())).state
    state.board = {"obstacle": Stamped(sight, 0.0), "n": Stamped(0, 0.0)}
    found = test(state)
    assert picked == asked
    state.board["obstacle"] = Stamped(sight.example(), 0.0)
    assert as_counted(test(state), counts) is as_counted(found, counts)


def test_a_mission_with_a_whole_desk_in_sight_is_proved_in_few_steps() -> None:
    proof = prove(Mission.model_validate(moving(blackboard={**KEYS, "objects": OBJECTS})))
    assert proof.verdict == "proved" and proof.steps < 20_000


@settings(lenient, max_examples=10)
@given(st.lists(junctions(), min_size=6, max_size=6))
def test_an_object_asked_at_once_finds_what_one_asked_field_by_field_finds(guards: list[Json]) -> None:
    one, two, three, four, kept, required = guards
    fields = {"kind": "string", "living": "boolean", "height_m": "number"}
    hold_against_plain(
        {
            "name": "asked",
            "initial": "here",
            "events": {"go": {}},
            "blackboard": {"obstacle": {"type": "object", "source": "robot", "max_age_s": 2, "fields": fields}},
            "invariants": {"kept": {"not": {"all": [{"in": "there"}, kept]}}},
            "states": {
                "here": {"transitions": [{"when": one, "to": "there"}, {"on": "go", "when": two, "to": "near"}]},
                "there": {"transitions": [{"on": "go", "when": three, "to": "near"}]},
                "near": {"transitions": [{"when": four, "to": "over"}, {"on": "go", "when": one, "to": "here"}]},
                "over": {"final": "succeeded", "requires": required},
            },
        }
    )


@pytest.mark.drill
@settings(lenient, max_examples=1000)
@given(mission_documents(), st.lists(junctions(), min_size=2, max_size=3))
def test_an_object_asked_at_once_finds_what_one_asked_field_by_field_finds_however_often_it_is_tried(
    document: Json, guards: list[Json]
) -> None:
    hold_against_plain(looking(document, guards))

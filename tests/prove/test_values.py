# SPDX-License-Identifier: Apache-2.0
"""Values that all guards treat alike, and pauses that end alike: one of them represents the others."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space

Json = dict[str, Any]
LOW: Json = {"key": "battery", "<": 0.15}
SILENT: Json = {"not": {"fresh": "battery"}}
EITHER: Json = {"any": [LOW, SILENT]}
OVER: Json = {"final": "aborted"}


def environment(
    *guards: Json, state: Json | None = None, kept: Json | None = None, last: Json | None = None, **keys: Json
) -> Environment:
    """Of a mission that may leave a state by one of these guards; it keeps an invariant, and has a last state."""
    transitions = [{"when": guard, "to": "over"} for guard in guards]
    battery = {"type": "number", "source": "robot", "max_age_s": 5}
    return Environment(Mission.model_validate({
        "format": 1, "name": "values", "initial": "waiting", "blackboard": {"battery": battery, **keys},
        "invariants": {} if kept is None else {"kept": kept},
        "states": {"waiting": {**(state or {}), "transitions": transitions}, "over": OVER, "last": last or OVER},
    }))  # fmt: skip


@pytest.mark.parametrize("guard", [
    EITHER, {"not": EITHER}, {"held": EITHER, "for_s": 2}, {"all": [{"not": {"in": "over"}}, EITHER]},
])  # fmt: skip
def test_values_that_a_part_of_a_guard_treats_alike_as_a_whole_are_chosen_once(guard: Json) -> None:
    world = environment(guard).world
    assert world.chosen["battery"] == (None, 0.15) and len(world.values.of("battery")) == 3


@pytest.mark.parametrize(("guard", "chosen"), [
    (LOW, (None, -0.85)), ({"not": LOW}, (None, 0.15)), ({"not": {"not": LOW}}, (None, -0.85)),
    ({"all": [{"in": "waiting"}, LOW]}, (None, -0.85)), ({"possible": LOW}, (None, 0.15)),
    ({"any": [{"in": "over"}, LOW, SILENT]}, (None, 0.15)),
    ({"not": {"all": [{"in": "waiting"}, LOW]}}, (None, 0.15)),
])  # fmt: skip
def test_values_by_which_a_guard_is_not_true_are_alike(guard: Json, chosen: tuple[Any, ...]) -> None:
    assert environment(guard).world.chosen["battery"] == chosen


def test_values_by_which_an_invariant_is_not_false_are_alike() -> None:
    kept: Json = {"any": [{"in": "over"}, {"not": LOW}]}
    assert environment(kept=kept).world.chosen["battery"] == (None, -0.85)


@pytest.mark.parametrize("state", [
    {"action": "drive", "timeout_s": 9, "achieved": LOW}, {"final": "succeeded", "requires": LOW},
])  # fmt: skip
def test_whether_an_end_is_refuted_or_unknown_is_not_alike(state: Json) -> None:
    assert len(environment(last=state).world.chosen["battery"]) == 3


@pytest.mark.parametrize("guards", [(EITHER, SILENT), (EITHER, LOW), ({"any": [{"held": LOW, "for_s": 2}, SILENT]},)])
def test_values_that_some_guard_treats_otherwise_are_each_chosen(guards: tuple[Json, ...]) -> None:
    assert len(environment(*guards).world.chosen["battery"]) == 3


def test_values_that_more_than_guards_read_are_each_chosen() -> None:
    copied = environment(
        EITHER, state={"entry": [{"set": "before", "from": "battery"}]}, before={"type": "number", "initial": 0}
    )
    assert "battery" not in copied.world.chosen


def test_values_that_a_question_shows_are_alike() -> None:
    question = {"question": "?", "options": {"on": {}}, "evidence": ["battery"], "deadline_s": 5, "fallback": "on"}
    assert len(environment(EITHER, state={"decision": question}).world.chosen["battery"]) == 2


@pytest.mark.parametrize(("ops", "many"), [
    ((">=", "<"), 2), ((">", "<="), 2), (("==",), 2), ((">", ">="), 3), (("==", "<"), 3),
])  # fmt: skip
def test_numbers_next_to_an_argument_are_as_many_as_the_comparisons_distinguish(
    ops: tuple[str, ...], many: int
) -> None:
    goal: Json = {"type": "integer", "source": "argument", "initial": 6}
    done: Json = {"type": "integer", "source": "robot", "max_age_s": 5}
    either_way: list[list[Json]] = [
        [{"key": "done", op: {"key": "goal"}} for op in ops],
        [{"key": "goal", op: {"key": "done"}} for op in ops],
    ]
    for guards in either_way:
        values = environment(*guards, goal=goal, done=done).world.values.of("done")
        assert values[0] is None and len(values) == 1 + many


def _values_of_argument(argument: Json, *guards: Json, **keys: Json) -> tuple[Any, ...]:
    given: Json = {"source": "argument", "initial": argument.get("enum", [argument.get("minimum")])[0], **argument}
    return environment(*guards, given=given, **keys).world.values.of("given")


def test_an_argument_is_tried_with_listed_values_alone() -> None:
    listed: Json = {"type": "string", "enum": ["east", "north", "south", "west"]}
    here: Json = {"type": "string", "source": "robot", "max_age_s": 5}
    is_west: Json = {"key": "given", "==": "west"}
    is_here: Json = {"key": "here", "==": {"key": "given"}}
    assert _values_of_argument(listed) == ("east",)
    assert _values_of_argument(listed, is_west) == ("west", "east")
    assert _values_of_argument({**listed, "enum": ["west"]}, is_west) == ("west",)
    assert _values_of_argument(listed, is_here, here=here) == ("east", "north")  # two, which can differ
    other: Json = {"type": "string", "source": "argument", "initial": "up", "enum": ["up", "west"]}
    values = _values_of_argument(listed, {"key": "other", "==": {"key": "given"}}, other=other)
    assert set(values) == set(listed["enum"])


@pytest.mark.parametrize(("kind", "least", "value"), [
    ("integer", 0.5, 1), ("integer", 2, 2), ("number", 0.5, 0.5), ("integer", -0.5, 0),
])  # fmt: skip
def test_an_argument_that_is_not_compared_has_one_value_of_its_range(kind: str, least: float, value: float) -> None:
    assert _values_of_argument({"type": kind, "minimum": least, "maximum": 9.5, "initial": 3}) == (value,)


@pytest.mark.parametrize("limit", [0, 10, 20, 40, 41, 100])
def test_an_argument_is_tried_with_values_of_its_range_alone(limit: int) -> None:
    argument: Json = {"type": "integer", "minimum": 10, "maximum": 40}
    tried = _values_of_argument(argument, {"key": "given", "<": limit})
    assert tried and all(10 <= each <= 40 for each in tried)
    assert {each < limit for each in tried} == {each < limit for each in range(10, 41)}


def test_in_a_pause_what_was_asked_for_control_is_like_what_was_interrupted() -> None:
    cores = set()
    for finds, is_asked in ((0, False), (1, True)):
        paused = environment(LOW, state={"tree": {"action": "drive"}, "control": "autonomy", "timeout_s": 9})
        paused.choices.begin((0, 0, finds))  # control is not taken, the battery unknown; who has control
        paused.load(paused.codec.place())
        paused.make(paused.begin)
        paused.settle()
        assert bool(paused.chart.state.awaiting_control) is is_asked
        paused.make(paused.ordering("pause"))
        paused.settle()
        cores.add(paused.codec.run_key())
    assert len(cores) == 1


KEPT: Json = {"least": {"type": "integer", "initial": 2}, "careful": {"type": "boolean", "initial": True},
              "kinds": {"type": "list", "initial": ["log", "branch"]}}  # fmt: skip


def counting(guard: Json, *do: Json) -> Mission:
    """A mission that counts until a guard is true."""
    return Mission.model_validate({
        "name": "counting", "initial": "here",
        "blackboard": {**KEPT, "n": {"type": "integer", "initial": 0}, "seen": {"type": "string", "source": "robot"},
                       "clear": {"type": "boolean", "source": "robot"}},
        "states": {
            "here": {"entry": [{"set": "n", "add": 1}, *do], "transitions": [
                {"when": guard, "to": "end"}, {"when": {"elapsed_s": 1}, "to": "here"}]},
            "end": {"final": "aborted"},
        },
    })  # fmt: skip


@pytest.mark.parametrize(("guard", "literal"), [
    *(({"key": "n", op: {"key": "least"}}, {"key": "n", op: 2}) for op in ("==", "!=", "<", "<=", ">", ">=")),
    *(({"key": "least", op: {"key": "n"}}, {"key": "n", turned: 2}) for op, turned in
      (("==", "=="), ("!=", "!="), ("<", ">"), ("<=", ">="), (">", "<"), (">=", "<="))),
    ({"key": "clear", "==": {"key": "careful"}}, {"key": "clear", "==": True}),
    ({"key": "seen", "in": {"key": "kinds"}}, {"key": "seen", "in": ["log", "branch"]}),
])  # fmt: skip
def test_a_comparison_with_what_is_never_written_is_proved_as_one_with_its_value(guard: Json, literal: Json) -> None:
    found, expected = prove(counting(guard)), prove(counting(literal))
    assert found.sampled == () and (found.claims, found.states, found.steps, found.never) == (
        expected.claims,
        expected.states,
        expected.steps,
        expected.never,
    )


def test_a_comparison_with_what_is_written_is_tried_with_some_values_only() -> None:
    assert prove(counting({"key": "n", ">=": {"key": "least"}}, {"set": "least", "add": 1})).sampled == ("least", "n")


RAISED: Json = {"raise": "found", "data": {"at": {"max": 3, "min": {"from": "limits.max"}}}}


@pytest.mark.parametrize(("path", "keys", "do"), [
    ("limits.max", {}, []),
    ("other.max", {}, [{"set": "other", "from": "limits"}]),
    ("other.max", {}, [{"set": "other", "value": {"max": 3}}]),
    ("other.in.max", {"other": {"type": "object", "initial": {"in": {"max": 3}}}}, []),
    ("event.at.max", {}, [RAISED]),
    ("event.at.min", {}, [RAISED]),
])  # fmt: skip
def test_what_is_compared_with_a_field_that_the_author_wrote_can_lie_on_either_side(
    path: str, keys: Json, do: list[Json]
) -> None:
    on: Json = {"on": "found"} if path.startswith("event") else {}
    proof = prove(Mission.model_validate({
        "name": "asked", "initial": "here", "events": {"found": {"fields": {"at": "object"}}},
        "blackboard": {"level": {"type": "number", "source": "robot"}, "other": {"type": "object"},
                       "limits": {"type": "object", "initial": {"max": 3}}, **keys},
        "states": {
            "here": {"entry": do, "transitions": [
                {**on, "when": {"key": path, "<": {"key": "level"}}, "to": "high"},
                {**on, "when": {"key": path, ">": {"key": "level"}}, "to": "low"}]},
            "high": {}, "low": {},
        },
    }))  # fmt: skip
    assert proof.verdict == "refuted" and proof.never == ()


def test_what_is_compared_with_an_item_of_a_written_list_can_lie_on_either_side() -> None:
    proof = prove(Mission.model_validate({
        "name": "asked", "initial": "going",
        "blackboard": {"level": {"type": "number", "source": "robot"}, "spot": {"type": "object"},
                       "spots": {"type": "list", "initial": [{"max": 3}]}},
        "states": {"going": {"each": "spots", "as": "spot", "initial": "here", "states": {
            "here": {"transitions": [{"when": {"key": "spot.max", "<": {"key": "level"}}, "to": "high"},
                                     {"when": {"key": "spot.max", ">": {"key": "level"}}, "to": "low"}]},
            "high": {}, "low": {}}}},
    }))  # fmt: skip
    assert proof.never == ()


@pytest.mark.parametrize(("ways", "sampled"), [
    (({"key": "at.x", ">": 5}, {"key": "at.x", "<": 5}), ()),
    (({"key": "at.x", ">": {"key": "goal.x"}}, {"key": "at.x", "<": {"key": "goal.x"}}), ()),
    (({"key": "at.yaw", ">": 1}, {"not": {"fresh": "at.yaw"}}), ()),
    (({"all": [{"key": "at.x", ">": 1}, {"key": "at.y", ">": 1}]}, {"key": "at.y", "<": 0}), ()),
    (({"key": "seen.at.x", ">": 5}, {"key": "seen.at.x", "<": 5}), ()),
    (({"all": [{"near": ["at", "goal"], "within_m": 1}, {"key": "at.yaw", ">": 1}]}, {"key": "at.yaw", "<": 1}),
     ("at", "goal")),
])  # fmt: skip
def test_a_pose_that_guards_look_into_is_anywhere(ways: tuple[Json, ...], sampled: tuple[str, ...]) -> None:
    one, other = ways
    pose: Json = {"type": "pose", "source": "robot"}
    proof = prove(Mission.model_validate({
        "name": "asked", "initial": "here",
        "blackboard": {"at": pose, "goal": {"type": "pose", "source": "argument"},
                       "seen": {"type": "object", "source": "robot", "fields": {"at": "pose"}}},
        "states": {"here": {"transitions": [{"when": one, "to": "there"}, {"when": other, "to": "away"}]},
                   "there": {}, "away": {}},
    }))  # fmt: skip
    assert (proof.verdict, proof.never, proof.sampled) == ("refuted", (), sampled)


@pytest.mark.parametrize("kind", ["object", "pose"])
@pytest.mark.parametrize("op", ["==", "!="])
def test_objects_that_are_compared_as_a_whole_are_tried_with_some_values_only(kind: str, op: str) -> None:
    keys = {"seen": {"type": kind, "source": "robot"}, "given": {"type": kind, "source": "argument"}}
    guard = {"key": "seen", op: {"key": "given"}}
    assert prove(
        Mission.model_validate(
            {
                "name": "asked",
                "initial": "here",
                "blackboard": keys,
                "states": {"here": {"transitions": [{"when": guard, "to": "end"}]}, "end": {"final": "aborted"}},
            }
        )
    ).sampled == ("seen",)


def test_what_is_compared_with_what_a_tree_reports_can_be_the_same() -> None:
    same = {"key": "report", "==": {"key": "word"}}
    proof = prove(Mission.model_validate({
        "name": "asked", "initial": "here",
        "blackboard": {"report": {"type": "string"}, "word": {"type": "string", "source": "robot"}},
        "states": {
            "here": {"tree": {"status_to_blackboard": "report", "child": {"wait_s": 1}},
                     "transitions": [{"when": same, "to": "there"}, {"on": "succeeded", "to": "end"}]},
            "there": {}, "end": {"final": "aborted"},
        },
    }))  # fmt: skip
    assert (proof.verdict, proof.never) == ("refuted", ())


COPIED: tuple[tuple[Json, Json, Json], ...] = (
    ({"key": "seen", "==": {"key": "wanted"}}, {"type": "string"}, {"set": "draft", "value": "cup"}),
    ({"near": ["seen", "wanted"], "within_m": 0.5}, {"type": "pose", "frame": "map"},
     {"set": "draft", "value": {"x": 7, "y": 3, "frame": "map"}}),
)  # fmt: skip
"""A guard, what kind the author's value is of, and how it is written, ahead of its copy."""


@pytest.mark.parametrize(("guard", "kind", "written"), COPIED)
def test_what_is_compared_with_a_copy_can_be_what_the_author_wrote_ahead_of_it(
    guard: Json, kind: Json, written: Json
) -> None:
    proof = prove(Mission.model_validate({
        "name": "copied", "initial": "here",
        "blackboard": {"seen": {**kind, "source": "robot"}, "draft": kind, "wanted": kind},
        "states": {"here": {"entry": [written, {"set": "wanted", "from": "draft"}],
                            "transitions": [{"when": guard, "to": "found"}, {"after_s": 1, "to": "over"}]},
                   "found": OVER, "over": OVER},
    }))  # fmt: skip
    assert (proof.sampled, proof.never) == ((), ())


def test_what_is_compared_with_an_item_of_a_copied_list_can_be_the_same() -> None:
    names = {"type": "list"}
    proof = prove(Mission.model_validate({
        "name": "copied", "initial": "here",
        "blackboard": {"seen": {"type": "string", "source": "robot"}, "wanted": {"type": "string"},
                       "draft": names, "names": names},
        "states": {
            "here": {"entry": [{"set": "draft", "value": ["cup"]}, {"set": "names", "from": "draft"}],
                     "transitions": [{"after_s": 1, "to": "going"}]},
            "going": {"each": "names", "as": "wanted", "initial": "looking", "states": {"looking": {"transitions": [
                {"when": {"key": "seen", "==": {"key": "wanted"}}, "to": "found"}, {"after_s": 1, "to": "over"}]},
                "found": OVER, "over": OVER}},
        },
    }))  # fmt: skip
    assert proof.never == ()


A, B = "a", "b"
WORD, OBJECT = {"type": "string"}, {"type": "object"}
CALL: Json = {"call": "find", "timeout_s": 5}
FAILED: Json = {"on": ["failed", "timed_out"], "to": "over"}
BROUGHT: dict[str, tuple[Json, str, str, dict[str, Json], list[Json]]] = {
    "a result that is kept": ({"result": {"k": "w"}}, "event.w", "k", {"k": WORD}, []),
    "a result that is kept and copied": (
        {"result": {"k": "w"}}, "event.w", "c", {"k": WORD, "c": WORD}, [{"set": "c", "from": "event.w"}]),
    "an object of a result": ({"result": {"k": "w"}}, "event.w.x", "k.x", {"k": OBJECT}, []),
    "a result that is kept twice": ({"result": {"k": "w", "c": "w"}}, "k", "c", {"k": WORD, "c": WORD}, []),
    "an answer that is copied": ({}, "answer.k", "c", {"k": WORD, "c": WORD}, [{"set": "c", "from": "k"}]),
    "an object of an answer": ({}, "answer.k.x", "k.x", {"k": OBJECT}, []),
}  # fmt: skip
"""What is added to a call, two paths of what it or an answer brings, the keys, and what is done with them."""


@pytest.mark.parametrize("case", BROUGHT)
def test_what_is_brought_is_all_that_guards_look_for_wherever_it_is_kept(case: str) -> None:
    """It is compared as it comes with one word, and later, under a key, with another."""
    more, first, later, keys, do = BROUGHT[case]
    if "result" in case:
        outcome, asked, left = "succeeded", CALL | more, FAILED
    else:
        kind = {"type": "object" if keys["k"] == OBJECT else "string"}
        schema = {"type": "object", "properties": {"k": kind}, "required": ["k"]}
        options: Json = {"say": {"parameters": schema}, "leave": {}}
        question = {"question": "which?", "options": options, "ask": ["operator"], "deadline_s": 60}
        outcome, asked, left = "say", {"decision": question | {"fallback": "leave"}}, {"on": "leave", "to": "over"}
        keys = keys | {"k": keys["k"] | {"source": "answer"}}
    proof = prove(Mission.model_validate({
        "name": "kept", "initial": "asking", "blackboard": keys,
        "states": {
            "asking": {**asked, "transitions": [
                {"on": outcome, "when": {"key": first, "==": A}, "to": "first"},
                {"on": outcome, "do": do, "to": "judging"}, left]},
            "judging": {"transitions": [{"when": {"key": later, "==": B}, "to": "second"},
                                        {"after_s": 1, "to": "over"}]},
            **dict.fromkeys(("first", "second", "over"), OVER),
        },
    }))  # fmt: skip
    assert proof.never == ()


def test_what_is_compared_with_what_an_event_brings_on_can_be_the_same() -> None:
    proof = prove(Mission.model_validate({
        "name": "raised", "initial": "here", "events": {"go": {"fields": {"m": "string"}}},
        "blackboard": {"word": {"type": "string", "source": "robot"}, "draft": WORD, "mode": WORD},
        "states": {
            "here": {"entry": [{"set": "draft", "value": A}, {"raise": "go", "data": {"m": {"from": "draft"}}}],
                     "transitions": [{"on": "go", "to": "judging", "do": [{"set": "mode", "from": "event.m"}]}]},
            "judging": {"transitions": [{"when": {"key": "word", "==": {"key": "mode"}}, "to": "found"},
                                        {"after_s": 1, "to": "over"}]},
            "found": OVER, "over": OVER,
        },
    }))  # fmt: skip
    assert proof.never == ()


@pytest.mark.parametrize("source", ["seen", "event.thing"])
@pytest.mark.parametrize(("field", "kind", "looked"), [("name", WORD, "wanted"), ("box", OBJECT, "wanted.name")])
@pytest.mark.parametrize("hops", [1, 2])
def test_a_field_of_a_copied_object_can_be_all_that_guards_look_for(
    source: str, field: str, kind: Json, looked: str, hops: int
) -> None:
    copies = ["first", "second"][:hops]
    put = [{"set": to, "from": of} for to, of in zip(copies, [source, *copies], strict=False)]
    proof = prove(Mission.model_validate({
        "name": "copied", "initial": "here", "events": {"go": {"fields": {"thing": "object"}}},
        "blackboard": {"seen": {**OBJECT, "source": "robot"}, **dict.fromkeys(copies, OBJECT), "wanted": kind},
        "states": {
            "here": {"transitions": [
                {"on": "go", "to": "there", "do": [*put, {"set": "wanted", "from": f"{copies[-1]}.{field}"}]}]},
            "there": {"transitions": [{"when": {"key": looked, "==": "cup"}, "to": "found"},
                                      {"after_s": 1, "to": "over"}]},
            "found": OVER, "over": OVER,
        },
    }))  # fmt: skip
    assert (proof.sampled, proof.never) == ((), ())


@pytest.mark.parametrize(("looked", "sampled"), [("node.name", ("node.next",)), ("other", ())])
def test_what_is_copied_out_of_itself_is_tried_with_some_values_only(looked: str, sampled: tuple[str, ...]) -> None:
    proof = prove(Mission.model_validate({
        "name": "walking", "initial": "here", "events": {"go": {"fields": {"node": "object"}}, "on": {}},
        "blackboard": {"node": OBJECT, "other": WORD},
        "states": {
            "here": {"transitions": [
                {"on": "go", "do": [{"set": "node", "from": "event.node"}]},
                {"on": "on", "do": [{"set": "node", "from": "node.next"}]},
                {"when": {"key": looked, "==": "cup"}, "to": "over"}]},
            "over": OVER,
        },
    }))  # fmt: skip
    assert proof.sampled == sampled


def test_a_step_that_replaces_a_value_is_made_once_whatever_it_was() -> None:
    """One more value of `last` is one more step that writes it, and none of those that write over it."""

    def made(*words: str) -> int:
        put = [{"on": each, "to": "one", "do": [{"set": "last", "value": each}]} for each in words]
        go = {"on": "go", "to": "two", "do": [{"set": "last", "value": "other"}]}
        stop = {"on": "stop", "when": {"key": "last", "==": words[0]}, "to": "over"}
        space = Space(Environment(Mission.model_validate({
            "format": 1, "name": "replaced", "initial": "one", "events": {each: {} for each in (*words, "go", "stop")},
            "blackboard": {"last": {"type": "string", "initial": words[0]}},
            "states": {
                "one": {"transitions": [*put, go, stop]},
                "two": {"transitions": [{"when": {"key": "last", "==": "other"}, "to": "over"}]},
                "over": OVER,
            },
        })))  # fmt: skip
        space.explore()
        return space.made

    assert made("a", "b", "c") == made("a", "b") + 1


def test_a_step_that_looks_at_a_value_and_replaces_it_is_made_for_each() -> None:
    put = [{"on": each, "to": "one", "do": [{"set": "last", "value": each}]} for each in ("a", "b")]
    again = {"set": "last", "value": "a"}
    proof = prove(Mission.model_validate({
        "format": 1, "name": "replaced", "initial": "one", "events": {each: {} for each in ("a", "b", "go")},
        "blackboard": {"last": {"type": "string", "initial": "a"}},
        "states": {
            "one": {"transitions": [
                *put, {"on": "go", "when": {"key": "last", "==": "a"}, "to": "two", "do": [again]},
                {"on": "go", "to": "three", "do": [again]},
            ]},
            **{key: {"transitions": [{"on": "go", "to": "over"}]} for key in ("two", "three")}, "over": OVER,
        },
    }))  # fmt: skip
    assert proof.never == ()


def _states_of_tasks(count: int) -> int:
    """The states of a mission that does one of so many tasks, each with an argument of its own."""
    names = range(count)
    argument: Json = {"type": "string", "source": "argument", "initial": ""}
    places: Json = {f"place_{at}": argument for at in names}
    choices = [{"when": {"key": "task", "==": str(at)}, "to": f"task_{at}"} for at in names]
    ways = [{"on": "succeeded", "to": "done"}, {"on": ["failed", "unverified"], "to": "over"}]
    tasks: Json = {
        f"task_{at}": {
            "action": "drive", "achieved": {"key": "here", "==": {"key": f"place_{at}"}}, "transitions": ways,
        }
        for at in names
    }  # fmt: skip
    here: Json = {"type": "string", "source": "robot"}
    space = Space(Environment(Mission.model_validate({
        "format": 1, "name": "tasks", "initial": "choosing", "blackboard": {"task": argument, "here": here, **places},
        "states": {"choosing": {"transitions": choices}, **tasks, "done": {"final": "succeeded"}, "over": OVER},
    })), limits=1_000)  # fmt: skip
    space.explore()
    assert space.is_whole
    return space.states


def test_an_argument_that_is_not_looked_at_yet_distinguishes_no_states() -> None:
    states = [_states_of_tasks(count) for count in (2, 3, 4, 5)]
    assert len({more - less for less, more in pairwise(states)}) == 1, states

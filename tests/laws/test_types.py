# SPDX-License-Identifier: Apache-2.0
"""Every write is held to its key's type, wherever it comes from; what does not fit is refused, and the step states
it."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rai_missions.engine import Chart
from rai_missions.engine.step import Ask, CallService, StartGoal, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.keys import LIKE, Key, TypeName, pose_slip, type_error
from rai_missions.mission.mission import Mission

Json = dict[str, Any]
TYPES = ("string", "number", "integer", "boolean", "object", "list", "pose", "pose in map")
VALUES: tuple[Any, ...] = (
    "seven", "", 7, -1, 0.5, 5.0, 1e308, 10**400, True, False, {}, {"x": 1.0, "y": 2.0}, {"x": "far", "y": 0},
    {"x": 1.0, "y": 2.0, "frame": "map"}, {"x": 1.0, "y": 2.0, "frame": "odom"}, [], [1, "a"],
)  # fmt: skip
DOORS = ("event", "raised", "later", "add", "robot", "result", "call", "leaf", "answer", "each", "tree", "tree_add")
"""The ways by which something from elsewhere comes to be written."""
values = st.sampled_from(VALUES)


def mission_of(door: str, type_name: str, amount: float) -> Mission:
    """A mission in which the key `k` is written through one door, and `free` holds anything."""
    kind, _, frame = type_name.partition(" in ")
    key: Json = {"type": kind, "frame": frame, **({"source": "answer"} if door == "answer" else {})}
    take: Json = {"set": "k", "from": "event.v"}
    options = {"go": {"parameters": {"type": "object"}}, "stay": {}}
    passed_on: Json = {"raise": "f", "data": {"v": {"from": "event.v"}}}
    a: Json = {
        "event": {"transitions": [{"on": "e", "do": [take]}]},
        "raised": {"transitions": [{"on": "e", "do": [passed_on]}]},
        "later": {"transitions": [{"on": "e", "do": [{**passed_on, "after_s": 1}]}]},
        "add": {"transitions": [{"on": "e", "do": [{"set": "k", "add": amount}]}]},
        "robot": {"transitions": [{"on": "e", "do": [{"set": "k", "from": "r.v"}]}]},
        "result": {"action": "go", "result": {"k": "v"}},
        "call": {"call": "ask", "result": {"k": "v"}},
        "leaf": {"tree": {"sequence": [{"call": "ask", "result": {"k": "v"}}, {"wait_s": 1}]}},
        "answer": {"decision": {"question": "?", "options": options, "ask": ["x"], "attempts": 9, "fallback": "stay"}},
        "each": {"each": "l", "as": "k", "initial": "b", "states": {"b": {}}},
        "tree": {"tree": {"sequence": [{"set": "k", "from": "r.v"}, {"wait_s": 1}]}},
        "tree_add": {"tree": {"sequence": [{"set": "k", "add": amount}, {"wait_s": 1}]}},
    }[door]
    a = {**a, "transitions": [*a.get("transitions", []), {"on": "f", "do": [take]}]}
    waits = door in ("each", "tree", "tree_add")
    states = {"w": {"transitions": [{"on": "e", "to": "a"}]}, "a": a} if waits else {"a": a}
    ends = ["succeeded", "failed", "go", "stay"] if door == "answer" else ["succeeded", "failed"]
    a["transitions"].append({"on": ends, "to": "z"})
    keys = {"k": key, "r": {"type": "object", "source": "robot"}, "l": {"type": "list", "source": "robot"}}
    return Mission.model_validate(
        {
            "name": "typed",
            "initial": next(iter(states)),
            "states": {**states, "z": {}},
            "events": ["e", "f"],
            "blackboard": keys,
        }
    )


def through(door: str, made: Chart, value: Any) -> list[Step]:
    """Let a value come in through a door; the steps since."""
    made.write("r", {"v": value}, at=0.0)
    made.write("l", [value], at=0.0)
    first = made.start(0.0)
    numbers = [each.number for each in first.effects if isinstance(each, StartGoal | CallService)]
    numbers += [each.question.number for each in first.effects if isinstance(each, Ask)]
    if door == "answer":
        reported = {"option": "go", "parameters": {"k": value}}
        return [made.send(Event("x", 1.0, reported, "proposal", numbers[0]))]
    if numbers:
        return [made.send(Event("succeeded", 1.0, {"v": value}, "result", numbers[0]))]
    return [made.send(Event("e", 1.0, {"v": value})), made.send(Event("e", 3.0, {"v": value}))]


def known(made: Chart) -> Any:
    entry = made.view.board.get("k")
    return None if entry is None else entry.value


@pytest.mark.parametrize("door", DOORS)
@given(st.sampled_from(TYPES), values, values, st.sampled_from([1, 2.0, 0.5, 1e308]))
def test_a_key_holds_nothing_but_its_type(door: str, type_name: str, before: Any, value: Any, amount: float) -> None:
    mission = mission_of(door, type_name, amount)
    made, key = Chart(mission, CompiledTrees()), mission.blackboard["k"]
    old = None if type_error(key, before) else before
    made.write("k", before, at=0.0)
    steps = through(door, made, value)
    now = known(made)
    assert now is None or not type_error(key, now)
    if "add" not in door:
        assert now == (old if type_error(key, value) else value)
        if type_error(key, value):
            assert any(step.notes or any(move.trigger == "failed" for move in step.moves) for step in steps)
    elif type_name == "integer" and amount == int(amount) and isinstance(old, int):
        assert now > old and isinstance(now, int)


def test_what_is_reported_about_a_write_that_does_not_fit() -> None:
    made = Chart(mission_of("event", "integer", 1), CompiledTrees())
    made.write("k", 5, at=0.0)
    assert through("event", made, "seven")[0].notes == ("'k' was not written: 'seven' is not of type 'integer'",)
    made = Chart(mission_of("add", "integer", 0.5), CompiledTrees())
    made.write("k", 5, at=0.0)
    assert through("add", made, 0)[0].notes == ("'k' was not written: 5.5 is not of type 'integer'",)
    made = Chart(mission_of("add", "string", 1), CompiledTrees())
    made.write("k", "five", at=0.0)
    assert through("add", made, 0)[0].notes == ("'k' was not written: nothing can be added to 'five'",)


def test_a_key_with_a_frame_takes_poses_of_that_frame_alone() -> None:
    key = Key.model_validate({"type": "pose", "frame": "map"})
    assert type_error(key, {"x": 1, "y": 2, "frame": "map"}) == ""
    for given_frame in ({}, {"frame": ""}, {"frame": "odom"}):
        assert type_error(key, {"x": 1, "y": 2, **given_frame}).endswith(
            """is not in the frame of this key; it needs "frame": "map\""""
        )
    assert (
        type_error(key, 5)
        == """5 is not of type 'pose'; a pose is {"x": 1.5, "y": 2, "yaw": 0}, in metres and radians"""
    )
    with pytest.raises(ValidationError, match="only a pose has a 'frame', this is of type 'list'"):
        Key.model_validate({"type": "list", "frame": "map"})


@pytest.mark.parametrize("kind", [each for each in LIKE if each != "image"])
def test_one_who_wrote_a_value_that_does_not_fit_reads_one_that_does(kind: TypeName) -> None:
    made, of_field = Key(kind), Key("object", fields={"f": kind})
    unfit = 5 if kind != "number" and kind != "integer" else "five"
    for key, value in ((made, unfit), (of_field, {"f": unfit})):
        example = re.sub(", in metres and radians|true or ", "", type_error(key, value, written=True))
        fit = json.loads(re.sub("^.*(?: like| is) ", "", example))
        assert type_error(made, fit) == "", example


def test_one_who_wrote_a_value_reads_it_as_it_was_written() -> None:
    assert type_error(Key("number"), None, written=True).startswith("null is not of type 'number'")
    assert type_error(Key("number"), True, written=True).startswith("true is not of type 'number'")


def test_an_item_that_does_not_fit_ends_its_each_instead_of_a_round_with_the_item_before() -> None:
    made = Chart(mission_of("each", "integer", 1), CompiledTrees())
    step = through("each", made, "seven")[0]
    assert step.entered == ("a", "z")


@given(
    st.fixed_dictionaries(
        {"x": st.floats(-9, 9), "y": st.floats(-9, 9)}, optional={"z": st.floats(-9, 9), "yaw": st.floats(-400, 400)}
    ),
    st.sampled_from(["", "yaw_deg", "theta", "heading", "name"]),
)
def test_a_pose_that_a_person_wrote_has_its_own_words_and_turns_no_further_than_round(pose: Json, more: str) -> None:
    key, written = Key("pose"), {**pose, **({more: 90} if more else {})}
    why = pose_slip(key, written)
    assert not type_error(key, written)  # a robot may report it so
    assert bool(why) == bool(more or abs(pose.get("yaw", 0.0)) > 2 * math.pi)
    if why and not more:
        meant = float(why.rpartition(" ")[2])
        assert meant == pytest.approx(math.radians(pose["yaw"]), rel=1e-3)
        assert "radians" in why
    assert not pose_slip(Key("object"), written)


def test_an_answer_that_does_not_fit_its_key_is_refused_as_one_with_other_invalid_parameters() -> None:
    made = Chart(mission_of("answer", "integer", 1), CompiledTrees())
    (step,) = through("answer", made, "seven")
    assert step.entered == () and step.question is not None
    why = "the parameters of 'go' are not valid: k: 'seven' is not of type 'integer'"
    assert step.question.refused == (why,)

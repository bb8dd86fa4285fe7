# SPDX-License-Identifier: Apache-2.0
"""What Python authors write is what JSON reports."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from rai_missions import (
    After,
    CallEffect,
    DefinitionError,
    Drop,
    Elapsed,
    EventSpec,
    Held,
    In,
    Key,
    Keys,
    Log,
    Mission,
    Named,
    On,
    Publish,
    Raise,
    Ref,
    Say,
    Set,
    When,
    answer,
    event,
)
from rai_missions.guards import Guard
from rai_missions.model.validation_errors import validated
from rai_missions.states import Action, Decision, Each, Final, Option, State

k = Keys(
    alleys=Key(int, source="argument", initial=6),
    driven=Key(int, source="robot", max_age_s=5),
    battery=Key(float, source="robot", max_age_s=10),
    moving=Key(bool, source="robot"),
    here=Key("pose", source="robot"),
    home=Key("pose", source="argument"),
    kinds=Key(list, initial=[]),
    obstacle=Key(dict, source="robot", fields={"height_m": float, "living": bool, "fresh": bool}),
    scan=Key(dict, source="robot"),
)
LOW = {"key": "battery", "<": 0.15}
MOVES = {"key": "moving", "==": True}


@pytest.mark.parametrize(
    ("guard", "written"),
    [
        (k.battery < 0.15, LOW),
        (k.battery <= 1, {"key": "battery", "<=": 1}),
        (k.battery > 1, {"key": "battery", ">": 1}),
        (k.driven >= k.alleys, {"key": "driven", ">=": {"key": "alleys"}}),
        (k.driven == 3, {"key": "driven", "==": 3}),
        (k.driven != 3, {"key": "driven", "!=": 3}),
        (0.15 > k.battery, LOW),  # noqa: SIM300
        (k.scan.kind.is_in(("log", "branch")), {"key": "scan.kind", "in": ["log", "branch"]}),
        (k.scan.kind.is_in(k.kinds), {"key": "scan.kind", "in": {"key": "kinds"}}),
        (k.moving.is_true, MOVES),
        (k.moving.is_false, {"key": "moving", "==": False}),
        (~k.obstacle.living, {"key": "obstacle.living", "==": False}),
        (k.moving.held_for(2), {"held": MOVES, "for_s": 2}),
        (k.moving.or_unknown, {"possible": MOVES}),
        (k.obstacle.living.or_unknown, {"possible": {"key": "obstacle.living", "==": True}}),
        (k.battery.fresh, {"fresh": "battery"}),
        (~k.battery.fresh, {"not": {"fresh": "battery"}}),
        (k.obstacle["fresh"] == True, {"key": "obstacle.fresh", "==": True}),  # noqa: E712
        (k.here.near(k.home, within_m=0.5), {"near": ["here", "home"], "within_m": 0.5}),
        (k.here.x < 3, {"key": "here.x", "<": 3}),
        (event.distance_m < 5, {"key": "event.distance_m", "<": 5}),
        (answer.alley == k.alleys, {"key": "answer.alley", "==": {"key": "alleys"}}),
        (k.moving & (k.battery < 0.15), {"all": [MOVES, LOW]}),
        ((k.battery < 0.15) & k.moving, {"all": [LOW, MOVES]}),
        (k.moving | (k.battery < 0.15), {"any": [MOVES, LOW]}),
        ((k.battery < 0.15) | k.moving, {"any": [LOW, MOVES]}),
        (k.moving & k.obstacle.living & In("a"), {"all": [MOVES, {"key": "obstacle.living", "==": True}, {"in": "a"}]}),
        (~(k.moving & In("a")), {"not": {"all": [MOVES, {"in": "a"}]}}),
        (Held(k.moving, 2), {"held": MOVES, "for_s": 2}),
        ((k.battery < 0.15).held_for(2), {"held": LOW, "for_s": 2}),
        ((k.battery < 0.15).or_unknown, {"possible": LOW}),
        (Elapsed(5), {"elapsed_s": 5}),
        (Named("is_crossable", {"margin_m": 0.1}), {"named": "is_crossable", "with": {"margin_m": 0.1}}),
    ],
    ids=lambda given: str(given) if isinstance(given, dict) else "",
)
def test_operators_make_the_guards_that_json_has(guard: Guard, written: Any) -> None:
    assert guard == Guard.read(written)
    assert guard.written() == written


@pytest.mark.parametrize(
    ("transition", "written"),
    [
        (On("a", to="b"), {"on": "a", "to": "b"}),
        (On("a", "b", to=["c", "d"]), {"on": ["a", "b"], "to": ["c", "d"]}),
        (On(["a", "b"], of="s"), {"on": ["a", "b"], "of": "s"}),
        (
            On("a", when=k.moving, do=Set(k.kinds, [1])),
            {"on": "a", "when": MOVES, "do": [{"set": "kinds", "value": [1]}]},
        ),
        (When(k.battery < 0.15, to="b", about="low"), {"when": LOW, "to": "b", "about": "low"}),
        (
            When(~k.battery.fresh, to="b", internal=True),
            {"when": {"not": {"fresh": "battery"}}, "to": "b", "internal": True},
        ),
        (After(5, to="b", when=k.moving), {"after_s": 5, "when": MOVES, "to": "b"}),
    ],
    ids=lambda given: str(given) if isinstance(given, dict) else "",
)
def test_transitions_are_named_by_what_fires_them(transition: Any, written: Any) -> None:
    assert transition.written() == written


@pytest.mark.parametrize(
    ("effect", "written"),
    [
        (Set(k.alleys, 3), {"set": "alleys", "value": 3}),
        (Set(k.alleys, add=1), {"set": "alleys", "add": 1}),
        (Set(k.alleys, from_=event.count), {"set": "alleys", "from": "event.count"}),
        (
            Raise("again", after_s=5, id="x", data={"n": k.alleys}),
            {"raise": "again", "after_s": 5, "id": "x", "data": {"n": {"from": "alleys"}}},
        ),
        (Drop("x"), {"drop": "x"}),
        (CallEffect("horn", {"times": 2}), {"call": "horn", "request": {"times": 2}}),
        (Publish("lights", {"on": k.moving}), {"publish": "lights", "message": {"on": {"from": "moving"}}}),
        (Say("hello"), {"say": "hello"}),
        (Log("here"), {"log": "here"}),
    ],
    ids=lambda given: str(given) if isinstance(given, dict) else "",
)
def test_effects_take_references_where_json_has_paths(effect: Any, written: Any) -> None:
    assert effect.written() == written


def test_a_reference_is_wherever_a_state_has_a_guard_a_path_or_a_template() -> None:
    action = Action("go", goal={"pose": k.home, "at": [k.here.x]}, result={"alleys": "count"}, achieved=k.moving)
    assert action.written() == {
        "action": "go",
        "goal": {"pose": {"from": "home"}, "at": [{"from": "here.x"}]},
        "result": {"alleys": "count"},
        "achieved": MOVES,
    }
    assert Final("succeeded", requires=k.moving).written() == {"final": "succeeded", "requires": MOVES}
    decision = Decision("What?", evidence=[k.scan, k.here.x], options={"yes": Option("do", when=k.moving)})
    assert decision.written()["decision"]["evidence"] == ["scan", "here.x"]
    each = Each(k.kinds, item=k.alleys, initial="a", states={"a": State()})
    assert (each.each, each.item) == ("kinds", "alleys")


def test_a_mission_takes_keys_and_names_of_events() -> None:
    mission = Mission("m", keys=k, events=["a"], initial="s", states={"s": State()})
    assert list(mission.blackboard) == list(k.__keys__)
    assert mission == Mission.model_validate(mission.written())
    assert mission.blackboard["obstacle"].fields == {"height_m": "number", "living": "boolean", "fresh": "boolean"}


def test_the_fields_of_an_event_take_types_of_python_as_those_of_a_key_do() -> None:
    fields: dict[str, Any] = {"belt": int, "full": bool, "why": "string"}
    named = {"belt": "integer", "full": "boolean", "why": "string"}
    assert EventSpec(fields=fields).fields == Key(dict, fields=fields).fields == named


@pytest.mark.parametrize("kind", ["key", "event"])
def test_a_misspelled_type_of_a_field_is_reported_at_the_field(kind: str) -> None:
    fields: Any = {"belt": "int"}
    with pytest.raises(DefinitionError) as reported:
        Key(dict, fields=fields) if kind == "key" else EventSpec(fields=fields)
    assert [str(each) for each in reported.value.faults] == ["/fields/belt: no type 'int'; did you mean 'integer'?"]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda: k.batery, "no key 'batery'; did you mean 'battery'?"),
        (lambda: k.obstacle.heigth_m, "'obstacle' has no field 'heigth_m'; did you mean 'height_m'?"),
        (lambda: k.battery.volts, "'battery' has no field 'volts'; it is no object, a reference has: fresh,"),
        (lambda: k.moving.is_ture, "'moving' has no field 'is_ture'; did you mean 'is_true'?"),
        (lambda: k.obstacle.frsh, "'obstacle' has no field 'frsh'; did you mean 'fresh'?"),
        (lambda: k.here.heading, "'here' has no field 'heading'; there is: frame, x, y, yaw, z"),
    ],
)
def test_a_name_that_is_not_there_is_reported_with_the_nearest(wrong: Any, sentence: str) -> None:
    with pytest.raises(AttributeError) as reported:
        wrong()
    assert str(reported.value).startswith(sentence)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda: k.moving and k.battery < 1, "'moving' has no truth of its own; combine with & | ~"),
        (lambda: 0.1 < k.battery < 1, "a guard has no truth of its own"),
        (lambda: 3 in k.kinds, "what 'kinds' holds is known in a run"),
        (lambda: k.moving & 3, "3 is no guard; put brackets around comparisons"),
        (lambda: k.battery < 0.2 & k.moving, "0.2 is no guard; put brackets around comparisons"),
        (lambda: k.battery < 2 & Named("on"), "2 is no guard; put brackets around comparisons"),
        (lambda: k.battery < 2 | Named("on"), "2 is no guard; put brackets around comparisons"),
        (lambda: Named("on") & k.battery < 2, "a guard is compared with nothing; put brackets around comparisons"),
        (lambda: Named("on") | k.battery >= 2, "a guard is compared with nothing; put brackets around comparisons"),
        (lambda: (k.battery < 0.2) & 3, "unsupported operand"),
        (lambda: Action("go", "home"), "Action takes by position: action; 2 values were given"),
    ],
)
def test_what_python_would_misread_is_refused(wrong: Any, sentence: str) -> None:
    with pytest.raises(TypeError) as reported:
        wrong()
    assert sentence in str(reported.value)


def test_a_comparison_that_json_could_not_state_is_refused() -> None:
    with pytest.raises(DefinitionError, match="is not JSON; give text"):
        _ = k.battery < object()


def test_references_can_be_copied_hashed_and_shown() -> None:
    assert repr(copy.deepcopy(k.obstacle.height_m)) == "<obstacle.height_m>"
    assert repr(k).startswith("Keys(alleys, driven")
    assert len({k.battery, k.moving}) == 2
    assert isinstance(k.battery, Ref)


def test_what_a_constructor_lacks_is_named_as_the_constructor_has_it() -> None:
    words: dict[str, Any] = {"initial": "at", "states": {"at": Final("succeeded")}}
    with pytest.raises(DefinitionError, match=r"Each\(…\): /: 'item' is missing; a state with 'each' needs it"):
        Each("places", **words)
    states = {"a": {"each": "places", "initial": "at", "states": {"at": {"final": "succeeded"}}}}
    with pytest.raises(DefinitionError, match="/states/a: 'as' is missing; a state with 'each' needs it"):
        validated(Mission, {"name": "m", "initial": "a", "states": states})


def test_a_word_is_known_by_its_form_in_python_and_in_json() -> None:
    inside: dict[str, Any] = {"initial": "a", "states": {"a": State()}, "as_": "place"}
    with pytest.raises(DefinitionError, match=r"/as_: .* has no 'as_'; did you mean 'item'\?"):
        Each("places", item="place", **inside)
    listed = {"each": "places", "item": "place", "initial": "a", "states": {"a": {}}}
    with pytest.raises(DefinitionError, match=r"/states/b/item: .* has no 'item'; did you mean 'as'\?"):
        validated(Mission, {"format": 1, "name": "m", "initial": "b", "states": {"b": listed}}, "m.json")


def test_a_state_that_is_not_there_is_reported_with_the_nearest() -> None:
    over = Mission("m", initial="over", states={"over": Final("aborted")})
    with pytest.raises(KeyError, match=r"no state 'ovr'; did you mean 'over'\?"):
        over.state("ovr")

# SPDX-License-Identifier: Apache-2.0
"""The JSON Schema is the one the models make, accepts what they accept, and refuses what they refuse."""

from __future__ import annotations

import copy
import functools
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

import rai_missions
from rai_missions.mission.mission import Mission
from rai_missions.mission.schema import mission_schema
from tests.strategies import mission_documents

ROOT = Path(__file__).parents[2]
SHIPPED = Path(rai_missions.__file__).with_name("mission.schema.json")
SCHEMA = jsonschema.Draft202012Validator(mission_schema())
MISSIONS = [ROOT / "tests/data/tractor_design.json", *sorted(ROOT.glob("missions/*/mission.json"))]
SHIPPED_ONES = [json.loads(file.read_text(encoding="utf-8")) for file in MISSIONS]
SMALL: dict[str, Any] = {"format": 1, "name": "small", "initial": "a", "states": {"a": {}}}


def test_the_shipped_schema_is_the_one_the_models_make() -> None:
    made = json.dumps(mission_schema(), indent=2, ensure_ascii=False) + "\n"
    reported = "the format has changed: run `rai-missions schema > rai_missions/mission.schema.json`"
    also = "; a changed guard or key changes `rai-missions schema robot > rai_missions/robot.schema.json` too"
    assert SHIPPED.read_text(encoding="utf-8") == made, reported + also


def test_the_schema_is_a_schema_with_a_description_for_every_kind() -> None:
    schema = mission_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    plain = [name for name, each in schema["$defs"].items() if "description" not in each and "allOf" not in each]
    assert plain == []
    assert "x-family" not in json.dumps(schema)


@pytest.mark.parametrize("file", MISSIONS, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_schema_accepts_every_shipped_mission(file: Path) -> None:
    SCHEMA.validate(json.loads(file.read_text(encoding="utf-8")))


@given(mission_documents())
def test_the_schema_accepts_what_the_models_accept_and_what_they_write(document: Any) -> None:
    SCHEMA.validate(document)
    SCHEMA.validate(Mission.model_validate(document).written())


def state(**words: Any) -> dict[str, Any]:
    return SMALL | {"states": {"a": words}}


def transition(**words: Any) -> dict[str, Any]:
    return state(transitions=[words])


def when(guard: Any) -> dict[str, Any]:
    return transition(to="a", when=guard)


def key(**words: Any) -> dict[str, Any]:
    return SMALL | {"blackboard": {"k": words}}


OPTIONAL = [
    SMALL | {"format": True},
    SMALL | {"on_cancel": None},
    state(action="go", timeout_s=None),
    state(control=None),
    state(final="failed", requires=None),
    transition(on="e", after_s=None),
    key(type="number", max_age_s=None),
    key(type="object", initial=None),
    transition(on=[], to="a"),
]
"""What equals a default, or the format's number, without being written so."""
DECISION = {"question": "?", "options": {"yes": {}}}


@pytest.mark.parametrize(
    "document",
    [
        [],
        {},
        SMALL | {"format": 2},
        SMALL | {"name": "A b"},
        SMALL | {"fromat": 1},
        SMALL | {"states": {}},
        SMALL | {"states": {"A": {}}},
        SMALL | {"initial": []},
        SMALL | {"events": {"e": {"x": 1}}},
        SMALL | {"cancel_s": -1},
        SMALL | {"transitions": {}},
        SMALL | {"invariants": {"i": {}}},
        state(acton="go"),
        state(action="go", call="ring"),
        state(final="done"),
        state(timeout_s=0),
        state(states={"b": {}}),
        state(each="k", states={"b": {}}, initial="b"),
        state(parallel={}),
        state(history="wide"),
        state(control="nobody"),
        state(action="go", goal=[]),
        state(mission=3),
        state(entry=[{"set": "k"}]),
        state(entry=[{"set": "k", "value": 1, "add": 2}]),
        state(entry={"say": "x"}),
        state(entry=[{"set": "k", "value": None}]),
        state(entry=[{"set": "k", "from_": "b"}]),
        state(entry=[{"raise": "e", "after_s": -1}]),
        state(exit=[{"shout": "x"}]),
        transition(to="a"),
        transition(on="e", after_s=1),
        transition(of="a", when={"in": "a"}),
        transition(on="e", too="a"),
        transition(on=3),
        when({"key": "k"}),
        when({"key": "k", "<": 1, ">": 2}),
        when({"key": "k", "<": None}),
        when({"key": "k", "in": 3}),
        when({"all": {}}),
        when({"near": ["k"], "within_m": 1}),
        when({"held": {"in": "a"}}),
        when({"in": "a", "fresh": "k"}),
        key(),
        key(type="float"),
        key(type="number", source="robot", initial=1),
        key(type="number", fields={"a": "number"}),
        key(type="number", max_age_s=0),
        state(decision={"options": {"yes": {}}}),
        state(decision=DECISION | {"attempts": 0}),
        state(decision=DECISION | {"options": {}}),
        state(decision=DECISION | {"ask": []}),
        state(decision=DECISION | {"options": {"succeeded": {}}}),
        *OPTIONAL,
        state(tree={}),
        state(tree={"sequence": []}),
        state(tree={"retry": 0, "child": {"wait_s": 1}}),
        state(tree={"inverter": [{"wait_s": 1}]}),
        state(tree={"parallel": [{"wait_s": 1}], "policy": "all"}),
    ],
    ids=json.dumps,
)
def test_the_schema_and_the_models_refuse_alike(document: Any) -> None:
    assert not SCHEMA.is_valid(document)
    with pytest.raises(ValidationError):
        Mission.model_validate(document)


VALUES: list[Any] = [
    None, True, False, 0, 1, -1, -0.0, 1.0, 2.5, 1e300, 2**62, "", "a", "A", "ä", "a/b", "a.b", "event.x", "*", "robot",
    "number", "succeeded", [], {}, [None], [1], ["a"], [["a"]], {"a": 1}, {"key": "a"}, {"key": "a", "==": 1},
    {"from": "a"}, {"in": "a"}, {"a": None}, {"all": []}, {"final": "succeeded"}, {"type": "object"},
]  # fmt: skip
WORDS = sorted(
    {"a", "B", "", *(word for each in mission_schema()["$defs"].values() for word in each.get("properties", ()))}
)
"""What an object may be given: each word of the format, and some that are none."""


def places(value: Any, *steps: str | int) -> list[tuple[str | int, ...]]:
    """Where something is in a document, itself left out."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place for name, item in items for place in ((*steps, name), *places(item, *steps, name))]


@st.composite
def changed(draw: st.DrawFn) -> Any:
    """A mission in which one or two places were dropped, renamed, retyped, nested, or have another's value."""
    document = copy.deepcopy(draw(st.one_of(st.sampled_from(SHIPPED_ONES), mission_documents())))
    for _ in range(draw(st.integers(1, 2))):
        *above, last = draw(st.sampled_from(places(document)))
        parent = functools.reduce(lambda inside, step: inside[step], above, document)
        was, word = parent[last], draw(st.sampled_from(WORDS))
        values = [
            *VALUES,
            [was],
            {word: was},
            str(was),
            float(was) if isinstance(was, int) else was,
            functools.reduce(lambda inside, step: inside[step], draw(st.sampled_from(places(document))), document),
        ]
        how = draw(st.sampled_from(["drop", "rename", "add", "value", "value", "value"]))
        if how in ("drop", "rename"):
            del parent[last]
        if how != "drop":
            value = was if how == "rename" else draw(st.sampled_from(values))
            place = word if isinstance(parent, dict) and how in ("rename", "add") else last
            if isinstance(parent, list) and how in ("rename", "add"):
                parent.append(copy.deepcopy(value))
            else:
                parent[place] = copy.deepcopy(value)
        if not places(document):
            break
    return document


def is_left_to_the_loader(error: Any) -> bool:
    """Whether a fault is of those that the guide lists as beyond a JSON Schema."""
    if error["type"] == "int_type":
        return isinstance(error["input"], float) and error["input"].is_integer()
    if error["loc"] == ("format",):
        return isinstance(error["input"], float) and error["input"] == 1
    return error["type"] in ("fallback", "initial")


@given(changed())
def test_schema_and_loader_agree_on_missions_that_were_changed(document: Any) -> None:
    try:
        Mission.model_validate(document)
        faults: list[Any] = []
    except ValidationError as error:
        faults = error.errors()
    assert SCHEMA.is_valid(document) is all(map(is_left_to_the_loader, faults))

# SPDX-License-Identifier: Apache-2.0
"""What a model refuses reaches the author as places and plain sentences, all at once."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rai_missions import DefinitionError, Mission, load
from rai_missions.model.validation_errors import faults_of
from rai_missions.states import Action
from tests.strategies import mission_documents

SMALL: dict[str, Any] = {"format": 1, "name": "small", "initial": "a", "states": {"a": {}}}


def faults_in(tmp_path: Path, document: Any) -> list[str]:
    file = tmp_path / "m.json"
    file.write_text(json.dumps(document))
    with pytest.raises(DefinitionError) as refused:
        load(file)
    assert refused.value.source == str(file)
    return [str(fault) for fault in refused.value.faults]


def transition(**words: Any) -> dict[str, Any]:
    return SMALL | {"states": {"a": {"transitions": [words]}}}


def state(**words: Any) -> dict[str, Any]:
    return SMALL | {"states": {"a": words}}


def entry(**words: Any) -> dict[str, Any]:
    return state(entry=[words])


def when(guard: Any) -> dict[str, Any]:
    return transition(to="a", when=guard)


def tree(node: Any) -> dict[str, Any]:
    return state(tree=node)


NAME = "is not a name; a name is lower case letters, digits and '_', a letter first"
TRANSITION, ENTRY = "/states/a/transitions/0", "/states/a/entry/0"


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ([1], "/: a mission is a JSON object, not [1]"),
        (
            state(history="deep", transitions=[{"when": {"fresh": "k"}, "to": "a"}]),
            TRANSITION + ": a history's transition has only where it leads without memory, 'to'; this has when",
        ),
        (
            state(history="deep", transitions=[{"on": "e"}]),
            TRANSITION + ": a history's transition has only where it leads without memory, 'to'; this has on",
        ),
        (
            state(history="deep", transitions=[{}]),
            TRANSITION + ": a history's transition has only where it leads without memory, 'to'; this has none",
        ),
        ({"name": "x", "states": {"a": {}}}, "/: 'initial' is missing; a mission needs it"),
        (SMALL | {"format": 2}, "/format: no such choice: 2; it is 1"),
        (SMALL | {"name": "Größe ÜBER"}, f"/name: 'Größe ÜBER' {NAME}; did you mean 'grosse_uber'?"),
        (SMALL | {"name": "оff"}, f"/name: 'оff' {NAME}; 'о' is CYRILLIC SMALL LETTER O"),
        (SMALL | {"name": "of\u200bf"}, rf"/name: 'of\u200bf' {NAME}; '\u200b' is ZERO WIDTH SPACE"),
        (SMALL | {"name": "of\x85f"}, rf"/name: 'of\x85f' {NAME}; '\x85' is no letter"),
        (SMALL | {"fromat": 1}, "/fromat: a mission has no 'fromat'; did you mean 'format'?"),
        (SMALL | {"name": "Small Mission"}, f"/name: 'Small Mission' {NAME}; did you mean 'small_mission'?"),
        (SMALL | {"name": 5}, "/name: 5 is not text; write a word in quotes"),
        (SMALL | {"name": None}, "/name: null is not text; write a word in quotes"),
        (SMALL | {"about": None}, "/about: null is no value; leave the word out"),
        (state(action="a", timeout_s=None), "/states/a/timeout_s: null is no value; leave the word out"),
        (state(entry=[None]), "/states/a/entry/0: an effect is an object, not null"),
        (transition(on=None, to="a"), TRANSITION + "/on: null is no value; leave the word out"),
        (SMALL | {"initial": "aB"}, f"/initial: 'aB' {NAME}; did you mean 'a_b'?"),
        (SMALL | {"initial": ["a", 1]}, "/initial/1: 1 is not text; write a word in quotes"),
        (SMALL | {"initial": []}, "/initial: 0 given; write 1 or more"),
        (SMALL | {"states": []}, "/states: [] is not an object; write {…}"),
        (SMALL | {"states": {}}, "/states: 0 given; write 1 or more"),
        (
            state(transitions=[{"when": {"near": [], "within_m": 1}}]),
            TRANSITION + "/when/near: 0 given; write 2 or more",
        ),
        (
            state(transitions=[{"when": {"near": ["k"], "within_m": 1}}]),
            TRANSITION + "/when/near: 1 given; write 2 or more",
        ),
        (
            state(transitions=[{"when": {"near": ["k", "k", "k"], "within_m": 1}}]),
            TRANSITION + "/when/near: 3 given; write 2 at the most",
        ),
        (SMALL | {"states": {"a": 1}}, "/states/a: a state is an object, not 1; write {…}"),
        (SMALL | {"states": {"A-1": {}}}, f"/states/A-1: 'A-1' {NAME}; did you mean 'a_1'?"),
        (SMALL | {"blackboard": {"a/B": {"type": "number"}}}, f"/blackboard/a~1B: 'a/B' {NAME}; did you mean 'a/b'?"),
        (
            SMALL | {"blackboard": {"k": {"type": "nubmer"}}},
            "/blackboard/k/type: no such choice: 'nubmer'; did you mean 'number'?",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "number", "source": "robot", "initial": 1}}},
            "/blackboard/k/initial: a robot key has no 'initial': it is unknown until the robot reports it",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "string", "source": "argument", "minimum": 1}}},
            "/blackboard/k/minimum: only an argument of type 'number' or 'integer' has a 'minimum'",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "number", "source": "robot", "maximum": 1}}},
            "/blackboard/k/maximum: only an argument of type 'number' or 'integer' has a 'maximum'",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "number", "source": "argument", "minimum": 2, "maximum": 1.5}}},
            "/blackboard/k/maximum: 1.5 is less than the minimum, 2; no value fits",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "integer", "source": "argument", "minimum": 2, "initial": 1}}},
            "/blackboard/k/initial: 'initial' does not fit: 1 is out of range; it must be 2 or more",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "string", "enum": ["a"]}}},
            "/blackboard/k/enum: only an argument of type 'string' has an 'enum'",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "string", "source": "argument", "enum": ["a", "b", "a"]}}},
            "/blackboard/k/enum/2: 'a' is there twice; keep one",
        ),
        (
            SMALL | {"blackboard": {"k": {"type": "string", "source": "argument", "enum": ["near"], "initial": "far"}}},
            "/blackboard/k/initial: 'initial' does not fit: there is no 'far'; there is: near",
        ),
        (SMALL | {"events": ["go", "stop", "go"]}, "/events/2: the event 'go' is declared already; keep one"),
        (SMALL | {"cancel_s": True}, "/cancel_s: true is not a number; write one, without quotes"),
        (SMALL | {"ready_s": -1}, "/ready_s: -1 is too small; it must be 0 or more"),
        (SMALL | {"settle_s": "5"}, "/settle_s: '5' is not a number; write one, without quotes"),
        (state(timeout_s=0), "/states/a/timeout_s: 0 is too small; it must be more than 0"),
        (
            state(wait=5),
            "/states/a: a state has no 'wait'; there is: about, action, call, control, decision, each, entry, exit, "
            "final, handover_s, history, mission, …",
        ),
        (state(acton="go"), "/states/a: a state has no 'acton'; did you mean 'action'?"),
        (state(regions={}), "/states/a: a state has no 'regions'; did you mean 'parallel'?"),
        (state(on={}), "/states/a: a state has no 'on'; did you mean 'transitions'?"),
        (state(request={}, service="horn"), "/states/a: a state has no 'service'; did you mean 'call'?"),
        (state(request={}), "/states/a: a state has no 'request'; it belongs to one with 'call'"),
        (state(action="go", on={}), "/states/a/on: a state with 'action' has no 'on'; did you mean 'transitions'?"),
        (transition(on="e", target="a"), f"{TRANSITION}/target: a transition has no 'target'; did you mean 'to'?"),
        (
            transition(on="e", to="a", guard={}),
            f"{TRANSITION}/guard: a transition has no 'guard'; did you mean 'when'?",
        ),
        (state(action="go", gaol={}), "/states/a/gaol: a state with 'action' has no 'gaol'; did you mean 'goal'?"),
        (state(action="go", goal=[]), "/states/a/goal: [] is not an object; write {…}"),
        (state(action="a", call="b"), "/states/a: a state is one thing, this is 2: action, call; nest or split it"),
        (
            state(action="go", over_orphan=1),
            "/states/a/over_orphan: 1 is neither true nor false; write one of them, without quotes",
        ),
        (
            state(final="done"),
            "/states/a/final: no such choice: 'done'; there is: aborted, canceled, failed, succeeded",
        ),
        (state(control="agnet"), "/states/a/control: no such choice: 'agnet'; did you mean 'agent'?"),
        (transition(on="e", too="a"), f"{TRANSITION}/too: a transition has no 'too'; did you mean 'to'?"),
        (
            transition(to="a"),
            f"{TRANSITION}: a transition without 'on', 'after_s' and 'when' would fire at once, always; "
            "give one of them",
        ),
        (
            transition(on="e", after_s=1),
            f"{TRANSITION}: a transition has 'on' or 'after_s', not both; write two transitions",
        ),
        (when({"kye": "a", "<": 1}), f"{TRANSITION}/when: no guard is written ['<', 'kye']; did you mean 'key'?"),
        (
            when({"key": "a", "less": 1}),
            f"{TRANSITION}/when/less: a guard with 'key' has no 'less'; did you mean '<',"
            ' as in {"key": "battery", "<": 0.3}?',
        ),
        (
            when({"all": [{"key": "Obstacle.height", "<": 1}]}),
            f"{TRANSITION}/when/all/0/key: 'Obstacle.height' is neither a key nor a field of one; "
            "write it like 'obstacle.height_m'; did you mean 'obstacle.height'?",
        ),
        (when({"all": {}}), f"{TRANSITION}/when/all: {{}} is not a list; write […]"),
        (
            when({"key": "a"}),
            f"{TRANSITION}/when: a comparison has one of ==, !=, <, <=, >, >=, in, this has none;"
            ' write it like {"key": "battery", "<": 0.3}',
        ),
        (entry(set="a", add="1"), f"{ENTRY}/add: '1' is not a number; write one, without quotes"),
        (entry(set="a", from_="b"), f"{ENTRY}/from_: an effect with 'set' has no 'from_'; did you mean 'from'?"),
        (entry(set="a"), f"{ENTRY}: 'set' takes one of value, from, add; this has 0"),
        (
            entry(set="a", value={"x": {"from": "event.x"}}),
            f"{ENTRY}/value/x: 'event.x' is a reference inside a value;"
            " 'set' takes a constant, or a reference as a whole",
        ),
        (tree({"sequnce": []}), "/states/a/tree: no tree node is written ['sequnce']; did you mean 'sequence'?"),
        (
            tree({"retry": 1.5, "child": {"wait_s": 1}}),
            "/states/a/tree/retry: 1.5 is not a whole number; write one, without quotes",
        ),
        (
            tree({"parallel": [{"wait_s": 1}], "policy": "success_on_al"}),
            "/states/a/tree/policy: no such choice: 'success_on_al'; did you mean 'success_on_all'?",
        ),
    ],
)
def test_a_fault_reports_where_what_and_what_instead(tmp_path: Path, document: Any, sentence: str) -> None:
    assert faults_in(tmp_path, document) == [sentence]


def test_every_fault_is_reported_at_once_in_the_order_of_the_document(tmp_path: Path) -> None:
    document = SMALL | {
        "name": "A",
        "states": {
            "a": {"final": "x"},
            "b": {"entry": [{"say": 1}, {"set": "k"}], "transitions": [{"on": "e", "t": 1}]},
        },
        "on_cancel": 3,
    }
    places = [line.partition(": ")[0] for line in faults_in(tmp_path, document)]
    expected = ["/name", "/states/a/final", "/states/b/entry/0/say", "/states/b/entry/1", "/states/b/transitions/0/t"]
    assert places == [*expected, "/on_cancel"]


def test_thousands_of_faults_are_counted_not_reported(tmp_path: Path) -> None:
    lines = faults_in(tmp_path, SMALL | {"states": {f"s{number}": 1 for number in range(1500)}})
    assert len(lines) == 1001
    assert lines[-1] == "/: and 500 more faults; mend these first"


def test_a_constructor_refuses_with_the_same_sentences() -> None:
    with pytest.raises(DefinitionError) as refused:
        Action("go", timeout_s="long", gaol={})
    assert str(refused.value).splitlines() == [
        "Action(…): /timeout_s: 'long' is not a number; write one, without quotes",
        "Action(…): /gaol: a state with 'action' has no 'gaol'; did you mean 'goal'?",
    ]


@st.composite
def bent_documents(draw: st.DrawFn) -> Any:
    """A good mission in which something, anywhere, was replaced."""
    document = copy.deepcopy(draw(mission_documents()))
    place: Any = document
    for _ in range(draw(st.integers(0, 8))):
        steps: list[Any] = list(place) if isinstance(place, dict) else list(range(len(place)))
        inner = [step for step in steps if isinstance(place[step], dict | list) and place[step]]
        if not inner:
            break
        place = place[draw(st.sampled_from(inner))]
    step = draw(st.sampled_from(list(place) if isinstance(place, dict) else list(range(len(place)))))
    junk: st.SearchStrategy[Any] = st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=5),
        st.just([]),
        st.just({}),
        st.just({"": 1}),
        st.just([[]]),
        st.just({"self": {}, "cls": 1}),
        st.sampled_from(list(document["states"])),
    )
    if isinstance(place, dict) and draw(st.booleans()):
        place[draw(st.text(max_size=4))] = draw(junk)
    else:
        place[step] = draw(junk)
    return document


@given(bent_documents())
def test_whatever_a_document_states_it_is_a_mission_or_faults_in_our_words(document: Any) -> None:
    try:
        Mission.model_validate(document)
    except ValidationError as error:
        for fault in faults_of(error, Mission, document):
            assert "Input should" not in fault.sentence
            assert "does not belong here" not in fault.sentence
            assert str(fault).encode()

# SPDX-License-Identifier: Apache-2.0
"""What is sent has no gap in it: a goal, request or message with an unknown part stays with the mission."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import CallService, PublishMessage, StartGoal, Step
from rai_missions.event import Event, Tick
from rai_missions.trees import PyTrees
from tests.rigs.charts import mission, transition

KEYS = {
    "n": {"type": "number"},
    "far": {"type": "number", "source": "robot", "optional": True},
    "seen": {"type": "object", "source": "robot", "max_age_s": 5, "optional": True},
}
PATHS = ("n", "far", "seen", "seen.x", "seen.at.y")
VALUES = {"n": 1.5, "far": 7.0, "seen": {"x": 2, "at": {"y": 0}}}
PARTS = st.recursive(
    st.one_of(st.sampled_from(PATHS).map(lambda path: {"from": path}), st.integers(), st.none()),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from("abc"), inner, max_size=3)),
    max_leaves=6,
)
TEMPLATES = st.one_of(
    st.dictionaries(st.sampled_from("abc"), PARTS, max_size=3), st.sampled_from(PATHS).map(lambda path: {"from": path})
)
LEFT = {"transitions": [transition("succeeded", "well"), transition(["failed", "rejected"], "ill")]}
EFFECT = {"transitions": [transition("call_failed", "ill")]}
CARRIERS: Mapping[str, Any] = {
    "goal": lambda sent: {"action": "act", "goal": sent, **LEFT},
    "request": lambda sent: {"call": "act", "request": sent, **LEFT},
    "goal of a tree": lambda sent: {"tree": {"action": "act", "goal": sent}, **LEFT},
    "request of a tree": lambda sent: {"tree": {"call": "act", "request": sent}, **LEFT},
    "message of a tree": lambda sent: {
        "tree": {"sequence": [{"publish": "act", "message": sent}, {"wait_s": 9}]},
        **LEFT,
    },
    "request of an effect": lambda sent: {"entry": [{"call": "act", "request": sent}], **EFFECT},
    "message of an effect": lambda sent: {"entry": [{"publish": "act", "message": sent}], **EFFECT},
}


def value_at(path: str, known: Mapping[str, Any]) -> Any:
    value: Any = known
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def expected(template: Any, known: Mapping[str, Any]) -> tuple[Any, bool]:
    """What a template comes to, and whether all that it refers to is known."""
    if isinstance(template, dict) and set(template) == {"from"}:
        value = value_at(template["from"], known)
        return value, value is not None
    if isinstance(template, dict):
        pairs = {name: expected(item, known) for name, item in template.items()}
        return {name: value for name, (value, _) in pairs.items()}, all(whole for _, whole in pairs.values())
    if isinstance(template, list):
        items = [expected(item, known) for item in template]
        return [value for value, _ in items], all(whole for _, whole in items)
    return template, True


@given(template=TEMPLATES, names=st.sets(st.sampled_from(sorted(VALUES))))
def test_a_predicate_is_asked_with_the_values_of_now_and_none_is_unknown(
    template: dict[str, Any], names: set[str]
) -> None:
    asked: list[Any] = []

    def looks(board: object, **given_: Any) -> bool:
        asked.append(given_)
        return True

    states = {"wait": {"transitions": [transition("e", "act", when={"named": "looks", "with": template})]}, "act": {}}
    made = Chart(mission(states, blackboard=KEYS), named={"looks": looks})
    made.start(0.0)
    known = {name: VALUES[name] for name in names}
    for name, value in known.items():
        made.write(name, value, at=0.5)
    asked.clear()
    made.send(Event("e", 1.0))
    fields, is_whole = expected(template, known)
    is_asked = is_whole and isinstance(fields, dict)
    assert made.active == {"act" if is_asked else "wait"}
    assert all(each == fields for each in asked) and bool(asked) is is_asked


def sent_in(step: Step) -> list[Any]:
    found = []
    for effect in step.effects:
        match effect:
            case StartGoal():
                found.append(effect.goal)
            case CallService():
                found.append(effect.request)
            case PublishMessage():
                found.append(effect.message)
    return found


@pytest.mark.parametrize("carrier", CARRIERS)
@pytest.mark.parametrize("on_py_trees", [False, True])
@given(template=TEMPLATES, names=st.sets(st.sampled_from(sorted(VALUES))))
def test_what_is_sent_has_the_values_of_now_and_none_is_unknown(
    carrier: str, on_py_trees: bool, template: dict[str, Any], names: set[str]
) -> None:
    states = {"wait": {"transitions": [{"after_s": 1, "to": "act"}]}, "act": CARRIERS[carrier](template)}
    whole = mission(states | {"well": {}, "ill": {}}, blackboard=KEYS, events=[])
    made = Chart(whole, PyTrees() if on_py_trees else None)
    made.start(0.0)
    known = {name: VALUES[name] for name in names}
    for name, value in known.items():
        made.write(name, value, at=0.5)
    step = made.send(Tick(1.0))
    fields, is_whole = expected(template, known)
    if is_whole and isinstance(fields, dict):
        assert sent_in(step) == [fields] and made.active == {"act"}
        return
    assert sent_in(step) == []
    assert made.active == ({"act"} if "message" in carrier else {"ill"})
    assert any("unknown" in str(note) or "no fields" in str(note) for note in step.notes)

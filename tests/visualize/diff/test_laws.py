# SPDX-License-Identifier: Apache-2.0
"""Laws of the comparison: it is by meaning, it misses nothing, and a rename is a rename."""

from __future__ import annotations

import copy
import functools
import itertools
import json
from collections.abc import Iterator
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rai_missions.errors import DefinitionError
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from tests.strategies import KEYS, guards, mission_documents, missions
from tests.visualize.runs import document
from visualize import difference
from visualize.diff.fields import relation

BOARD = Mission.model_validate({**document(), "blackboard": KEYS, "transitions": [], "invariants": {}}).blackboard


def read(given: dict[str, Any]) -> Mission | None:
    try:
        return Mission.model_validate(given)
    except (DefinitionError, ValueError):
        return None


def places(given: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Of everything within a document."""
    inner = given.items() if isinstance(given, dict) else enumerate(given) if isinstance(given, list) else ()
    for name, item in inner:
        yield (*place, name)
        yield from places(item, (*place, name))


def at(given: Any, place: tuple[Any, ...]) -> Any:
    for name in place:
        given = given[name]
    return given


@given(missions())
def test_a_mission_does_not_differ_from_itself(mission: Mission) -> None:
    found = difference(mission, mission)
    assert found.empty
    assert found.changes == ()
    assert found.lines() == ("generated: 1.0.0 → 1.0.0: no difference in meaning",)
    assert not any(each.mark for each in (*found.picture.nodes, *found.picture.edges))


@given(mission_documents(), st.data())
def test_whatever_is_taken_away_or_changed_is_found(given: dict[str, Any], data: st.DataObject) -> None:
    """One thing anywhere in the file, as long as both files can be read and do not mean the same to the engine."""
    given = json.loads(json.dumps(given))
    place = data.draw(
        st.sampled_from([place for place in places(given) if place[0] not in ("format", "name", "version")])
    )
    new = copy.deepcopy(given)
    holder, name = at(new, place[:-1]), place[-1]
    value = holder[name]
    if isinstance(value, bool):
        holder[name] = not value
    elif isinstance(value, int | float):
        holder[name] = value + 1
    else:
        del holder[name]
    old, now = read(given), read(new)
    assume(old is not None and now is not None)
    assert old is not None
    assert now is not None
    assume(old != now)
    assert not difference(old, now).empty, place
    assert not difference(now, old).empty, place


def shuffled(value: Any, random: Random, word: str = "") -> Any:
    """The same document with the keys of every object in another order, but for those whose order has a meaning."""
    if isinstance(value, list):
        return [shuffled(item, random) for item in value]
    if not isinstance(value, dict):
        return value
    names = list(value)
    if word not in ("parallel", "options"):
        random.shuffle(names)
    return {name: shuffled(value[name], random, name) for name in names}


@given(mission_documents(), st.randoms(use_true_random=False))
def test_the_order_of_keys_is_no_difference(given: dict[str, Any], random: Random) -> None:
    old, new = (Mission.model_validate(each) for each in (given, shuffled(given, random)))
    assert difference(old, new).changes == ()
    assert old == new


@pytest.mark.parametrize("word", ["parallel", "options"])
def test_another_order_of_regions_or_options_is_a_difference(word: str) -> None:
    """Regions are entered and tried in their order, and a model is shown the options in theirs."""
    wait: dict[str, Any] = {"states": {"idle": {}}}
    of_two = {
        "parallel": {
            "parallel": {"left": {**wait, "initial": "idle"}, "right": {"initial": "rest", "states": {"rest": {}}}}
        },
        "options": {"decision": {"question": "Which?", "options": {"go": {}, "stay": {}}, "fallback": "stay"}},
    }[word]
    given = {"name": "m", "initial": "two", "states": {"two": of_two}}
    new = json.loads(json.dumps(given))
    holder = new["states"]["two"] if word == "parallel" else new["states"]["two"]["decision"]
    holder[word] = dict(reversed(holder[word].items()))
    old, now = Mission.model_validate(given), Mission.model_validate(new)
    assert old != now
    (change,) = difference(old, now).safety
    assert change.sentence.endswith("in another order")


def test_options_that_are_gone_are_listed_in_the_order_in_which_they_were_shown() -> None:
    gone = [f"turn_{number}" for number in range(9)]
    asked = {"question": "Which?", "options": {name: {} for name in ("stay", *gone)}, "fallback": "stay"}
    given: dict[str, Any] = {"name": "m", "initial": "two", "states": {"two": {"decision": asked}}}
    old, new = Mission.model_validate(given), json.loads(json.dumps(given))
    new["states"]["two"]["decision"]["options"] = {"stay": {}}
    sentences = [each.sentence for each in difference(old, Mission.model_validate(new)).changes]
    assert sentences == [f"two: option '{name}' removed" for name in gone]


@given(mission_documents(), st.data())
def test_a_new_name_alone_is_a_new_name_alone(given: dict[str, Any], data: st.DataObject) -> None:
    mission = Mission.model_validate(given)
    name = data.draw(st.sampled_from([name for _, name, _ in mission.walk()]))
    other = Mission.model_validate(json.loads(json.dumps(mission.written()).replace(f'"{name}"', '"renamed"')))
    found = difference(mission, other)
    assert found.renamed == ((name, "renamed"),)
    assert [change.topic for change in found.changes] == ["name"]
    assert found.safety == ()
    assert {node.name: node.was for node in found.picture.nodes if node.was} == {"renamed": name}


def test_new_names_are_listed_in_the_order_of_the_old_mission() -> None:
    def mission(prefix: str) -> Mission:
        states = {f"{prefix}{n}": {"about": f"the {n}th", "final": "aborted"} for n in range(8)}
        return Mission.model_validate({"format": 1, "name": "m", "initial": f"{prefix}0", "states": states})

    assert difference(mission("was"), mission("is")).renamed == tuple((f"was{n}", f"is{n}") for n in range(8))


@given(mission_documents(), st.sampled_from(["count", "battery", "anomaly", "poke"]))
def test_another_name_for_a_key_or_an_event_is_a_rename(given: dict[str, Any], name: str) -> None:
    mission = Mission.model_validate(given)
    text = json.dumps(mission.written())
    other = Mission.model_validate(json.loads(text.replace(f'"{name}"', '"renamed"')))
    found = difference(mission, other)
    assert [(each.old, each.new) for each in found.names] == [(name, "renamed")]
    assert [change.topic for change in found.changes] == ["name"]


@given(missions(), missions())
def test_a_place_is_one_of_the_mission_that_it_is_reported_of(old: Mission, new: Mission) -> None:
    """A pointer of a change leads somewhere, at least to what holds a field that was left out."""
    for change in difference(old, new).changes:
        assert change.old_place is None or leads(old.written(), change.old_place), change
        assert change.new_place is None or leads(new.written(), change.new_place), change
        assert (change.old_place is None) is (change.mark == "+")
        assert (change.new_place is None) is (change.mark == "-")


def leads(document: Any, pointer: str) -> bool:
    steps = pointer.split("/")[1:]
    for number, step in enumerate(steps):
        try:
            document = document[int(step)] if isinstance(document, list) else document[step]
        except (KeyError, IndexError, TypeError):
            return number >= len(steps) - 2  # a field that is left out, or one of what is left out
    return True


@given(missions(), missions())
def test_the_picture_of_two_holds_each_state_and_transition_of_both(old: Mission, new: Mission) -> None:
    found = difference(old, new)
    marks = {node.name: node.mark for node in found.picture.nodes}
    before, after = ({name for _, name, _ in each.walk()} for each in (found.old, found.new))
    assert {name for name, mark in marks.items() if mark == "+"} == after - before
    assert {name for name, mark in marks.items() if mark == "-"} == before - after
    assert marks.keys() == before | after
    arrows = {(edge.source, edge.target) for edge in found.picture.edges}
    was = [("", transition) for transition in found.old.transitions]
    was += [(name, transition) for _, name, state in found.old.walk() for transition in state.transitions]
    assert {(name, target) for name, transition in was for target in transition.to or ("",)} <= arrows
    kept = [edge for edge in found.picture.edges if edge.mark != "-"]
    transitions = [
        *found.new.transitions,
        *(transition for _, _, state in found.new.walk() for transition in state.transitions),
    ]
    assert len(kept) == sum(max(1, len(transition.to)) for transition in transitions)


@given(guards(timed=False), guards(timed=False))
def test_a_weakened_guard_is_true_wherever_it_was(old: Any, new: Any) -> None:
    """And a strengthened one nowhere else; over every blackboard that the guards can distinguish, unknown included."""
    before, after = Guard.read(old), Guard.read(new)
    how = relation(before, after)
    one, other = (each.compile(Site("/", BOARD)) for each in (before, after))
    for here in views():
        if how in ("weakened", "same"):
            assert one(here) is not True or other(here) is True
        if how in ("strengthened", "same"):
            assert other(here) is not True or one(here) is True


@given(guards(timed=False), guards(timed=False), st.sampled_from(["all", "any"]))
def test_one_more_condition_is_never_reported_the_wrong_way_round(old: Any, more: Any, word: str) -> None:
    before, after = Guard.read(old), Guard.read({word: [old, more]})
    assert relation(before, after) in ("same", "strengthened" if word == "all" else "weakened")
    assert relation(after, before) in ("same", "weakened" if word == "all" else "strengthened")


@functools.cache
def views() -> list[Any]:
    obstacles = [
        {"height_m": height, "living": living, "kind": kind}
        for height, living, kind in itertools.product((0.05, 0.1, 0.2, 0.3), (True, False), ("log", "dog"))
    ]
    found = []
    for count, armed, battery, clear, obstacle in itertools.product(
        range(4), (True, False), (None, 0.05, 0.1, 0.3, 0.6), (None, True, False), (None, *obstacles)
    ):
        facts = {
            "count": count, "alleys": 2, "armed": armed, "battery": battery, "clear": clear, "obstacle": obstacle,
        }  # fmt: skip
        board = {key: Stamped(value, 0.0) for key, value in facts.items() if value is not None}
        found.append(SimpleNamespace(at=0.0, board=board, active=frozenset(), entered={}, held={}, event={}, answer={}))
    return found


@pytest.mark.parametrize(
    ("old", "new", "how"),
    [
        (None, {"key": "count", "<": 1}, "strengthened"),
        ({"key": "count", "<": 1}, None, "weakened"),
        ({"key": "count", "<": 1}, {"key": "count", "<=": 1}, "weakened"),
        ({"key": "count", "<": 1}, {"not": {"key": "count", ">=": 1}}, "same"),
        ({"key": "count", ">": 3}, {"key": "count", ">": 2}, "weakened"),
        ({"all": [{"key": "armed", "==": True}, {"in": "a"}]}, {"in": "a"}, "weakened"),
        ({"any": [{"in": "b"}, {"in": "a"}]}, {"any": [{"in": "a"}, {"in": "b"}, {"in": "c"}]}, "weakened"),
        ({"key": "count", "==": 1}, {"key": "count", "==": 2}, "changed"),
        ({"key": "count", "==": 1}, {"key": "count", "==": True}, "changed"),
        ({"key": "w", "in": ["a"]}, {"key": "w", "in": ["a", "b"]}, "weakened"),
        ({"held": {"in": "a"}, "for_s": 2}, {"in": "a"}, "weakened"),
        ({"held": {"in": "a"}, "for_s": 2}, {"held": {"in": "a"}, "for_s": 1}, "weakened"),
        ({"elapsed_s": 2}, {"elapsed_s": 5}, "strengthened"),
        ({"near": ["p", "q"], "within_m": 1}, {"near": ["q", "p"], "within_m": 2}, "weakened"),
        ({"key": "count", "==": 1}, {"not": {"key": "count", "in": [True]}}, "weakened"),
    ],
)
def test_what_became_of_a_guard(old: Any, new: Any, how: str) -> None:
    before, after = (Guard.read(each) if each is not None else None for each in (old, new))
    assert relation(before, after) == how

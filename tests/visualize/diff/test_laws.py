# SPDX-License-Identifier: Apache-2.0
"""Laws of the comparison: it is by meaning, it misses nothing, and what loosens comes first."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rai_missions.blackboard import Stamped
from rai_missions.errors import DefinitionError
from rai_missions.guards.guard import Guard, Site
from rai_missions.mission import Mission
from tests.strategies import KEYS, guards, mission_documents, missions
from tests.visualize.changed import changed
from tests.visualize.runs import document, tractor
from visualize import Difference, difference
from visualize.diff.weaker import relation

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


@given(mission_documents(), st.data())
def test_a_new_name_alone_is_a_new_name_alone(given: dict[str, Any], data: st.DataObject) -> None:
    mission = Mission.model_validate(given)
    name = data.draw(st.sampled_from([name for _, name, _ in mission.walk()]))
    other = Mission.model_validate(json.loads(json.dumps(mission.written()).replace(f'"{name}"', '"renamed"')))
    found = difference(mission, other)
    assert found.renamed == ((name, "renamed"),)
    assert found.changes == ()
    assert {node.name: node.was for node in found.picture.nodes if node.was} == {"renamed": name}


@given(missions(), missions())
def test_the_picture_of_two_holds_each_state_and_row_of_both(old: Mission, new: Mission) -> None:
    found = difference(old, new)
    marks = {node.name: node.mark for node in found.picture.nodes}
    before, after = ({name for _, name, _ in each.walk()} for each in (found.old, found.new))
    assert {name for name, mark in marks.items() if mark == "+"} == after - before
    assert {name for name, mark in marks.items() if mark == "-"} == before - after
    assert marks.keys() == before | after
    arrows = {(edge.source, edge.target) for edge in found.picture.edges}
    was = [("", row) for row in found.old.transitions]
    was += [(name, row) for _, name, state in found.old.walk() for row in state.transitions]
    assert {(name, target) for name, row in was for target in row.to or ("",)} <= arrows
    kept = [edge for edge in found.picture.edges if edge.mark != "-"]
    rows = [*found.new.transitions, *(row for _, _, state in found.new.walk() for row in state.transitions)]
    assert len(kept) == sum(max(1, len(row.to)) for row in rows)


@given(guards(timed=False), guards(timed=False), st.lists(st.tuples(*[st.integers(0, 3)] * 6), min_size=5, max_size=30))
def test_a_weakened_guard_is_true_wherever_it_was(old: Any, new: Any, boards: list[tuple[int, ...]]) -> None:
    """And a strengthened one nowhere else; sampled over many blackboards."""
    before, after = Guard.read(old), Guard.read(new)
    how = relation(before, after)
    one, other = (each.compile(Site("/", BOARD)) for each in (before, after))
    for values in boards:
        here = view(values)
        if how in ("weakened", "same"):
            assert one(here) is not True or other(here) is True
        if how in ("strengthened", "same"):
            assert other(here) is not True or one(here) is True


def view(values: tuple[int, ...]) -> Any:
    count, battery, height, flags, kind, unknown = values
    facts: Mapping[str, Any] = {
        "count": count, "alleys": 2, "battery": (0.05, 0.1, 0.3, 0.6)[battery],
        "armed": bool(flags & 1), "clear": bool(flags & 2),
        "obstacle": {
            "height_m": (0.05, 0.1, 0.2, 0.3)[height], "living": bool(kind & 1), "kind": ("log", "dog")[kind >> 1],
        },
    }  # fmt: skip
    board = {key: Stamped(value, 0.0) for number, (key, value) in enumerate(facts.items()) if number != unknown + 2}
    return SimpleNamespace(at=0.0, board=board, active=frozenset(), entered={}, held={}, event={}, answer={})


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
        ({"held": {"in": "a"}, "for_s": 2}, {"in": "a"}, "changed"),
    ],
)
def test_what_became_of_a_guard(old: Any, new: Any, how: str) -> None:
    before, after = (Guard.read(each) if each is not None else None for each in (old, new))
    assert relation(before, after) == how


def compared(change: Any) -> Difference:
    new = document()
    change(new)
    return difference(tractor(), Mission.model_validate(new))


def drive_over(new: dict[str, Any]) -> dict[str, Any]:
    option: dict[str, Any] = new["states"]["assessing"]["decision"]["options"]["drive_over"]
    return option


def decision(new: dict[str, Any], **words: Any) -> None:
    new["states"]["assessing"]["decision"].update(words)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda new: drive_over(new).pop("when"),
            "- assessing: option 'drive_over': guard removed: obstacle.living is false",
        ),
        (lambda new: decision(new, fallback="replan"), "~ assessing: fallback was 'abort', is now 'replan'"),
        (lambda new: decision(new, deadline_s=60), "~ assessing: 'deadline_s' grew from 20 to 60"),
        (lambda new: decision(new, deadline_s=None), "~ assessing: 'deadline_s' removed, was 20"),
        (
            lambda new: decision(new, ask=["agent"]),
            "~ assessing: asked agent, then operator, then rules; asks agent now",
        ),
        (lambda new: decision(new, tools=["look"]), "~ assessing: tools were nothing, are now look"),
        (lambda new: new["invariants"].clear(), "- invariant 'nobody_is_driven_over' removed"),
        (lambda new: new["states"]["done"].pop("requires"), "- done: requires removed: alleys_driven ≥ alleys"),
        (lambda new: new["states"]["crossing"].pop("achieved"), "- crossing: achieved removed: passed is true"),
        (lambda new: new["states"]["crossing"].pop("timeout_s"), "~ crossing: 'timeout_s' removed, was 30"),
        (
            lambda new: new["states"]["crossing"]["transitions"].pop(0),
            "- crossing: row removed: [obstacle.living is true]",
        ),
        (lambda new: new["states"]["crossing"]["transitions"].reverse(), "~ crossing: rows are tried in another order"),
        (lambda new: new["states"]["crossing"].update(control="autonomy"), "~ crossing: 'control' was “agent”, is now"),
        (lambda new: new["transitions"].clear(), "- mission: row removed: [not in returning and (battery < 0.15"),
        (
            lambda new: new["blackboard"]["obstacle"].update(max_age_s=5),
            "~ key 'obstacle': 'max_age_s' grew from 0.5 to 5",
        ),
        (
            lambda new: new["blackboard"]["obstacle"].update(source="mission"),
            "~ key 'obstacle': no longer the robot's to say",
        ),
        (
            lambda new: new["states"]["signalling"].update(tree={"wait_s": 9}),
            "~ signalling: tree node 'the root' was sequence",
        ),
        (
            lambda new: new["transitions"][0]["when"]["all"][1]["any"].pop(),
            "~ mission: row 'as soon as': guard narrowed: was not in returning",
        ),
        (
            lambda new: new["states"]["assessing"]["transitions"][1].update(to="crossing"),
            "~ assessing: row 'replan': 'to' was replanning, is now crossing",
        ),
    ],
)
def test_what_may_loosen_a_protection_is_told_first(change: Any, told: str) -> None:
    found = compared(change)
    assert any(str(each).startswith(told) for each in found.loosening), found.lines()
    assert "May loosen what protects:" in found.lines()[2]
    assert found.lines()[3].strip().startswith(found.loosening[0].mark)
    assert found.picture.notes[0].startswith("may loosen: ")


@pytest.mark.parametrize(
    "change",
    [
        lambda new: drive_over(new)["when"]["all"].append({"fresh": "camera"}),
        lambda new: decision(new, deadline_s=10),
        lambda new: new["states"]["crossing"].update(timeout_s=3),
        lambda new: new.update(about="otherwise"),
        lambda new: new["invariants"].update(more={"fresh": "battery"}),
        lambda new: new["transitions"].append({"on": "anomaly", "to": "aborted"}),
    ],
)
def test_what_tightens_is_told_but_does_not_alarm(change: Any) -> None:
    found = compared(change)
    assert found.changes
    assert not found.loosening


def test_all_of_a_hasty_change_is_found() -> None:
    found = difference(tractor(), changed())
    assert found.renamed == (("replanning", "next_alley"),)
    assert [change.mark for change in found.changes].count("+") == 3
    assert len(found.loosening) == 7


def test_a_difference_is_a_value() -> None:
    assert difference(tractor(), changed()) == difference(tractor(), changed())

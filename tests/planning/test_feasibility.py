# SPDX-License-Identifier: Apache-2.0
"""What cannot be is refused before anything moves, each with its code and a sentence."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.planning import Goal, Refusal, Workspace, feasible, planned
from rai_missions.planning.feasibility import REASONS, refused_by_rule
from tests.planning.drawn import arrangement, goal_from, names_for, target_goal
from tests.planning.scenes import scene, thing

SEEN = scene(
    thing("a", 0.5, 0.0),
    thing("b", 0.4, 0.1),
    thing("c", 0.6, 0.15),
    thing("d", 0.4, -0.1),
    thing("e", 0.5, 0.3),
    thing("f", 0.6, 0.3),
    thing("g", 0.4, 0.3),
    thing("apple", 0.3, 0.2),
    thing("tomato", 0.3, -0.1),
    thing("tomato_2", 0.3, -0.2),
    thing("corn", 0.5, 0.5),
    thing("tray", 0.55, -0.4),
    thing("bin", 0.28, -0.45),
    thing("x", 0.9, 0.6),
    thing("y", 0.6, 0.9, level=-0.7),
    thing("z", 0.7, 0.0, agreeing=2),
    thing("big_cube", 0.75, -0.2, size=(0.2, 0.2, 0.05)),
    thing("coarse", 0.66, 0.08, sigma_m=0.01),
)
TOWER = [{"on": [upper, lower]} for upper, lower in ("ba", "cb", "dc", "ed", "fe", "gf")]
CASES: list[tuple[str, list[dict[str, Any]], str]] = [
    ("absent", [{"on": ["lemon", "a"]}], "there is no 'lemon' on the desk"),
    ("unclear", [{"on": ["z", "a"]}], "'z' is not seen well enough yet"),
    ("unclear", [{"on": ["coarse", "a"]}], "'coarse' is not seen well enough yet"),
    ("swap", [{"swapped": ["a", "b"]}], "where 'a' and 'b' were first is not known"),
    ("fallen", [{"on": ["y", "a"]}], "'y' lies on the floor"),
    ("no_container", [{"in": ["a", "b"]}], "nothing can be inside 'b'; a tray or a bin holds things"),
    ("no_container", [{"in": ["a", "apple"]}], "nothing can be inside 'apple'; a tray or a bin holds things"),
    ("round", [{"on": ["tomato", "tomato_2"]}], "no tower of tomatoes: they roll"),
    ("round", [{"on": ["a", "apple"]}], "nothing stays on 'apple': it rolls"),
    ("round", [{"on": ["tomato", "a"]}, {"on": ["tomato_2", "tomato"]}], "no tower of tomatoes: they roll"),
    ("no_support", [{"on": ["a", "tray"]}], "nothing is put on 'tray'; things are put in it"),
    ("not_moved", [{"in": ["tray", "bin"]}], "'tray' is not moved: it is a tray"),
    ("not_moved", [{"at": "bin", "x": 0.5, "y": 0.0}], "'bin' is not moved: it is a bin"),
    ("not_moved", [{"on": ["tray", "a"]}], "'tray' is not moved: it is a tray"),
    ("too_big", [{"in": ["big_cube", "bin"]}], "'big_cube' does not fit into 'bin'"),
    ("too_wide", [{"at": "big_cube", "x": 0.5, "y": 0.2}], "'big_cube' is wider than the gripper opens"),
    ("off_desk", [{"at": "a", "x": 2, "y": 0}], "(2, 0) is not on the desk: 'a' would fall"),
    ("off_desk", [{"at": "a", "x": 0.94, "y": 0}], "(0.94, 0) is not on the desk: 'a' would fall"),
    ("out_of_reach", [{"at": "a", "x": 0.9, "y": 0}], "the arm does not reach (0.9, 0)"),
    ("out_of_reach", [{"at": "a", "x": 0.1, "y": 0}], "the arm does not reach (0.1, 0)"),
    ("out_of_reach", [{"at": "a", "x": -0.1, "y": 0.4}], "the arm does not reach (-0.1, 0.4)"),
    ("out_of_reach", [{"at": "x", "x": 0.5, "y": 0.2}], "the arm does not reach 'x'"),
    ("two_places", [{"on": ["a", "b"]}, {"on": ["a", "c"]}], "'a' cannot be at 'b' and at 'c' at once"),
    ("two_places", [{"on": ["a", "desk"]}, {"in": ["a", "tray"]}], "'a' cannot be at 'desk' and at 'tray' at once"),
    (
        "two_places",
        [{"at": "a", "x": 0.5, "y": 0}, {"at": "a", "x": 0.4, "y": 0}],
        "'a' cannot be at (0.5, 0) and at (0.4, 0)",
    ),
    (
        "two_places",
        [{"on": ["a", "b"]}, {"at": "a", "x": 0.5, "y": 0}, {"at": "b", "x": 0.4, "y": 0}],
        "'a' and 'b' are one on the other and at two places",
    ),
    (
        "same_place",
        [{"at": "a", "x": 0.5, "y": 0}, {"at": "b", "x": 0.51, "y": 0}],
        "'a' and 'b' would be in the same place",
    ),
    (
        "contradiction",
        [{"next_to": ["a", "b"]}, {"apart": ["b", "a"]}],
        "'b' and 'a' cannot be close together and apart",
    ),
    ("contradiction", [{"on": ["a", "b"]}, {"apart": ["b", "a"]}], "'b' and 'a' cannot be one on the other and apart"),
    ("contradiction", [{"on": ["a", "b"]}, {"left_of": ["a", "b"]}], "'a' cannot be on 'b' and to a side of it"),
    ("cycle", [{"on": ["a", "b"]}, {"on": ["b", "a"]}], "'a' would be on itself, by way of others"),
    (
        "cycle",
        [{"left_of": ["a", "b"]}, {"left_of": ["b", "c"]}, {"left_of": ["c", "a"]}],
        "'a' would be to the left of itself, by way of others",
    ),
    ("too_many", [{"on": ["a", "c"]}, {"on": ["b", "c"]}], "one thing fits on 'c', not 2"),
    (
        "too_many",
        [{"in": [name, "bin"]} for name in ("corn", "apple", "tomato", "tomato_2", "a", "b", "c", "d", "e")],
        "9 such things do not fit into 'bin'",
    ),
    ("too_high", TOWER, "a stack of more than 6 things would fall"),
    (
        "contradiction",
        [{"left_of": ["a", "b"]}, {"at": "a", "x": 0.5, "y": 0.0}, {"at": "b", "x": 0.5, "y": 0.2}],
        "at the places that are named, this does not hold: left_of a, b",
    ),
    (
        "no_room",
        [{"at": "a", "x": 0.55, "y": -0.45}],
        "there is no arrangement with all of this at once that leaves room for the fingers",
    ),
]


@pytest.mark.parametrize(("code", "predicates", "about"), CASES)
def test_each_refusal_has_its_code_and_sentence(code: str, predicates: list[dict[str, Any]], about: str) -> None:
    assert planned(goal_from(predicates), SEEN) == Refusal(code, about)


def test_every_code_is_met() -> None:
    assert {code for code, _, _ in CASES} == REASONS.keys()


@pytest.mark.parametrize(
    ("code", "predicates", "about"), [case for case in CASES if case[0] not in ("swap", "no_room")]
)
def test_what_cannot_be_cannot_be_with_more_either(code: str, predicates: list[dict[str, Any]], about: str) -> None:
    for more in ({"left_of": ["e", "d"]}, {"on": ["apple", "desk"]}):
        assert isinstance(feasible(goal_from([more, *predicates]), SEEN), Refusal)


def test_a_swap_counts_from_what_is_seen() -> None:
    assert feasible(goal_from([{"swapped": ["a", "b"]}]), SEEN) is None
    assert feasible(goal_from([{"swapped": ["a", "lemon"]}]), SEEN) == Refusal(
        "absent", "there is no 'lemon' on the desk"
    )


def test_a_tower_of_six_is_possible() -> None:
    assert feasible(goal_from(TOWER[:5]), SEEN) is None


def test_a_thing_on_another_may_be_wanted_next_to_one_on_the_desk() -> None:
    stacked = scene(thing("a", 0.5, 0.0), thing("b", 0.5, 0.0, level=0.044))
    wanted = [{"next_to": ["a", "b"]}, {"at": "b", "x": 0.5, "y": 0.1}, {"at": "a", "x": 0.5, "y": 0.0}]
    assert feasible(goal_from(wanted), stacked) is None


def test_reach_and_desk_are_parameters() -> None:
    far = goal_from([{"at": "a", "x": 0.9, "y": 0}])
    assert feasible(far, SEEN, Workspace(tilted_m=1.0)) is None
    refusal = feasible(far, SEEN, Workspace(desk=(0.0, -0.5, 0.8, 0.5)))
    assert refusal is not None
    assert refusal.refused == "off_desk"


@given(st.integers(0, 2**32), st.integers(1, 6))
def test_no_rule_is_against_what_there_is(seed: int, count: int) -> None:
    """Rules refuse only what no arrangement meets; so none of what holds in one."""
    rng = random.Random(seed)
    names = names_for(rng, count)
    goal, other = target_goal(rng, arrangement(rng, names)), arrangement(rng, names)
    assert isinstance(goal, Goal)
    assert refused_by_rule(goal, other, Workspace()) is None

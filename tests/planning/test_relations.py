# SPDX-License-Identifier: Apache-2.0
"""Relations over what is seen: true, false or unknown, and never true where a laxer comparison is not."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.planning import JUDGE, STRICT, Scene, Thing, at_first_poses, holds, reached, support
from rai_missions.planning.geometry import gap
from rai_missions.planning.goal import Predicate
from rai_missions.planning.relations import columns
from rai_missions.planning.tolerances import (
    APART,
    AT,
    BETWEEN,
    CAMERA_SIGMA_M,
    CONTACT,
    FIT,
    GROUPED,
    LEFT_OF,
    LEVEL,
    NEXT_TO,
)
from tests.planning.reading.stored import goal
from tests.planning.scenes import SIZES, scene, thing

CUBE = 0.044


def tower(*names: str, x: float = 0.5, y: float = 0.0, **more: Any) -> list[Thing]:
    return [thing(name, x, y, level=CUBE * place, **more) for place, name in enumerate(names)]


TOWER = goal({"on": ["a", "desk"]}, {"on": ["b", "a"]}, {"on": ["c", "b"]})


def test_a_tower_is_its_contacts_from_the_desk_up() -> None:
    assert reached(TOWER, scene(*tower("a", "b", "c"))) is True
    assert reached(TOWER, scene(*tower("a", "c", "b"))) is False


@pytest.mark.parametrize(("gripper", "truth"), [("empty", True), ("holding", False), ("unknown", None)])
def test_a_tower_is_not_built_while_the_gripper_holds_something(gripper: str, truth: bool | None) -> None:
    assert reached(TOWER, scene(*tower("a", "b", "c"), gripper=gripper)) is truth


@pytest.mark.parametrize("names", [("x", "a", "b", "c"), ("a", "b", "c", "x"), ("a", "x", "b", "c")])
def test_a_foreign_thing_in_the_column_spoils_a_tower(names: tuple[str, ...]) -> None:
    assert reached(TOWER, scene(*tower(*names))) is False
    without_desk = goal({"on": ["b", "a"]}, {"on": ["c", "b"]})
    assert reached(without_desk, scene(*tower(*names))) is False


@pytest.mark.parametrize("above_m", [0.0, 0.006, 0.009, 0.0095, 0.0105, 0.0115, 0.013, 0.05])
def test_what_may_be_in_a_tower_spoils_it_before_what_surely_is(above_m: float) -> None:
    seen = scene(*tower("a", "b", "c"), thing("x", 0.5, 0.0, level=3 * CUBE + above_m))
    by_margin = [reached(TOWER, seen, margin) for margin in (-3.0, STRICT, 0.0, JUDGE, 2.0)]
    assert by_margin == sorted(by_margin, key=bool)
    if above_m == 0.0115:
        assert (reached(TOWER, seen, STRICT), reached(TOWER, seen, JUDGE)) == (False, True)


def test_one_relation_is_no_tower() -> None:
    assert reached(goal({"on": ["b", "a"]}), scene(*tower("x", "a", "b", "y"))) is True


def test_a_tower_may_rest_in_a_tray() -> None:
    in_tray = [thing(name, 0.5, 0.0, level=0.005 + CUBE * place) for place, name in enumerate("abc")]
    seen = scene(thing("tray", 0.5, 0.0), *in_tray)
    assert reached(goal({"on": ["b", "a"]}, {"on": ["c", "b"]}, {"in": ["a", "tray"]}), seen) is True
    assert reached(TOWER, seen) is False


def test_what_moves_or_is_not_seen_is_not_reached() -> None:
    moving = [*tower("a", "b"), thing("c", 0.5, 0, level=2 * CUBE, at_rest=False)]
    assert reached(TOWER, scene(*moving)) is False
    assert reached(TOWER, scene(*tower("a", "b"))) is None
    assert reached(TOWER, scene(*tower("a", "b"), thing("c", 0.5, 0, level=2 * CUBE, agreeing=2))) is None
    assert reached(TOWER, scene(*tower("a", "b"), thing("c", 0.5, 0, level=2 * CUBE, sigma_m=0.02))) is None


def test_left_is_not_the_floor() -> None:
    left = goal({"left_of": ["a", "b"]})
    assert reached(left, scene(thing("a", 0.5, 0.2), thing("b", 0.5, 0.0))) is True
    assert reached(left, scene(thing("a", 0.5, 0.0), thing("b", 0.5, 0.2))) is False
    assert reached(left, scene(thing("a", 0.5, 0.9, level=-0.7), thing("b", 0.5, 0.0))) is False
    assert reached(left, scene(thing("a", 0.5, 0.2, level=0.2), thing("b", 0.5, 0.0))) is False


def test_a_gap_is_measured_between_two_things_side_by_side() -> None:
    wanted = goal({"left_of": ["a", "b"], "gap_m": 0.1})
    assert reached(wanted, scene(thing("a", 0.5, 0.144), thing("b", 0.5, 0.0))) is True
    assert reached(wanted, scene(thing("a", 0.5, 0.1), thing("b", 0.5, 0.0))) is False
    assert reached(wanted, scene(thing("a", 0.7, 0.144), thing("b", 0.5, 0.0))) is False


def turned_right(each: Thing) -> Thing:
    """A thing turned about the middle of the desk, so that what was to its left is ahead."""
    return each.moved(each.y + 0.5, 0.5 - each.x, each.z, each.yaw - math.pi / 2)


@pytest.mark.parametrize(
    ("x", "y", "gap_m", "truth"),
    [
        (0.6, 0.0, None, True), (0.6, 0.3, None, True), (0.5, 0.3, None, False), (0.4, 0.0, None, False),
        (0.5, -0.3, None, False), (0.644, 0.0, 0.1, True), (0.644, 0.2, 0.1, False), (0.55, 0.0, 0.1, False),
    ],
)  # fmt: skip
def test_behind_is_further_from_the_robot(x: float, y: float, gap_m: float | None, truth: bool) -> None:
    wanted = {"behind": ["a", "b"]} if gap_m is None else {"behind": ["a", "b"], "gap_m": gap_m}
    assert reached(goal(wanted), scene(thing("a", x, y), thing("b", 0.5, 0.0))) is truth


@given(st.data())
def test_behind_is_left_of_on_a_desk_that_is_turned(data: st.DataObject) -> None:
    seen = data.draw(seen_things())
    names, gap_m = [each.name for each in seen.things[:2]], data.draw(st.sampled_from([None, 0.0, 0.02, 0.1]))
    turned = scene(*map(turned_right, seen.things))
    free = {} if gap_m is None else {"gap_m": gap_m}
    left, behind = (goal({word: names, **free}).all[0] for word in ("left_of", "behind"))
    assert holds(behind, turned) == holds(left, seen)


@pytest.mark.parametrize(
    ("x", "y", "truth"),
    [(0.5, 0.1, True), (0.515, 0.1, True), (0.55, 0.1, False), (0.5, 0.3, False), (0.5, -0.1, False)],
)
def test_between_is_on_the_line_with_room_on_both_sides(x: float, y: float, truth: bool) -> None:
    seen = scene(thing("a", x, y), thing("b", 0.5, 0.0), thing("c", 0.5, 0.2))
    assert reached(goal({"between": ["a", "b", "c"]}), seen) is truth
    assert reached(goal({"between": ["a", "c", "b"]}), seen) is truth
    assert reached(goal({"between": ["c", "a", "b"]}), seen) is (y == 0.3)


def test_nothing_is_between_two_on_each_other() -> None:
    aside = scene(thing("b", 0.5, 0.0), thing("c", 0.5, 0.2), thing("a", 0.5, 0.022, level=CUBE))
    assert reached(goal({"between": ["a", "b", "c"]}), aside) is False
    seen = scene(*tower("b", "c"), thing("a", 0.5, 0.0, level=2 * CUBE))
    assert reached(goal({"between": ["a", "b", "c"]}), seen) is False


@given(st.floats(0.3, 0.6), st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_a_shift_is_a_place_so_far_from_the_pose_first_seen(x: float, y: float, dx: float, dy: float) -> None:
    shift, seen = goal({"shifted": "a", "dx": dx, "dy": dy}), scene(thing("a", x, y))
    assert reached(shift, seen) is None
    there = at_first_poses(shift, seen)
    assert reached(there, scene(thing("a", x + dx, y + dy))) is True
    if math.hypot(dx, dy) > AT:
        assert reached(there, seen) is False


def test_what_is_shifted_by_nothing_stays_on_what_carries_it() -> None:
    seen = scene(*tower("b", "a"), thing("tray", 0.4, -0.3), thing("apple", 0.4, -0.3, level=0.005))
    stays = [{"shifted": name, "dx": 0.0, "dy": 0.0} for name in ("a", "b", "apple")]
    assert at_first_poses(goal(*stays), seen).written()["all"] == [
        {"at": "a", "x": 0.5, "y": 0.0},
        {"on": ["a", "b"]},
        {"at": "b", "x": 0.5, "y": 0.0},
        {"at": "apple", "x": 0.4, "y": -0.3},
        {"in": ["apple", "tray"]},
    ]


@pytest.mark.parametrize(
    ("apple", "truth"),
    [
        (thing("apple", 0.5, 0.0, level=0.005), True),
        (thing("apple", 0.5, 0.1, level=0.03), False),  # on the rim
        (thing("apple", 0.5, 0.1, level=0.005), False),  # through the wall
        (thing("apple", 0.5, 0.0, level=0.1), False),  # above
        (thing("apple", 0.5, 0.3), False),
    ],
)
def test_inside_is_not_on(apple: Thing, truth: bool) -> None:
    assert reached(goal({"in": ["apple", "tray"]}), scene(thing("tray", 0.5, 0.0), apple)) is truth


def test_next_to_is_side_by_side() -> None:
    wanted = goal({"next_to": ["a", "b"]})
    assert reached(wanted, scene(thing("a", 0.5, 0.0), thing("b", 0.5, 0.09))) is True
    assert reached(wanted, scene(thing("a", 0.5, 0.0), thing("b", 0.5, 0.2))) is False
    assert reached(wanted, scene(*tower("a", "b"))) is False


def test_a_group_is_connected() -> None:
    wanted = goal({"grouped": ["a", "b", "c"]})
    assert reached(wanted, scene(*(thing(name, 0.5, y) for name, y in (("a", 0.0), ("c", 0.2), ("b", 0.1))))) is True
    assert reached(wanted, scene(*(thing(name, 0.5, y) for name, y in (("a", 0.0), ("c", 0.4), ("b", 0.1))))) is False


def test_apart_is_of_every_two() -> None:
    wanted = goal({"apart": ["a", "b", "c"]})
    assert reached(wanted, scene(*(thing(name, 0.5, y) for name, y in (("a", 0.0), ("b", 0.2), ("c", 0.4))))) is True
    assert reached(wanted, scene(*(thing(name, 0.5, y) for name, y in (("a", 0.0), ("b", 0.2), ("c", 0.25))))) is False


def test_a_swap_is_the_poses_first_seen() -> None:
    swap = goal({"swapped": ["a", "b"]})
    seen = scene(thing("a", 0.5, 0.2), thing("b", 0.4, -0.1), thing("c", 0.6, 0.0), thing("d", 0.6, 0, level=CUBE))
    assert reached(swap, seen) is None
    at = at_first_poses(swap, seen)
    assert at.written() == {"all": [{"at": "a", "x": 0.4, "y": -0.1}, {"at": "b", "x": 0.5, "y": 0.2}]}
    assert reached(at, seen) is False
    assert reached(at, scene(thing("b", 0.5, 0.2), thing("a", 0.4, -0.1))) is True
    # the naive swap, one on the other's place while the other is there
    assert reached(at, scene(thing("b", 0.4, -0.1), thing("a", 0.4, -0.1, level=CUBE))) is False
    assert {"on": ["a", "c"]} in at_first_poses(goal({"swapped": ["a", "d"]}), seen).written()["all"]
    assert {"on": ["c", "d"]} in at_first_poses(goal({"swapped": ["c", "d"]}), seen).written()["all"]


def test_what_a_thing_rests_on() -> None:
    seen = scene(
        thing("tray", 0.5, 0.3),
        thing("apple", 0.5, 0.3, level=0.005),
        *tower("a", "b"),
        thing("c", 0.3, 0, level=0.3),
    )
    assert {each.name: support(each.name, seen) for each in seen.things} == {
        "tray": "desk",
        "apple": "tray",
        "a": "desk",
        "b": "a",
        "c": None,
    }


@pytest.mark.parametrize("kind", SIZES)
@pytest.mark.parametrize("other", SIZES)
def test_each_tolerance_is_three_sigmas_of_the_camera(kind: str, other: str) -> None:
    sigma = math.hypot(CAMERA_SIGMA_M[kind], CAMERA_SIGMA_M[other])
    for each in (AT, BETWEEN, LEFT_OF, NEXT_TO, GROUPED, APART, LEVEL, max(CONTACT[kind], CONTACT[other])):
        assert each >= 3 * sigma
    assert FIT[kind] >= 3 * math.hypot(CAMERA_SIGMA_M[kind], CAMERA_SIGMA_M["tray"])
    if kind == "cube" and other == "cube":
        assert 3 * sigma <= CUBE / 2  # a centre above what carries it


@st.composite
def seen_things(draw: st.DrawFn) -> Scene:
    """Things that are often near a relation's limit: on a raster of half a cube, with a little noise."""
    noise = st.floats(-0.03, 0.03)
    found = list[Thing]()
    for name in ("a", "b", "red_apple", "carrot", "tray")[: draw(st.integers(2, 5))]:
        x, y = (0.5 + CUBE / 2 * draw(st.integers(-4, 4)) + draw(noise) for _ in range(2))
        level = draw(st.sampled_from([0.0, 0.006, CUBE, 2 * CUBE, -0.7])) + draw(noise) / 2
        found.append(thing(name, x, y, level=level, yaw=draw(st.floats(-1, 1)), at_rest=draw(st.integers(0, 9)) > 0))
    return scene(*found)


def every_predicate(seen: Scene) -> list[Predicate]:
    names = [each.name for each in seen.things]
    pairs = list(itertools.permutations(names, 2))
    found = [{kind: list(pair)} for pair in pairs for kind in ("on", "in", "left_of", "next_to", "grouped", "apart")]
    found += [{"on": [name, "desk"]} for name in names] + [{"at": name, "x": 0.5, "y": 0.5} for name in names]
    found += [{word: list(pair), "gap_m": 0.02} for pair in pairs for word in ("left_of", "behind")]
    found += [{"behind": list(pair)} for pair in pairs]
    found += [{"between": list(three)} for three in itertools.permutations(names, 3)]
    return [each for at in range(0, len(found), 64) for each in goal(*found[at : at + 64]).all]


@given(seen_things(), st.floats(-3, 3), st.floats(0, 3))
def test_what_holds_strictly_holds_with_a_larger_margin(seen: Scene, margin: float, more: float) -> None:
    for each in every_predicate(seen):
        strict, lax = holds(each, seen, margin), holds(each, seen, margin + more)
        assert (strict is None) == (lax is None)
        assert not (strict and not lax), each
    column = goal({"on": ["a", "desk"]}, {"on": ["b", "a"]})
    assert not (reached(column, seen, STRICT) and not reached(column, seen, JUDGE))


@given(seen_things())
def test_a_distance_is_the_least_between_points_of_the_outlines(seen: Scene) -> None:
    def outline(each: Thing) -> list[tuple[float, float]]:
        core, radius = each.footprint
        edges = zip(core, (*core[1:], core[0]), strict=True)
        points = [(p[0] + s / 60 * (q[0] - p[0]), p[1] + s / 60 * (q[1] - p[1])) for p, q in edges for s in range(60)]
        around = [(math.cos(turn / 9), math.sin(turn / 9)) for turn in range(57)] if radius else [(0.0, 0.0)]
        return [(x + radius * u, y + radius * v) for x, y in points[:: 60 if radius else 1] for u, v in around]

    one, other = seen.things[:2] if len(seen.things) < 4 else seen.things[2:4]
    found = gap(one.footprint, other.footprint)
    least = min(math.dist(p, q) for p in outline(one) for q in outline(other))
    if found >= 0:
        assert least == pytest.approx(found, abs=0.005)
    assert gap(other.footprint, one.footprint) == pytest.approx(found)


def test_columns_are_the_towers_that_are_wanted() -> None:
    assert list(columns(TOWER)) == [("desk", "a", "b", "c")]
    assert list(columns(goal({"on": ["b", "a"]}))) == []
    assert list(columns(goal({"on": ["b", "a"]}, {"on": ["c", "b"]}))) == [("a", "b", "c")]
    assert list(columns(goal({"on": ["b", "a"]}, {"on": ["a", "b"]}))) == []

# SPDX-License-Identifier: Apache-2.0
"""Plans lead where they promise: executed in a world with a geometry of its own, which objects to forbidden moves."""

from __future__ import annotations

import itertools
import math
import random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rai_missions.planning import (
    Plan,
    Refusal,
    Scene,
    at_first_poses,
    avoided_after,
    feasible,
    plan_data,
    planned,
    reached,
)
from rai_missions.planning.candidates import LEAST_M
from rai_missions.planning.feasibility import REASONS
from rai_missions.planning.fingers import can_take
from tests.planning.drawn import KINDS, any_goal, arrangement, goal_from, goal_of_kind, names_for, target_goal
from tests.planning.oracle import Forbidden, World, executed
from tests.planning.scenes import scene, thing

CUBE = 0.044
seeds = st.integers(0, 2**32)
counts = st.integers(1, 6)


@given(seeds, counts)
def test_what_holds_in_one_arrangement_is_reached_from_any_other(seed: int, count: int) -> None:
    rng = random.Random(seed)
    names = names_for(rng, count)
    seen, target = arrangement(rng, names), arrangement(rng, names)
    goal = target_goal(rng, target)
    assert reached(goal, target) is True
    plan = planned(goal, seen)
    assert isinstance(plan, Plan), plan
    executed(plan, goal, seen)


@given(seeds, counts)
def test_a_plan_reaches_its_goal_and_a_refusal_has_a_reason(seed: int, count: int) -> None:
    rng = random.Random(seed)
    names = names_for(rng, count)
    seen = arrangement(rng, names)
    goal = any_goal(rng, names)
    plan = planned(goal, seen)
    assert (feasible(goal, seen) is None) == isinstance(plan, Plan)
    if isinstance(plan, Refusal):
        assert plan.refused in REASONS
        assert plan.about
        assert reached(goal, seen) is not True
    else:
        world = executed(plan, goal, seen)
        assert planned(goal, world.seen()) == Plan()


@given(seeds, counts)
@settings(max_examples=8)
def test_the_same_question_has_the_same_plan(seed: int, count: int) -> None:
    def answer() -> object:
        rng = random.Random(seed)
        names = names_for(rng, count)
        seen = arrangement(rng, names)
        return plan_data(planned(any_goal(rng, names), seen))

    assert answer() == answer()


@given(seeds, counts)
def test_what_holds_already_needs_no_move(seed: int, count: int) -> None:
    rng = random.Random(seed)
    target = arrangement(rng, names_for(rng, count))
    assert planned(target_goal(rng, target), target) == Plan()


@given(seeds, counts)
@settings(max_examples=30)
def test_a_plan_is_the_rest_of_itself_after_each_move(seed: int, count: int) -> None:
    """Where the world follows, planning again after a move does not need more moves than were left."""
    rng = random.Random(seed)
    names = names_for(rng, count)
    seen, goal = arrangement(rng, names), target_goal(rng, arrangement(rng, names))
    plan = planned(goal, seen)
    assert isinstance(plan, Plan)
    world, left = World(seen), len(plan.moves)
    while left:
        again = planned(goal, world.seen())
        assert isinstance(again, Plan)
        assert 0 < len(again.moves) <= left
        assert again.next is not None
        world.make(again.next)
        left -= 1
    assert reached(goal, world.seen()) is True


def scenes_of(kind: str, count: int) -> list[tuple[Scene, bool]]:
    """Seeded scenes of one to nine things, and whether the goal was reached by a plan."""
    found = list[tuple[Scene, bool]]()
    for seed in range(count):
        rng = random.Random(f"{kind} {seed}")
        names = names_for(rng, rng.randint(1, 9))
        seen = arrangement(rng, names, containers=rng.random() < 0.5, stacked=rng.choice([0.0, 0.3]))
        goal = goal_of_kind(rng, kind, names)
        plan = planned(goal, seen)
        found.append((seen, isinstance(plan, Plan) and reached(goal, executed(plan, goal, seen).seen()) is True))
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_goals_of_each_kind_over_one_to_nine_things_are_planned(kind: str) -> None:
    assert all(is_planned for _, is_planned in scenes_of(kind, 6))


@pytest.mark.drill
@pytest.mark.parametrize("kind", KINDS)
def test_many_goals_of_each_kind_are_planned(kind: str) -> None:
    found = [is_planned for _, is_planned in scenes_of(kind, 300)]
    assert sum(found) >= 0.97 * len(found)


# -- examples ----------------------------------------------------------------------------------------------------------


def plan_of(predicates: list[dict[str, object]], *things: object) -> Plan:
    seen, goal = scene(*things), goal_from(predicates)  # type: ignore[arg-type]
    plan = planned(goal, seen)
    assert isinstance(plan, Plan), plan
    executed(plan, goal, seen)
    return plan


def test_a_swap_is_three_moves_by_a_free_place() -> None:
    seen = scene(thing("a", 0.4, 0.1), thing("b", 0.5, -0.1))
    goal = at_first_poses(goal_from([{"swapped": ["a", "b"]}]), seen)
    plan = planned(goal, seen)
    assert isinstance(plan, Plan)
    assert [move.object for move in plan.moves] == ["a", "b", "a"]
    executed(plan, goal, seen)
    assert feasible(goal_from([{"swapped": ["a", "b"]}]), seen) is None


@pytest.mark.parametrize("gap_m", [-0.002, 0.0, 0.002, 0.01, 0.03])
def test_things_that_touch_are_swapped_within_the_tolerance_of_a_place(gap_m: float) -> None:
    """A camera may measure a little less than nothing between them."""
    seen = scene(thing("a", 0.45, 0.0), thing("b", 0.45 + CUBE + gap_m, 0.0))
    goal = at_first_poses(goal_from([{"swapped": ["a", "b"]}]), seen)
    plan = planned(goal, seen)
    assert isinstance(plan, Plan) and len(plan.moves) == 3
    executed(plan, goal, seen)
    (a, b) = (move.place for move in (plan.moves[2], plan.moves[1]))
    assert math.dist(a[:2], b[:2]) > CUBE + LEAST_M - 1e-3


@pytest.mark.parametrize(("other_x", "moves"), [(0.7, 1), (0.554, 2)], ids=["far", "in the way"])
def test_a_place_with_no_other_place_next_to_it_is_met_exactly(other_x: float, moves: int) -> None:
    plan = plan_of([{"at": "a", "x": 0.5, "y": 0.1}], thing("a", 0.4, -0.2), thing("b", other_x, 0.1))
    assert len(plan.moves) == moves and plan.moves[-1].place[:2] == (0.5, 0.1)


def test_the_naive_swap_is_forbidden() -> None:
    seen = scene(thing("a", 0.4, 0.1), thing("b", 0.5, -0.1))
    goal = at_first_poses(goal_from([{"swapped": ["a", "b"]}]), seen)
    plan = planned(goal, seen)
    assert isinstance(plan, Plan)
    with pytest.raises(Forbidden):
        executed(Plan(plan.moves[1:2]), goal, seen)


def test_what_is_on_a_thing_is_taken_off_first() -> None:
    things = [thing(name, 0.5, 0.0, level=CUBE * place) for place, name in enumerate("abx")]
    plan = plan_of([{"on": ["a", "desk"]}, {"on": ["b", "a"]}], *things)
    assert [move.object for move in plan.moves] == ["x"]
    plan = plan_of([{"at": "a", "x": 0.4, "y": 0.3}], *things)
    assert [move.object for move in plan.moves] == ["x", "b", "a"]


def test_a_tower_is_turned_over() -> None:
    things = [thing(name, 0.5, 0.0, level=CUBE * place) for place, name in enumerate("abc")]
    plan = plan_of([{"on": ["c", "desk"]}, {"on": ["b", "c"]}, {"on": ["a", "b"]}], *things)
    assert [(move.object, move.onto) for move in plan.moves] == [("c", "desk"), ("b", "c"), ("a", "b")]


def test_what_is_in_a_named_place_makes_room() -> None:
    plan = plan_of([{"at": "a", "x": 0.5, "y": 0.0}], thing("a", 0.4, 0.3), thing("b", 0.5, 0.01))
    assert [move.object for move in plan.moves] == ["b", "a"]


@pytest.mark.parametrize("yaw", [0.0, 0.4, 2.43])
def test_what_just_fits_into_a_bin_is_packed(yaw: float) -> None:
    things = [thing("carrot", 0.45, 0.1), thing("tomato", 0.5, -0.1), thing("corn", 0.6, 0.25, yaw=1.5)]
    plan = plan_of([{"in": [each.name, "bin"]} for each in things], *things, thing("bin", 0.4, -0.33, yaw=yaw))
    assert [move.object for move in plan.moves] == ["corn", "carrot", "tomato"]


def test_places_that_are_chosen_leave_room_for_the_fingers() -> None:
    crowd = [thing(f"cube_{place}", 0.4 + 0.1 * (place % 3), -0.2 + 0.1 * (place // 3)) for place in range(9)]
    things = [*crowd, thing("x", 0.5, 0.0, level=CUBE)]
    plan = plan_of([{"on": ["x", "desk"]}], *things)
    (move,) = plan.moves
    assert all(math.dist(move.place[:2], (each.x, each.y)) > 0.07 for each in crowd)


def test_a_plan_is_plain_data_that_has_what_it_assumes() -> None:
    data = plan_data(plan_of([{"on": ["b", "a"]}], thing("a", 0.5, 0.0), thing("b", 0.4, 0.2)))
    assert data == {
        "moves": [data["next"]],
        "next": {
            "kind": "pick_and_place",
            "object": "b",
            "pick": {"x": 0.4, "y": 0.2, "z": 0.022, "yaw": 0.0},
            "place": {"x": 0.5, "y": 0.0, "z": 0.066, "yaw": 0.0},
            "onto": "a",
            "spare": data["next"]["spare"],
            "assumes": [
                "b is at rest where it was seen",
                "nothing stands on b",
                "the gripper is empty",
                "a is at rest where it was seen",
                "nothing stands on a",
            ],
            "why": "b is wanted on a",
        },
        "reason": "",
        "about": "",
        "avoided": [],
    }


def test_a_refusal_is_plain_data_of_the_same_fields() -> None:
    found = planned(goal_from([{"on": ["a", "lemon"]}]), scene(thing("a", 0.5, 0.0)))
    assert plan_data(found) == {
        "moves": [],
        "next": None,
        "reason": "absent",
        "about": "there is no 'lemon' on the desk",
        "avoided": [],
    }


@given(seeds, counts)
@settings(max_examples=8)
@example(103, None)
@example(125, None)
def test_a_place_that_was_refused_is_left_for_another_or_named(seed: int, count: int | None) -> None:
    """However often the arm refuses, no place is planned twice, until there is no other."""
    rng = random.Random(seed)
    names = names_for(rng, count or rng.randint(1, 6))
    seen, goal = arrangement(rng, names), goal_of_kind(rng, rng.choice(["next_to", "behind", "tower"]), names)
    last = plan_data(planned(goal, seen))
    for _ in range(4):
        avoided = avoided_after(last)
        plan = planned(goal, seen, avoided=avoided)
        assert isinstance(plan, Plan) and plan == planned(goal, seen, avoided=avoided)
        assert reached(goal, executed(plan, goal, seen).seen()) is True
        if plan.next is None:
            break
        is_refused = any(
            each.object == plan.next.object and math.dist(each.place[:3], plan.next.place[:3]) < 0.02
            for each in avoided
        )
        assert is_refused <= bool(plan.about), "a place that is tried again is named"
        last = plan_data(plan, avoided)


def test_the_places_that_a_plan_avoided_stay_avoided() -> None:
    seen, goal = scene(thing("a", 0.5, 0.0), thing("b", 0.4, 0.2)), goal_from([{"next_to": ["a", "b"]}])
    data, places = plan_data(planned(goal, seen)), []
    for count in range(1, 6):
        avoided = avoided_after(data)
        assert len(avoided) == count
        plan = planned(goal, seen, avoided=avoided)
        assert isinstance(plan, Plan) and plan.next is not None and not plan.about
        places.append(plan.next.place[:2])
        data = plan_data(plan, avoided)
    assert all(math.dist(*pair) >= 0.02 for pair in itertools.combinations(places, 2))


def test_a_place_that_has_no_other_is_tried_again_and_named() -> None:
    seen, goal = scene(thing("a", 0.5, 0.0), thing("b", 0.4, 0.2)), goal_from([{"at": "a", "x": 0.4, "y": 0.0}])
    first = planned(goal, seen)
    assert isinstance(first, Plan) and first.about == ""
    again = planned(goal, seen, avoided=avoided_after(plan_data(first)), language="de")
    assert isinstance(again, Plan) and again.moves == first.moves
    assert again.about == "der Arm hat 'a' an seinem Platz nicht abgesetzt, und es gibt keinen anderen"


@pytest.mark.parametrize("last", [None, 3, [], {}, {"next": None}, {"next": 5, "avoided": [None, {"place": 2}]}])
def test_what_is_no_plan_avoids_nothing(last: object) -> None:
    assert avoided_after(last) == ()


def test_what_makes_room_leaves_its_place() -> None:
    """A cube that leaves the fingers no room is set down clear of where it was, not a millimetre off."""
    cubes = {
        "blue_cube": (0.5976, -0.096, 0.029), "orange_cube": (0.55, -0.2997, 0.221),
        "purple_cube": (0.5194, -0.09, 0.004), "yellow_cube": (0.6079, -0.1521, 0.204),
    }  # fmt: skip
    things = [thing(name, x, y, yaw=yaw, sigma_m=0.00025) for name, (x, y, yaw) in cubes.items()]
    plan = plan_of(
        [{"on": ["orange_cube", "desk"]}, {"on": ["blue_cube", "orange_cube"]}], thing("apple", 0.587, 0.1345), *things
    )
    assert all(math.dist(move.pick[:2], move.place[:2]) >= CUBE for move in plan.moves)


def test_what_leans_on_a_thing_is_taken_away_first() -> None:
    carrot = thing("carrot", 0.43, 0.01, level=0.027, yaw=0.18, sigma_m=0.005)
    plan = plan_of([{"at": "red_cube", "x": 0.5, "y": -0.25}], thing("red_cube", 0.48, 0.0), carrot)
    assert [move.object for move in plan.moves] == ["carrot", "red_cube"]


def test_a_thing_that_lies_next_to_another_leans_on_none() -> None:
    carrot = thing("carrot", 0.38, 0.0, yaw=0.18)
    plan = plan_of([{"at": "red_cube", "x": 0.5, "y": -0.25}], thing("red_cube", 0.48, 0.0), carrot)
    assert [move.object for move in plan.moves] == ["red_cube"]


def test_what_leaves_the_fingers_no_room_moves_first_though_no_one_asked_for_it() -> None:
    around = [thing("blue_cube", 0.4, 0.052), thing("green_cube", 0.452, 0.0)]
    plan = plan_of([{"at": "red_cube", "x": 0.5, "y": -0.25}], thing("red_cube", 0.4, 0.0), *around)
    assert plan.moves[-1].object == "red_cube" and len(plan.moves) == 2


def test_nothing_is_set_down_where_the_palm_meets_what_is_higher() -> None:
    tower = [thing("blue_cube", 0.5, 0.0), thing("green_cube", 0.5, 0.0, level=CUBE)]
    other = [thing("purple_cube", 0.4, -0.13), thing("orange_cube", 0.4, -0.13, level=CUBE)]
    seen = [*tower, *other, thing("red_cube", 0.4, -0.3)]
    (move,) = plan_of([{"next_to": ["red_cube", "blue_cube"]}], *seen).moves
    placed = thing("red_cube", move.place.x, move.place.y, yaw=move.place.yaw)
    assert can_take(placed, [*tower, *other])

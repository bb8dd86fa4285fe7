# SPDX-License-Identifier: Apache-2.0
"""Room for the fingers: the plan's coarse rule never promises what the arm's own would refuse, and orders the moves."""

from __future__ import annotations

import math
import random

from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.planning import Plan, Thing, at_first_poses, planned
from rai_missions.planning.fingers import can_take, crowding
from rai_missions.planning.geometry import gap
from rai_missions.worlds.desk.footprints import SeenThing, overlap, slabs
from rai_missions.worlds.desk.grasps import Grasp, grasps, hand_parts
from tests.planning.drawn import goal_from
from tests.planning.oracle import executed
from tests.planning.scenes import scene, thing

CUBE = 0.044
RADIUS_M = {"cube": 0.0315, "apple": 0.034, "tomato": 0.032}
FINGERS_M = 0.0443
"""A finger on the outside of a cube: 12 mm to open, 26 mm thick, 2 mm free, and a little for yaws."""


def as_seen(each: Thing) -> SeenThing:
    return SeenThing(each.name, each.type, each.x, each.y, each.z, each.yaw, each.size)


def crowd(rng: random.Random) -> list[Thing]:
    """Cubes and balls on a desk without overlap, near each other, some of the cubes towers."""
    found = list[Thing]()
    while len(found) < 5:
        kind = "cube" if len(found) < 2 else rng.choice(("cube", "apple", "tomato"))
        x, y = rng.uniform(0.4, 0.56), rng.uniform(-0.08, 0.08)
        one = thing(f"{kind}_{len(found)}", x, y, yaw=rng.uniform(-3, 3))
        if all(math.dist((x, y), (each.x, each.y)) > RADIUS_M[kind] + RADIUS_M[each.type] for each in found):
            found.append(one)
    tops = [thing(f"top_{each.name}", each.x, each.y, level=CUBE, yaw=each.yaw) for each in found[:2]]
    return [*found, *tops[: rng.randint(0, 2)]]


@given(st.integers(0, 2**32))
@example(1269)
def test_what_a_plan_takes_for_free_the_arm_can_grasp(seed: int) -> None:
    """The arm's own rule is the oracle. It may also reach over a small neighbour with its fingers opened wider."""
    things = crowd(random.Random(seed))
    for one in (each for each in things if each.type == "cube"):
        others = [each for each in things if each is not one]
        around = [as_seen(each) for each in others]
        found = list(grasps(as_seen(one), around))
        if can_take(one, things):
            assert found or _is_close(one, others)
        else:
            assert not any(_is_narrow(each, around) for each in found) or _is_close(one, others)
            assert any(True for _ in crowding(one, things))


def _is_narrow(grasp: Grasp, around: list[SeenThing]) -> bool:
    """Whether the fingers have room there as a plan opens them: 7 mm on each side."""
    parts, obstacles = hand_parts(grasp.pose, CUBE, CUBE + 0.014), slabs(around)
    return not any(overlap(part, each, 0.002) for part in parts for each in obstacles if each.top > part.bottom)


def _is_close(one: Thing, others: list[Thing]) -> bool:
    """Whether the answer turns on less than the camera's noise."""
    return any(can_take(one, [*shifted(others, by)]) != can_take(one, others) for by in (-0.003, 0.003))


def shifted(others: list[Thing], by: float) -> list[Thing]:
    return [each.model_copy(update={"size": (each.size[0] + by, each.size[1] + by, each.size[2])}) for each in others]


def test_a_neighbour_that_leaves_no_room_is_put_aside_first() -> None:
    """Both directions of the fingers are taken: one by what is to come later, one by a thing that stays."""
    things = [thing("a", 0.5, 0.0), thing("stays", 0.5, 0.052), thing("later", 0.552, 0.0), thing("base", 0.4, -0.3)]
    goal = goal_from([{"on": ["a", "base"]}, {"on": ["later", "a"]}])
    plan = planned(goal, scene(*things))
    assert isinstance(plan, Plan)
    assert [move.object for move in plan.moves] == ["later", "a", "later"]
    executed(plan, goal, scene(*things))


def test_what_leans_over_another_is_taken_before_it() -> None:
    """A tower fell: the palm does not fit between what leans and what it leans over."""
    things = [thing("base", 0.46, -0.34), thing("a", 0.46, -0.29, level=0.01), thing("b", 0.46, -0.24, level=0.03)]
    goal = goal_from([{"on": ["base", "desk"]}, {"on": ["a", "base"]}, {"on": ["b", "a"]}])
    plan = planned(goal, scene(*things))
    assert isinstance(plan, Plan) and plan.moves[0].object == "b"


def test_what_is_put_aside_leaves_room_for_the_hand_that_comes_next() -> None:
    things = [
        thing("a", 0.4722, 0.1366, yaw=-0.0511), thing("b", 0.3041, -0.3666, yaw=0.1685),
        thing("apple", 0.436, -0.0054), thing("corn", 0.515, -0.332, yaw=0.2),
    ]  # fmt: skip
    goal = at_first_poses(goal_from([{"swapped": ["a", "b"]}]), scene(*things))
    plan = planned(goal, scene(*things))
    assert isinstance(plan, Plan)
    aside = things[0].moved(*plan.moves[0].place)
    arriving = things[1].moved(*plan.moves[1].place)
    assert gap(aside.footprint, arriving.footprint) > FINGERS_M


def test_what_lies_in_a_tray_is_taken_out_and_what_lies_deep_in_a_bin_is_refused() -> None:
    things = [thing("tray", 0.5, -0.3), thing("bin", 0.5, 0.3), thing("free", 0.4, 0.0)]
    for box, is_planned in (("tray", True), ("bin", False)):
        y = -0.3 if box == "tray" else 0.3
        inside = thing("a", 0.5, y, level=0.005)
        for goal in ({"on": ["a", "desk"]}, {"on": ["a", "free"]}, {"next_to": ["a", "free"]}):
            plan = planned(goal_from([goal]), scene(*things, inside))
            assert isinstance(plan, Plan) == is_planned
            assert not isinstance(plan, Plan) or [move.object for move in plan.moves] == ["a"]
    above = thing("a", 0.5, 0.3, level=0.07)
    full = [thing("b", 0.5, 0.3, level=0.005, size=(0.044, 0.044, 0.065)), above]
    assert isinstance(planned(goal_from([{"on": ["a", "desk"]}]), scene(*things, *full)), Plan), "it is above the rim"

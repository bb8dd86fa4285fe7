# SPDX-License-Identifier: Apache-2.0
"""A second judge, written from what the relations mean, without any code of `rai_missions.planning`.

It reads poses and contacts of the simulation alone. Its tolerances are those that are listed, in metres; a sigma of the
camera is added to each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

from rai_missions.worlds.desk.truth import DeskTruth, TrueThing

__all__ = ("gap_of", "is_met", "unmet")

SIGMA = {"cube": 0.001, "apple": 0.003, "tomato": 0.003, "carrot": 0.005, "corn": 0.005, "tray": 0.002, "bin": 0.002}
REACH_OVER = {"cube": 0.008, "apple": 0.012, "tomato": 0.012, "carrot": 0.018, "corn": 0.018}
AT, LEFT, NEXT, NEAR, APART, LEVEL, WALL = 0.025, 0.022, 0.07, 0.09, 0.12 - 0.03, 0.04, 0.005
HOLDERS, BALLS = ("tray", "bin"), ("apple", "tomato")
CORNERS = 24
"""Corners of the outline of a ball."""
Point = tuple[float, float]


def is_met(goal: Sequence[Mapping[str, Any]], truth: DeskTruth) -> bool:
    """Whether all of a goal is so: each relation, all of its things at rest, and nothing in the gripper.

    Args:
        goal: Predicates over the scene's names.
        truth: Of the world.
    """
    return not [*unmet(goal, truth)]


def unmet(goal: Sequence[Mapping[str, Any]], truth: DeskTruth) -> Iterator[str]:
    """What is not so, as sentences."""
    if truth.held:
        yield f"{truth.held} is held"
    for each in goal:
        (word,) = (name for name in each if name not in ("x", "y", "dx", "dy", "gap_m"))
        names = [each[word]] if isinstance(each[word], str) else list(each[word])
        for name in names:
            if name != "desk" and not truth.things[name].at_rest:
                yield f"{name} moves"
        if not TESTS[word](names, each, truth):
            yield f"not {dict(each)}"


def _sigma(*things: TrueThing) -> float:
    return math.hypot(*(SIGMA[thing.kind] for thing in things))


def _outline(thing: TrueThing, less: float = 0.0) -> list[Point]:
    """The corners of what a thing covers of the desk."""
    long, wide = thing.size[0] / 2 - less, thing.size[1] / 2 - less
    if thing.kind in BALLS:
        turns = [2 * math.pi * number / CORNERS for number in range(CORNERS)]
        return [(thing.x + long * math.cos(turn), thing.y + long * math.sin(turn)) for turn in turns]
    cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
    corners = [(long, wide), (-long, wide), (-long, -wide), (long, -wide)]
    return [(thing.x + cos * u - sin * v, thing.y + sin * u + cos * v) for u, v in corners]


def _sides(corners: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    yield from zip(corners, [*corners[1:], corners[0]], strict=True)


def _beyond(point: Point, corners: Sequence[Point]) -> float:
    """How far a point is outside of a convex outline; below zero where it is inside."""
    found = -math.inf
    for (ax, ay), (bx, by) in _sides(corners):
        long = math.hypot(bx - ax, by - ay)
        found = max(found, ((point[0] - ax) * (by - ay) - (point[1] - ay) * (bx - ax)) / long)
    return found


def _distance(point: Point, one: Point, other: Point) -> float:
    (ax, ay), (bx, by) = one, other
    long = (bx - ax) ** 2 + (by - ay) ** 2
    along = max(0.0, min(1.0, ((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / long))
    return math.dist(point, (ax + along * (bx - ax), ay + along * (by - ay)))


def gap_of(one: TrueThing, other: TrueThing) -> float:
    """Metres between what two things cover of the desk; 0 where they overlap."""
    mine, yours = _outline(one), _outline(other)
    if any(_beyond(point, yours) < 0 for point in mine) or any(_beyond(point, mine) < 0 for point in yours):
        return 0.0
    return min(
        *(_distance(point, *side) for point in mine for side in _sides(yours)),
        *(_distance(point, *side) for point in yours for side in _sides(mine)),
    )


def _bottom(thing: TrueThing) -> float:
    return thing.z - thing.size[2] / 2


def _carried(name: str, truth: DeskTruth, seen: frozenset[str] = frozenset()) -> bool:
    """Whether contacts lead from a thing down to the desk."""
    if truth.touch(name, "desk"):
        return True
    return any(
        (each.kind in HOLDERS or each.z < truth.things[name].z + 0.01) and _carried(other, truth, seen | {name})
        for other, each in truth.things.items()
        if other not in seen | {name} and truth.touch(name, other)
    )


def _on(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    upper, lower = names
    if lower == "desk":
        return truth.touch(upper, "desk")
    one, other = truth.things[upper], truth.things[lower]
    return (
        truth.touch(upper, lower) and one.z > other.z and _beyond((one.x, one.y), _outline(other)) <= _sigma(one, other)
    )


def _at(names: Sequence[str], each: Mapping[str, Any], truth: DeskTruth) -> bool:
    thing = truth.things[names[0]]
    off = math.hypot(thing.x - each["x"], thing.y - each["y"])
    return off <= AT + _sigma(thing) and _carried(names[0], truth)


def _in(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    thing, holder = truth.things[names[0]], truth.things[names[1]]
    hollow = _outline(holder, WALL)
    most = REACH_OVER[thing.kind] + _sigma(thing, holder)
    is_within = all(_beyond(point, hollow) <= most for point in _outline(thing))
    piled = [other for other, each in truth.things.items() if other != names[0] and each.kind not in HOLDERS]
    lies = truth.touch(*names) or any(
        truth.touch(names[0], other) and _in([other, names[1]], {}, truth)
        for other in piled
        if truth.things[other].z < thing.z
    )
    return is_within and lies and not truth.touch(names[0], "desk")


def _left_of(names: Sequence[str], each: Mapping[str, Any], truth: DeskTruth) -> bool:
    return _is_beyond(names, each, truth, axis=1)


def _behind(names: Sequence[str], each: Mapping[str, Any], truth: DeskTruth) -> bool:
    return _is_beyond(names, each, truth, axis=0)


def _between(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    """Whether the first is cut by the line between the other two, near its centre, and neither end is reached."""
    middle, one, other = (truth.things[name] for name in names)
    line = other.x - one.x, other.y - one.y
    length = math.hypot(*line)
    along = [(each.x - one.x) * line[0] / length + (each.y - one.y) * line[1] / length for each in (middle, other)]
    off = abs((middle.x - one.x) * line[1] - (middle.y - one.y) * line[0]) / length
    most = LEFT + _sigma(middle, one, other)
    is_amid = 0 < along[0] < along[1] and gap_of(middle, one) > 0 and gap_of(middle, other) > 0
    return is_amid and off <= most and all(_carried(name, truth) for name in names)


def _is_beyond(names: Sequence[str], each: Mapping[str, Any], truth: DeskTruth, axis: int) -> bool:
    left, right = (truth.things[name] for name in names)
    free = min(point[axis] for point in _outline(left)) - max(point[axis] for point in _outline(right))
    most = LEFT + _sigma(left, right)
    wanted = each.get("gap_m")
    is_placed = -free <= most if wanted is None else abs(free - wanted) <= most
    return is_placed and all(_carried(name, truth) for name in names)


def _next_to(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    one, other = (truth.things[name] for name in names)
    is_level = abs(_bottom(one) - _bottom(other)) <= LEVEL + _sigma(one, other)
    is_near = gap_of(one, other) <= NEXT + _sigma(one, other)
    return is_level and is_near and all(_carried(name, truth) for name in names)


def _grouped(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    found, waiting = {names[0]}, set(names[1:])
    while waiting:
        near = {name for name in waiting for other in found if _are_near(truth.things[name], truth.things[other])}
        if not near:
            return False
        found, waiting = found | near, waiting - near
    return all(_carried(name, truth) for name in names)


def _are_near(one: TrueThing, other: TrueThing) -> bool:
    return gap_of(one, other) <= NEAR + _sigma(one, other)


def _apart(names: Sequence[str], _: Mapping[str, Any], truth: DeskTruth) -> bool:
    things = [truth.things[name] for name in names]
    far = all(gap_of(one, other) >= APART - _sigma(one, other) for one, other in combinations(things, 2))
    return far and all(_carried(name, truth) for name in names)


TESTS = {
    "on": _on, "at": _at, "in": _in, "left_of": _left_of, "behind": _behind, "between": _between, "next_to": _next_to,
    "grouped": _grouped, "apart": _apart,
}  # fmt: skip

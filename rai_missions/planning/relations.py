# SPDX-License-Identifier: Apache-2.0
"""Whether what is wanted holds over what is seen: true, false, or unknown.

Rule: each comparison is `deviation <= tolerance + margin * sigma`. So what holds strictly holds with any larger margin;
a condition that must not hold is compared with the opposite margin.
Rule: unknown is never taken for true: a thing that is not seen, too few looks that agree, a measurement too coarse for
the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import Any

from rai_missions.planning.geometry import gap, overhang, past_an_end, turned
from rai_missions.planning.goal import (
    FIRST_SEEN,
    Apart,
    AtPlace,
    Behind,
    Between,
    Beyond,
    Goal,
    Grouped,
    InContainer,
    LeftOf,
    NextTo,
    OnTop,
    Predicate,
    Shifted,
    Swapped,
)
from rai_missions.planning.scene import CONTAINERS, DESK, Scene, Thing
from rai_missions.planning.tolerances import (
    APART,
    APART_M,
    AT,
    BETWEEN,
    GROUPED,
    LEFT_OF,
    LEVEL,
    NEXT_TO,
    STRICT,
    WALL_M,
    contact,
    fit,
)

__all__ = (
    "Truth", "are_linked", "at_first_poses", "columns", "covers", "downward", "holds", "inner", "reached",
    "rests_on", "support",
)  # fmt: skip

Truth = bool | None
"""True, false, or None: unknown."""


def reached(goal: Goal, scene: Scene, margin: float = STRICT) -> Truth:
    """Whether all of a goal holds: every predicate, no foreign thing in a tower, all at rest, nothing in the gripper.

    Args:
        goal: What is wanted; what is about the poses first seen, and was not rewritten, is unknown.
        scene: What is seen.
        margin: Standard deviations that are added to each tolerance: `STRICT` for a guard, `JUDGE` for a judge.
    """
    found = [holds(each, scene, margin) for each in goal.all]
    found.append({"empty": True, "holding": False, "unknown": None}[scene.gripper])
    found.extend(_is_pure(column, scene, margin) for column in columns(goal))
    return _all(found)


def holds(predicate: Predicate, scene: Scene, margin: float = STRICT) -> Truth:
    """Whether one predicate holds, with every thing in it at rest; what the gripper holds does not count.

    Args:
        predicate: What is wanted.
        scene: What is seen.
        margin: Standard deviations that are added to each tolerance.
    """
    things = {name: scene.get(name) for name in predicate.things() if name != DESK}
    if any(thing is None or not thing.is_certain for thing in things.values()):
        return None
    seen = [thing for thing in things.values() if thing is not None]
    if not all(thing.at_rest for thing in seen):
        return False
    if isinstance(predicate, FIRST_SEEN) or any(3 * thing.sigma_m > contact(thing) for thing in seen):
        return None
    test = TESTS[type(predicate)]
    return test(predicate, scene, margin)


def _all(found: Iterable[Truth]) -> Truth:
    """False where any is false, else unknown where any is."""
    values = list(found)
    return False if False in values else None if None in values else True


# -- what carries a thing ----------------------------------------------------------------------------------------------


def support(name: str, scene: Scene, margin: float = 0.0) -> str | None:
    """What a thing rests on or in: a thing, `desk`, or None where nothing is below it (held, on the floor).

    Raises:
        UsageError: It is not seen.
    """
    thing = scene.thing(name)
    others = [other for other in scene.things if other.name != name]
    for other in sorted(others, key=lambda each: (-each.top, each.name)):
        if other.type not in CONTAINERS and rests_on(thing, other, margin):
            return other.name
    for other in others:
        if other.type in CONTAINERS and thing.type not in CONTAINERS and rests_in(thing, other, margin):
            return other.name
    return DESK if _on_desk(thing, scene, margin) else None


def rests_on(upper: Thing, lower: Thing, margin: float) -> bool:
    """Whether one thing is in contact with the top of another, its centre above it."""
    sigma = math.hypot(upper.sigma_m, lower.sigma_m)
    if abs(upper.bottom - lower.top) > contact(upper, lower) + margin * sigma:
        return False
    return covers(lower, upper, margin * sigma)


def covers(lower: Thing, upper: Thing, beyond_m: float = 0.0) -> bool:
    """Whether the centre of one thing is above the outline of another, or at most so many metres beyond it."""
    across = turned((upper.x - lower.x, upper.y - lower.y), -lower.yaw)
    return all(abs(off) <= size / 2 + beyond_m for off, size in zip(across, lower.size[:2], strict=True))


def rests_in(thing: Thing, container: Thing, margin: float) -> bool:
    """Whether the whole footprint of a thing is inside a container, and it reaches down into it.

    What lies across the rim is on the container, not in it.
    """
    sigma = math.hypot(thing.sigma_m, container.sigma_m)
    if overhang(thing.footprint, inner(container).footprint) > fit(thing) + margin * sigma:
        return False
    floor = container.bottom + WALL_M
    depth = max(contact(thing, container), container.size[2] / 2)
    return -contact(thing, container) - margin * sigma <= thing.bottom - floor <= depth + margin * sigma


def inner(container: Thing) -> Thing:
    """The hollow of a container, without its walls."""
    width, length, height = container.size
    return container.model_copy(update={"size": (width - 2 * WALL_M, length - 2 * WALL_M, height)})


def _on_desk(thing: Thing, scene: Scene, margin: float) -> bool:
    if abs(thing.bottom) > contact(thing) + margin * thing.sigma_m:
        return False
    return not any(
        covers(other, thing) for other in scene.things if other.type in CONTAINERS and other.name != thing.name
    )


def _are_carried(things: Iterable[Thing], scene: Scene, margin: float) -> bool:
    """Whether things rest on the desk, or on or in anything on it: not in the air, and not on the floor."""
    return all(support(thing.name, scene, margin) is not None for thing in things)


def downward(name: str | None, below: Mapping[str, str | None]) -> Iterator[str]:
    """A thing, what carries it, and so on down, the desk not counted; it ends where a circle closes."""
    found = set[str]()
    while name is not None and name != DESK and name not in found:
        found.add(name)
        yield name
        name = below.get(name)


def are_linked(things: Sequence[Thing], is_near: Callable[[Thing, Thing], bool]) -> bool:
    """Whether a way leads from each thing to every other, always on to one that is near."""
    linked, waiting = [*things[:1]], [*things[1:]]
    for thing in linked:  # it grows meanwhile
        found = [each for each in waiting if is_near(each, thing)]
        linked += found
        waiting = [each for each in waiting if each not in found]
    return not waiting


# -- one test a kind of predicate --------------------------------------------------------------------------------------


def _on(predicate: OnTop, scene: Scene, margin: float) -> bool:
    upper = scene.thing(predicate.on[0])
    if predicate.on[1] == DESK:
        return _on_desk(upper, scene, margin)
    return rests_on(upper, scene.thing(predicate.on[1]), margin)


def _at(predicate: AtPlace, scene: Scene, margin: float) -> bool:
    thing = scene.thing(predicate.at)
    off = math.dist((thing.x, thing.y), (predicate.x, predicate.y))
    return off <= AT + margin * thing.sigma_m and _are_carried([thing], scene, margin)


def _in(predicate: InContainer, scene: Scene, margin: float) -> bool:
    thing, container = (scene.thing(name) for name in predicate.in_)
    return container.type in CONTAINERS and _is_inside(thing, container, scene, margin)


def _is_inside(thing: Thing, container: Thing, scene: Scene, margin: float) -> bool:
    """Whether a thing rests in a container, or on another that does, its whole footprint inside."""
    if rests_in(thing, container, margin):
        return True
    sigma = math.hypot(thing.sigma_m, container.sigma_m)
    return overhang(thing.footprint, inner(container).footprint) <= fit(thing) + margin * sigma and any(
        lower.bottom < thing.bottom and rests_on(thing, lower, margin) and _is_inside(lower, container, scene, margin)
        for lower in scene.things
        if lower.type not in CONTAINERS
    )


def _beyond(predicate: Beyond, scene: Scene, margin: float) -> bool:
    further, other = (scene.thing(name) for name in predicate.pair)
    tolerance = LEFT_OF + margin * math.hypot(further.sigma_m, other.sigma_m)
    free = further.footprint.extent(predicate.axis)[0] - other.footprint.extent(predicate.axis)[1]
    carried = _are_carried((further, other), scene, margin)
    if predicate.gap_m is None:
        return carried and -free <= tolerance
    one, two = (thing.footprint.extent(1 - predicate.axis) for thing in (further, other))
    past = max(one[0] - two[1], two[0] - one[1])
    return carried and abs(free - predicate.gap_m) <= tolerance and past <= tolerance


def _between(predicate: Between, scene: Scene, margin: float) -> bool:
    middle, *ends = things = [scene.thing(name) for name in predicate.between]
    tolerance = BETWEEN + margin * max(math.hypot(middle.sigma_m, end.sigma_m) for end in ends)
    past = past_an_end(*(thing.footprint for thing in things))
    return past <= tolerance and _are_carried(things, scene, margin)


def _next_to(predicate: NextTo, scene: Scene, margin: float) -> bool:
    one, other = (scene.thing(name) for name in predicate.next_to)
    sigma = math.hypot(one.sigma_m, other.sigma_m)
    return (
        gap(one.footprint, other.footprint) <= NEXT_TO + margin * sigma
        and abs(one.bottom - other.bottom) <= LEVEL + margin * sigma
        and _are_carried((one, other), scene, margin)
    )


def _grouped(predicate: Grouped, scene: Scene, margin: float) -> bool:
    things = [scene.thing(name) for name in predicate.grouped]
    return are_linked(things, partial(_are_near, margin=margin)) and _are_carried(things, scene, margin)


def _are_near(one: Thing, other: Thing, margin: float) -> bool:
    return gap(one.footprint, other.footprint) <= GROUPED + margin * math.hypot(one.sigma_m, other.sigma_m)


def _apart(predicate: Apart, scene: Scene, margin: float) -> bool:
    things = [scene.thing(name) for name in predicate.apart]
    return all(
        APART_M - gap(one.footprint, other.footprint) <= APART + margin * math.hypot(one.sigma_m, other.sigma_m)
        for other, one in combinations(things, 2)
    ) and _are_carried(things, scene, margin)


TESTS: Mapping[type[Predicate], Callable[[Any, Scene, float], bool]] = {
    OnTop: _on,
    AtPlace: _at,
    InContainer: _in,
    LeftOf: _beyond,
    Behind: _beyond,
    Between: _between,
    NextTo: _next_to,
    Grouped: _grouped,
    Apart: _apart,
}
"""Kind of predicate → how it is compared, where every thing of it is seen, certain and at rest."""


# -- towers and swaps --------------------------------------------------------------------------------------------------


def columns(goal: Goal) -> Iterator[tuple[str, ...]]:
    """The towers that a goal wants, each from below: `desk` first where the goal has it, then two things or more.

    A single relation between two things, without the desk, is no tower: what else is there does not matter.
    """
    above: dict[str, list[str]] = {}
    pairs = [each.on for each in goal.of_kind(OnTop)]
    for upper, lower in pairs:
        above.setdefault(lower, []).append(upper)
    lowest = [
        (name,)
        for lower, name in ((lower, lower) for _, lower in pairs)
        if lower != DESK and not any(upper == lower for upper, _ in pairs)
    ]
    starts = [*dict.fromkeys(lowest), *((DESK, upper) for upper, lower in pairs if lower == DESK)]
    for start in starts:
        column = start
        while (found := above.get(column[-1], [])) and found[0] not in column:
            column = (*column, found[0])
        if len(column) >= 3:
            yield column


def _is_pure(column: tuple[str, ...], scene: Scene, margin: float) -> Truth:
    """Whether no foreign thing is in a tower: none on its top, and nothing but desk, tray or bin below it."""
    things = [scene.get(name) for name in column if name != DESK]
    if any(thing is None for thing in things):
        return None
    members = [thing for thing in things if thing is not None]
    base, foreign = members[0], [thing for thing in scene.things if thing.name not in column]
    containers = [thing for thing in foreign if thing.type in CONTAINERS]
    if not (_on_desk(base, scene, margin) or any(rests_in(base, each, margin) for each in containers)):
        return False
    return not any(
        rests_on(thing, member, -margin) or (member is base and rests_on(base, thing, -margin))
        for member in members
        for thing in foreign
        if thing not in containers
    )


def at_first_poses(goal: Goal, scene: Scene) -> Goal:
    """The goal with what is about the poses first seen as places, counted from the poses that things have now.

    Of a swap each comes on or in what carries the other; what is shifted by nothing stays on or in what carries it.

    Raises:
        UsageError: A thing of a swap or a shift is not seen, or nothing carries it.
    """
    found: list[Predicate] = []
    for each in goal.all:
        if isinstance(each, Swapped):
            found.extend(_exchanged(*each.swapped, scene))
        elif isinstance(each, Shifted):
            found.extend(_shifted(each, scene))
        else:
            found.append(each)
    return Goal(all=tuple(dict.fromkeys(found)))


def _exchanged(one: str, other: str, scene: Scene) -> Iterator[Predicate]:
    for name, place in ((one, other), (other, one)):
        yield _at_pose_of(place, scene, name)
        yield from _carried_as(place, scene, name)


def _shifted(each: Shifted, scene: Scene) -> Iterator[Predicate]:
    yield _at_pose_of(each.shifted, scene, each.shifted, each.dx, each.dy)
    if not (each.dx or each.dy):
        yield from _carried_as(each.shifted, scene, each.shifted)


def _at_pose_of(place: str, scene: Scene, name: str, dx: float = 0.0, dy: float = 0.0) -> AtPlace:
    there = scene.thing(place)
    return AtPlace(at=name, x=round(there.x + dx, 4), y=round(there.y + dy, 4))


def _carried_as(place: str, scene: Scene, name: str) -> Iterator[Predicate]:
    """One thing on or in what carries another now; nothing where that is the desk."""
    below = support(place, scene)
    if below is None or below == DESK:
        return
    carrier = place if below == name else below
    kind = InContainer if scene.thing(below).type in CONTAINERS else OnTop
    yield kind((name, carrier))

# SPDX-License-Identifier: Apache-2.0
"""A tiny world of boxes and discs that executes a plan move by move and objects to what an arm must not do.

It has a geometry of its own, of corners alone, so that a fault in that of the planner shows.
"""

from __future__ import annotations

import math
from typing import Any

from rai_missions.planning import Goal, Plan, PlannedMove, Scene, Thing, reached

__all__ = ("Forbidden", "World", "executed", "inside", "overlap")

EXACT_M = 2e-4
"""Poses of a plan are rounded."""
Corners = list[tuple[float, float]]


class Forbidden(AssertionError):
    """A move that must not be made."""


def corners(thing: Thing, grown: float = 0.0) -> Corners:
    """The outline from above; of a ball sixteen points on it."""
    if thing.type in ("apple", "tomato"):
        radius = thing.size[0] / 2 + grown
        return [
            (thing.x + radius * math.cos(k * math.pi / 8), thing.y + radius * math.sin(k * math.pi / 8))
            for k in range(16)
        ]
    cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
    half = [
        (sx * (thing.size[0] / 2 + grown), sy * (thing.size[1] / 2 + grown))
        for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    return [(thing.x + u * cos - v * sin, thing.y + u * sin + v * cos) for u, v in half]


def overlap(one: Corners, other: Corners) -> bool:
    """Whether two outlines share an area: no line separates them."""
    for shape in (one, other):
        for start, end in zip(shape, shape[1:] + shape[:1], strict=True):
            across = (end[1] - start[1], start[0] - end[0])
            first = [x * across[0] + y * across[1] for x, y in one]
            second = [x * across[0] + y * across[1] for x, y in other]
            if max(first) <= min(second) + 1e-12 or max(second) <= min(first) + 1e-12:
                return False
    return True


def inside(point: tuple[float, float], thing: Thing, wall: float = 0.0) -> bool:
    """Whether a point is within a box, seen from above."""
    cos, sin = math.cos(thing.yaw), math.sin(thing.yaw)
    dx, dy = point[0] - thing.x, point[1] - thing.y
    off = (abs(dx * cos + dy * sin), abs(dy * cos - dx * sin))
    return all(each <= size / 2 - wall for each, size in zip(off, thing.size[:2], strict=True))


class World:
    """Things where they are, and what each rests on; `make` moves one, or raises `Forbidden`."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.things: dict[str, Thing] = {each.name: each for each in scene.things}

    def on_top_of(self, name: str) -> list[str]:
        """What rests on a thing."""
        lower = self.things[name]
        return [
            each.name
            for each in self.things.values()
            if each.name != name
            and abs(each.bottom - lower.top) < 0.01
            and inside((each.x, each.y), lower)
            and lower.type not in ("tray", "bin")
        ]

    def below(self, thing: Thing) -> set[str]:
        """All that is under a thing, down to the desk."""
        found = set[str]()
        for each in self.things.values():
            if each.name != thing.name and inside((thing.x, thing.y), each) and each.bottom < thing.bottom + 1e-6:
                found.add(each.name)
        return found

    def make(self, move: PlannedMove) -> None:
        """One move, held to what is forbidden."""
        thing = self.things[move.object]
        if math.dist(move.pick[:3], (thing.x, thing.y, thing.z)) > EXACT_M:
            raise Forbidden(f"{move.object} is not where it is to be picked")
        if self.on_top_of(move.object):
            raise Forbidden(f"{self.on_top_of(move.object)} would lose what carries it")
        if thing.type in ("tray", "bin"):
            raise Forbidden(f"{move.object} is not moved")
        placed = thing.moved(*move.place)
        self._hold_carrier(placed, move.onto)
        del self.things[move.object]
        carriers = self.below(placed) if move.onto != "desk" else set()
        for other in self.things.values():
            if other.name not in carriers and overlap(corners(placed), corners(other)):
                raise Forbidden(f"{move.object} would be set down into {other.name}")
        self.things[move.object] = placed

    def _hold_carrier(self, placed: Thing, onto: str) -> None:
        if not 0.27 <= math.hypot(placed.x, placed.y) <= 0.85:
            raise Forbidden(f"{placed.name} would be out of reach")
        if onto == "desk":
            level, is_there = 0.0, all(-0.2 <= x <= 0.95 and -0.75 <= y <= 0.75 for x, y in corners(placed))
        else:
            carrier = self.things[onto]
            if carrier.type in ("tray", "bin"):
                level = carrier.bottom + 0.005
                is_there = all(inside(each, carrier, 0.005) for each in corners(placed))
            else:
                if carrier.type != "cube":
                    raise Forbidden(f"{placed.name} would be on {onto}, which rolls")
                if [each for each in self.on_top_of(onto) if each != placed.name]:
                    raise Forbidden(f"{onto} is occupied")
                level, is_there = carrier.top, math.dist((carrier.x, carrier.y), (placed.x, placed.y)) < 0.002
        if not is_there or abs(placed.bottom - level) > EXACT_M:
            raise Forbidden(f"{placed.name} would not rest on {onto}")

    def seen(self) -> Scene:
        """The scene as it is now, the gripper empty."""
        things = tuple(self.things[each.name].model_copy(update={"at_rest": True}) for each in self.scene.things)
        return self.scene.model_copy(update={"things": things, "gripper": "empty"})

    def holds(self, predicate: dict[str, Any]) -> bool:
        """`on`, `at` and `in`, measured here; the others are taken as true."""
        if "at" in predicate:
            thing = self.things[predicate["at"]]
            return math.dist((thing.x, thing.y), (predicate["x"], predicate["y"])) < 0.026
        if "in" in predicate:
            thing, holder = (self.things[name] for name in predicate["in"])
            return all(inside(each, holder) for each in corners(thing)) and thing.bottom < holder.top + 0.2
        if "on" in predicate and predicate["on"][1] != "desk":
            return predicate["on"][0] in self.on_top_of(predicate["on"][1])
        return True


def executed(plan: Plan, goal: Goal, scene: Scene) -> World:
    """The world after all moves, in which the goal holds.

    Raises:
        Forbidden: A move must not be made, or the goal does not hold in the end.
    """
    world = World(scene)
    for move in plan.moves:
        world.make(move)
    if not all(world.holds(each) for each in goal.written()["all"]) or reached(goal, world.seen()) is not True:
        raise Forbidden(f"the goal does not hold after {len(plan.moves)} moves")
    return world

# SPDX-License-Identifier: Apache-2.0
"""Where each thing ends: places for those that move, such that the whole goal holds and the fingers have room.

A search with backtracking over candidates in a fixed order: the same question has the same answer.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from functools import partial
from itertools import combinations

from rai_missions.planning.candidates import (
    LEAST_M,
    SLACK_M,
    about_a_place,
    aligned,
    amid,
    around,
    at_an_end,
    from_a_corner,
    from_the_middle,
    packed,
    to_a_side,
)
from rai_missions.planning.feasibility import FLOOR_M, column_of
from rai_missions.planning.fingers import PALM_UP_M, can_take
from rai_missions.planning.geometry import Point, gap, overhang, past_an_end
from rai_missions.planning.goal import (
    Apart,
    AtPlace,
    Between,
    Beyond,
    Goal,
    Grouped,
    InContainer,
    LeftOf,
    NextTo,
    OnTop,
    Predicate,
)
from rai_missions.planning.plan import AvoidedPlace, is_avoided
from rai_missions.planning.relations import are_linked, columns, downward, holds, inner, reached
from rai_missions.planning.scene import CONTAINERS, DESK, Scene, Thing
from rai_missions.planning.tolerances import APART, APART_M, GROUPED, NEXT_TO, WALL_M
from rai_missions.planning.workspace import Workspace

__all__ = ("Arrangement", "Placement", "is_in_the_way")

SPARE_M = 0.02
"""By how much things are nearer to each other than a relation would allow, for an arm that is not exact."""
PALM_REACH_M = 0.16
"""Metres between the middles of two things beyond which the palm of the one's hand does not meet the other."""
ABOVE_M = 0.005
"""How far the fingers reach below the underside of what they set down, metres."""

Arrangement = dict[str, Thing]
"""Name → the thing where it is."""


def is_in_the_way(thing: Thing, other: Thing, clearance: float) -> bool:
    """Whether one thing cannot be set down because of another next to it.

    Args:
        thing: Where it is to be.
        other: Where it is.
        clearance: Metres that the fingers need where the other is as high as they come down.
    """
    return _is_near(thing, other, clearance if other.top > thing.bottom + ABOVE_M else LEAST_M)


def _is_near(one: Thing, other: Thing, limit: float) -> bool:
    """Whether two footprints are less than some metres from each other."""
    farthest = (math.hypot(*one.size[:2]) + math.hypot(*other.size[:2])) / 2 + limit
    if math.dist((one.x, one.y), (other.x, other.y)) > farthest:
        return False
    return gap(one.footprint, other.footprint) < limit


class Placement:
    """One search: the final places of things that move, all others where they are.

    Args:
        goal: What is wanted.
        scene: What is seen, everything at rest.
        workspace: Where the arm works.
        below: Name → what each thing rests on or in now; None for nothing.
        movers: The things that may move, with all that rests on them.
        clearance: Metres between things that are set down and others.
        budget: Places that are tried, all things together, before it is given up.
        lined_up: Things that are left of others are placed from the right, each as far right as possible.
        leaving: Of the movers, those that may not stay where they are, nor cover any of it.
        avoided: Places at which the arm did not set things down; none of these is chosen.
    """

    def __init__(
        self,
        goal: Goal,
        scene: Scene,
        workspace: Workspace,
        *,
        below: dict[str, str | None],
        movers: Sequence[str],
        clearance: float,
        budget: int,
        lined_up: bool = False,
        leaving: Collection[str] = (),
        avoided: Collection[AvoidedPlace] = (),
    ) -> None:
        self.goal, self.scene, self.workspace, self.clearance = goal, scene, workspace, clearance
        self.present = scene.by_name
        self.wanted: dict[str, str] = {
            each.things()[0]: each.things()[1] for each in (*goal.of_kind(InContainer), *goal.of_kind(OnTop))
        }
        self.final: Arrangement = {
            each.name: each for each in scene.things if each.name not in movers and each.bottom >= FLOOR_M
        }
        self.below: dict[str, str | None] = {name: below[name] for name in self.final}
        self._below_now, self._lined_up, self._leaving, self.avoided = below, lined_up, leaving, avoided
        self._lines: dict[tuple[str, int], tuple[str, ...]] = {}
        self.blockers: dict[str, None] = {}
        """Things that do not move and were in the way of a place that was named."""
        self.bases = {column[1] if column[0] == DESK else column[0] for column in columns(goal)}
        self.order = self._ordered(movers)
        self.left = budget
        self._holds_now = {each: holds(each, scene) is True for each in goal.all}

    def found(self) -> bool:
        """Whether there are places; they are in `final` and `below` then."""
        return all(self._may_hold(each) for each in self.goal.all) and self._placed(0)

    def _placed(self, index: int) -> bool:
        if index == len(self.order):
            things = tuple(self.final.get(each.name, each) for each in self.scene.things)
            return reached(self.goal, self.scene.model_copy(update={"things": things})) is True
        name = self.order[index]
        for thing, below in self._candidates(name):
            self.left -= 1
            if self.left < 0:
                return False
            if not self._is_free(thing, below):
                continue
            self.final[name], self.below[name] = thing, below
            if self._fits(name) and self._placed(index + 1):
                return True
            del self.final[name], self.below[name]
        return False

    # -- the order in which places are looked for ----------------------------------------------------------------------

    def _ordered(self, movers: Sequence[str]) -> list[str]:
        """Named places first, then containers, then what is next to others, at last what only makes room.

        What is to be between two others comes after these.
        """
        mentioned = {name: place for place, name in enumerate(self.goal.things())}
        for each in self.goal.of_kind(Between):
            mentioned[each.between[0]] = max(len(mentioned), *mentioned.values()) + 1

        def sort_key(name: str) -> tuple[int, int, int]:
            column = column_of(self.goal, name)
            base = column[-1]
            if self._named_place(base) is not None:
                kind = 0
            elif self.wanted.get(base, DESK) != DESK:
                kind = 1
            elif base in mentioned:
                kind = 2
            else:
                kind = 3
            place = len(self._line(base, 1)) if self._lined_up else mentioned.get(base, 0)
            if kind == 1:  # the largest first, while there is room
                place = -round(1e6 * self.present[base].size[0] * self.present[base].size[1])
            return kind, place, len(column)

        return sorted(movers, key=sort_key)

    def _named_place(self, name: str) -> Point | None:
        """The coordinates at which a thing has to be: its own, or those of a thing that is to be above or below it."""
        for each in self.goal.of_kind(AtPlace):
            if name == each.at or name in column_of(self.goal, each.at) or each.at in column_of(self.goal, name):
                return each.x, each.y
        return None

    def _is_next_to_another_place(self, there: Thing) -> bool:
        """Whether a thing at its named place leaves the fingers too little room at the named place of another."""
        others = (
            self.present[each.at].moved(each.x, each.y, there.z)
            for each in self.goal.of_kind(AtPlace)
            if each.at != there.name and (each.x, each.y) != self._named_place(there.name)
        )
        return any(_is_near(there, other, self.clearance) for other in others)

    # -- candidates ----------------------------------------------------------------------------------------------------

    def _candidates(self, name: str) -> Iterator[tuple[Thing, str]]:
        thing, below = self.present[name], self._below_now[name]
        wanted = self.wanted.get(name)
        is_carried_still = below == DESK or (below in self.final and self.final[below] == self.present[below])
        if below is not None and is_carried_still and wanted in (None, below) and self._may_stay(name):
            yield thing, below
        if wanted is not None and wanted != DESK:
            yield from self._carried(thing, wanted)
            return
        level = thing.size[2] / 2
        if (place := self._named_place(name)) is not None:
            there = thing.moved(*place, level)
            yield there, DESK
            if self._is_next_to_another_place(there):
                yield from ((each, DESK) for each in about_a_place(there))
            return
        later = list[Thing]()
        for each in self._on_desk(thing):
            if self._is_taken_now(each):
                later.append(each)
            else:
                yield each, DESK
        yield from ((each, DESK) for each in later)

    def _may_stay(self, name: str) -> bool:
        return name not in self._leaving and not self._is_in_line(name)

    def _is_taken_now(self, thing: Thing) -> bool:
        """Whether a thing that is to leave, itself not counted, is where one would be set down."""
        return any(
            is_in_the_way(thing, self.present[name], self.clearance) for name in self.order if name != thing.name
        )

    def _carried(self, thing: Thing, wanted: str) -> Iterator[tuple[Thing, str]]:
        carrier = self.final.get(wanted)
        if carrier is None:
            return
        if carrier.type in CONTAINERS:
            yield from ((each, wanted) for each in self._inside(thing, carrier))
        elif (top := carrier.top + thing.size[2]) <= self.workspace.highest_m:
            yaw = aligned(thing.yaw, carrier.yaw)
            yield thing.moved(carrier.x, carrier.y, top - thing.size[2] / 2, yaw), wanted

    def _inside(self, thing: Thing, container: Thing) -> Iterator[Thing]:
        """Places in a container: the middle first where one thing is wanted in it, else from its corner on."""
        z = container.bottom + WALL_M + thing.size[2] / 2
        if (named := self._named_place(thing.name)) is not None:
            yield thing.moved(*named, z)
            return
        if list(self.wanted.values()).count(container.name) == 1:
            yield from from_the_middle(thing, container, z)
            return
        inside = [each for name, each in self.final.items() if self.below[name] == container.name]
        yield from packed(thing, container, z, inside, self.clearance)
        yield from from_a_corner(thing, container, z)

    def _on_desk(self, thing: Thing) -> Iterator[Thing]:
        """Places on the desk: next to those that are placed, where a relation is to them; else the nearest free."""
        level, is_bound = thing.size[2] / 2, False
        for each in self.goal.all:
            partners = [self.final[name] for name in each.things() if name != thing.name and name in self.final]
            if thing.name not in each.things() or not partners:
                continue
            if isinstance(each, NextTo | Grouped):
                is_bound = True
                for partner in partners:
                    yield from around(thing, partner, self.clearance)
            elif isinstance(each, Beyond) and not self._is_in_line(thing.name):
                is_bound = is_bound or each.gap_m is not None
                yield from to_a_side(thing, partners[0], each, self.clearance)
            elif isinstance(each, Between):
                is_bound = is_bound or thing.name == each.between[0]
                yield from self._for_between(thing, each)
        if not is_bound:
            yield from (thing.moved(*point, level) for point in self._raster(thing))

    def _for_between(self, thing: Thing, wanted: Between) -> Iterator[Thing]:
        """Places in the middle of two that are placed, or for one of the two such that the other things have room."""
        middle, *ends = wanted.between
        partners = [self.final[name] for name in ends if name != thing.name and name in self.final]
        if thing.name == middle and len(partners) == len(ends):
            yield from amid(thing, partners)
        elif thing.name != middle and partners:
            yield from at_an_end(thing, partners[0], self.present[middle], self.clearance)

    def _raster(self, thing: Thing) -> list[Point]:
        """The places that may be chosen: the nearest first, or those farthest to the right of what a line leaves."""
        found = self.workspace.places((thing.x, thing.y))
        if not self._is_in_line(thing.name):
            return found
        right = [self.final[name] for name in self._right_of(thing.name) if name in self.final]
        least = max((each.footprint.extent(1)[1] for each in right), default=-math.inf) + self._width(thing.name) / 2
        return [point for point in sorted(found, key=lambda each: each[1]) if point[1] >= least]

    def _is_in_line(self, name: str) -> bool:
        """Whether a thing is placed by its line: left or right of others, by any distance."""
        return self._lined_up and any(name in each.left_of for each in self.goal.of_kind(LeftOf) if each.gap_m is None)

    def _right_of(self, name: str) -> list[str]:
        return [each.left_of[1] for each in self.goal.of_kind(LeftOf) if each.left_of[0] == name]

    # -- what is in the way, and what holds ----------------------------------------------------------------------------

    def _is_free(self, thing: Thing, below: str) -> bool:
        """Whether a thing may be set down at a place; a thing that stays where it is may."""
        now = self.present[thing.name]
        if thing == now and below == self._below_now[thing.name]:
            return not any(
                is_in_the_way(other, thing, self.clearance)
                for other in self.final.values()
                if other != self.present[other.name]
                and thing.name not in self._chain(other.name, self.below[other.name])
            )
        if not self._may_go(thing, below):
            return False
        carriers = self._chain(thing.name, below)
        room = self._needed(thing.name)
        blocking = [
            other.name
            for other in self.final.values()
            if other.name not in carriers
            and is_in_the_way(thing, other, min(self.clearance, room.get(other.name, math.inf)))
        ]
        if blocking and (self._named_place(thing.name) or self.wanted.get(thing.name, DESK) != DESK):
            self.blockers.update(dict.fromkeys(blocking))
        return not blocking and self._has_room_for_the_palm(thing, carriers)

    def _may_go(self, thing: Thing, below: str) -> bool:
        """Whether the arm takes a thing to a place: it was not refused, and what leaves is not set down here again."""
        now = self.present[thing.name]
        if is_avoided(thing, self.avoided) or min(thing.size[:2]) > self.workspace.opening_m:
            return False
        if thing.name in self._leaving and gap(thing.footprint, now.footprint) < 0:
            return False
        return self._is_in_place(thing, below) and self.workspace.reaches(now.x, now.y)

    def _has_room_for_the_palm(self, thing: Thing, carriers: set[str]) -> bool:
        """Whether the hand can let go there, in some direction, next to what is higher than its palm comes down."""
        others = [other for other in self.final.values() if other.name not in carriers]
        tall = (other for other in others if other.top > thing.z + PALM_UP_M)
        if not any(math.dist((thing.x, thing.y), (other.x, other.y)) < PALM_REACH_M for other in tall):
            return True
        return can_take(thing, others)

    def _is_in_place(self, thing: Thing, below: str) -> bool:
        """Whether a place is on the desk, or in its container, and in reach."""
        if not self.workspace.reaches(thing.x, thing.y) or thing.top > self.workspace.highest_m:
            return False
        is_chosen = below == DESK and self._named_place(thing.name) is None
        if is_chosen and not self.workspace.is_easy(thing.x, thing.y):
            return False
        carrier = self.final.get(below)
        if carrier is None or carrier.type not in CONTAINERS:
            return self.workspace.carries(thing.footprint)
        wall = self.clearance if carrier.top > thing.top else LEAST_M
        return overhang(thing.footprint, inner(carrier).footprint) <= -min(wall, self.clearance)

    def _needed(self, name: str) -> dict[str, float]:
        """Name → the free distance that was asked for next to it, which may be less than the clearance."""
        return {
            other: max(LEAST_M, each.gap_m - 0.001)
            for each in self.goal.all
            if isinstance(each, Beyond) and each.gap_m is not None and name in each.pair
            for other in each.pair
            if other != name
        }

    def _chain(self, name: str, below: str | None) -> set[str]:
        """What carries a thing, down to the desk, itself included."""
        return {name, *downward(below, self.below)}

    def _fits(self, name: str) -> bool:
        """Whether the relations of a thing to those that are placed hold, comfortably where one of them moves."""
        carrier = self.final.get(self.below[name] or DESK)
        if name in self.bases and carrier is not None and carrier.type not in CONTAINERS:
            return False
        wanted = [each for each in self.goal.all if name in each.things()]
        if any(isinstance(each, LeftOf) for each in wanted) and not self._leaves_room_at_its_sides(name):
            return False
        return all(self._may_hold(each) for each in wanted) and all(
            self._is_joined(name, each.grouped) for each in wanted if isinstance(each, Grouped)
        )

    def _leaves_room_at_its_sides(self, name: str) -> bool:
        """Whether all that is to be left and right of a thing can still be so: it is not too far to a side."""
        from_y, to_y = self.final[name].footprint.extent(1)
        left, right = (sum(map(self._width, self._line(name, side))) for side in (0, 1))
        farthest = self.workspace.farthest_m
        return (not left or to_y + left <= farthest) and (not right or from_y - right >= -farthest)

    def _line(self, name: str, side: int) -> tuple[str, ...]:
        """The widest line of things of which each is to be left (0) or right (1) of the one before."""
        if (name, side) not in self._lines:
            beyond = [each.left_of[side] for each in self.goal.of_kind(LeftOf) if each.left_of[1 - side] == name]
            lines = [(each, *self._line(each, side)) for each in beyond]
            self._lines[name, side] = max(lines, key=lambda line: sum(map(self._width, line)), default=())
        return self._lines[name, side]

    def _width(self, name: str) -> float:
        """Metres along y."""
        from_y, to_y = self.present[name].footprint.extent(1)
        return to_y - from_y

    def _is_joined(self, name: str, group: Sequence[str]) -> bool:
        """Whether a thing is near one of its group that is placed, if any is: a group grows from one place."""
        others = [self.final[each] for each in group if each != name and each in self.final]
        return not others or any(_is_near(self.final[name], other, GROUPED - SPARE_M) for other in others)

    def _may_hold(self, predicate: Predicate) -> bool:
        """Whether those of its things that are placed already are not against a relation.

        Where one of them moves, there is room to spare for an arm that is not exact, unless its place was named.
        """
        things = [self.final[name] for name in predicate.things() if name in self.final]
        is_whole = len(things) == len([name for name in predicate.things() if name != DESK])
        if is_whole and all(thing == self.present[thing.name] for thing in things):
            return self._holds_now[predicate]
        if any(self._named_place(thing.name) is not None for thing in things):
            return True
        if isinstance(predicate, Apart):
            return all(
                gap(one.footprint, other.footprint) >= self._apart(one, other) for other, one in combinations(things, 2)
            )
        if not is_whole:
            return True
        if isinstance(predicate, Beyond) and predicate.gap_m is None:
            further, other = (thing.footprint.extent(predicate.axis) for thing in things)
            return further[0] >= other[1]
        if isinstance(predicate, Between):
            return past_an_end(*(thing.footprint for thing in things)) <= SLACK_M
        if isinstance(predicate, NextTo):
            return gap(things[0].footprint, things[1].footprint) <= NEXT_TO - SPARE_M
        return not isinstance(predicate, Grouped) or are_linked(things, partial(_is_near, limit=GROUPED - SPARE_M))

    def _apart(self, one: Thing, other: Thing) -> float:
        """Metres that must be between two things: less where both stay."""
        stay = all(thing == self.present[thing.name] for thing in (one, other))
        return APART_M - APART + 2 * math.hypot(one.sigma_m, other.sigma_m) if stay else APART_M

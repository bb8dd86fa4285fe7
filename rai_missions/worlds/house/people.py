# SPDX-License-Identifier: Apache-2.0
"""The people of the house: who walks from place to place, and who waits in the way.

Rule: everything that they do follows from the seed and the world's clock. They never walk into the robot: they stop
before it, and turn to another way when it stays.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from rai_missions.errors import UsageError, suggestion
from rai_missions.worlds.house.costmap import Costmap
from rai_missions.worlds.house.layout import DOORS, PLACES
from rai_missions.worlds.house.planner import plan
from rai_missions.worlds.options import check_names, check_number

__all__ = ("People", "PersonPlan", "Resident", "residents")

People = int | Sequence[Mapping[str, Any]]
"""How many are drawn from the seed, or mappings of the fields of `PersonPlan`."""
MOST = 6
KEEP_M = 0.75
"""How near they come to the robot."""
BOUNDS = {"from_s": (0, 1_000_000), "pause_s": (0, 1_000_000), "speed_mps": (0.1, 2), "turn_deg": (-360, 360)}
FLAGS = ("lies", "helps")
HELP_S, ASKED_M = 3.0, 4.0
"""How long a person takes to help, and how near the robot must be to be understood."""
PATIENCE_S = 6.0
"""How long one waits for the robot before turning to another place."""
STAYS = (PLACES["kitchen"], PLACES["living_room"], PLACES["bedroom"], (6.2, 2.2), (3.6, 5.0), (1.2, 3.2))
Point = tuple[float, float]


@dataclass(frozen=True)
class PersonPlan:
    """Where one person is, and where they go."""

    at: str | Sequence[float] = "kitchen"
    """Where they are at first: a place, a door, or x and y."""
    walks: Sequence[str | Sequence[float]] = field(default_factory=tuple)
    """Where they go, one after the other and again from the first; empty: they stay."""
    from_s: float = 0.0
    """When they begin to walk."""
    pause_s: float = 8.0
    """How long they stay at each place."""
    speed_mps: float = 0.8
    name: str = ""
    turn_deg: float | None = None
    """Where they look at first, 0 is east, counter-clockwise; None: drawn from the seed."""
    lies: bool = False
    """Whether the person lies on the floor, feet where they look, below the plane of the lidar, and does not walk."""
    helps: bool = False
    """Asked by the robot, they clear the doorway that they are in or next to, and begin to walk."""


def place_people(seed: int, wanted: People | Any) -> tuple[PersonPlan, ...]:
    """Who is in the house.

    Raises:
        UsageError: There are too many, or a field or place does not exist or is out of range.
    """
    if isinstance(wanted, int):
        if isinstance(wanted, bool) or not 0 <= wanted <= MOST:
            raise UsageError(f"people: {wanted!r} is no number of people; give 0 to {MOST}, or a list")
        return tuple(_drawn(random.Random(f"people {seed} {number}")) for number in range(wanted))
    if isinstance(wanted, str) or not isinstance(wanted, Sequence) or len(wanted) > MOST:
        raise UsageError(f"people: give a number, or a list of at most {MOST}, not {wanted!r}")
    return tuple(_given(one) for one in wanted)


def _drawn(rng: random.Random) -> PersonPlan:
    stops = rng.sample([tuple(stay[:2]) for stay in STAYS], 4)
    return PersonPlan(stops[0], stops[1:], rng.uniform(0, 10), rng.uniform(4, 15), rng.uniform(0.6, 1.0))


def _given(one: Any) -> PersonPlan:
    known = [each.name for each in fields(PersonPlan)]
    if not isinstance(one, Mapping):
        raise UsageError(f"people: {one!r} is no person; give an object with the fields {', '.join(known)}")
    check_names("people", one, known)
    person = PersonPlan(**one)
    for name, (least, most) in BOUNDS.items():
        value = getattr(person, name)
        if name != "turn_deg" or value is not None:
            check_number(f"people: {name}", value, least, most)
    for name in FLAGS:
        if not isinstance(getattr(person, name), bool):
            raise UsageError(f"people: {name} takes true or false, not {getattr(person, name)!r}")
    if person.lies and person.walks:
        raise UsageError("people: a person who lies does not walk; drop 'lies' or 'walks'")
    if isinstance(person.walks, str):
        raise UsageError(f"people: walks takes a list of places, not {person.walks!r}")
    for stop in (person.at, *person.walks):
        point(stop)
    return person


def point(stop: str | Sequence[float]) -> Point:
    """Where a stop is.

    Raises:
        UsageError: No place or door has the name, or it is no place in the house where a person can be.
    """
    if isinstance(stop, str):
        if stop not in PLACES and stop not in DOORS:
            raise UsageError(f"people: no place {stop!r}{suggestion(stop, (*PLACES, *DOORS))}")
        return PLACES[stop][:2] if stop in PLACES else DOORS[stop]
    try:
        x, y = map(float, stop)
    except (TypeError, ValueError):
        raise UsageError(f"people: {stop!r} is no place; give a name, or x and y") from None
    if not _map().is_free_on_the_map(x, y):
        near = _map().nearest_free(x, y)
        where = f"the nearest free place is ({near[0]:g}, {near[1]:g})"
        raise UsageError(f"people: ({x:g}, {y:g}) is in a wall, in furniture or outside; {where}")
    return x, y


def residents(seed: int, wanted: People) -> list[Resident]:
    """The people of a house, ready to walk; raises `UsageError` as `place_people` does."""
    return [Resident(one, f"resident {seed} {number}") for number, one in enumerate(place_people(seed, wanted))]


class Resident:
    """One person on their way.

    Args:
        person: Who.
        seed: The seed of the choice where to turn when the robot stays in the way.
    """

    def __init__(self, person: PersonPlan, seed: str) -> None:
        self.plan = person
        self.x, self.y = point(person.at)
        drawn = random.Random(seed).uniform(-math.pi, math.pi)
        self.heading = drawn if person.turn_deg is None else math.radians(person.turn_deg)
        self._stops = [point(stop) for stop in person.walks]
        self._next, self._rests_until, self._way = 0, person.from_s, list[Point]()
        self._waits_since: float | None = None
        self._helps_at = math.inf

    def ask(self, at: float, robot: Point) -> None:
        """The robot asks for help; it is understood within a few metres."""
        if self.plan.helps and math.dist(robot, (self.x, self.y)) <= ASKED_M:
            self._helps_at = min(self._helps_at, at + HELP_S)

    def begin_to_help(self, at: float) -> bool:
        """Whether they clear the way now; from then on they walk."""
        if at < self._helps_at:
            return False
        self._helps_at, self._rests_until = math.inf, min(self._rests_until, at)
        return True

    def step(self, at: float, period_s: float, robot: Point, blocked: Sequence[Point]) -> bool:
        """Live on for a period; whether they moved.

        Args:
            at: Seconds since the start.
            period_s: How long.
            robot: Where it is.
            blocked: Doorways that a crate is in.
        """
        if not self._stops or at < self._rests_until:
            return False
        if not self._way:
            self._set_out()
        if not self._way:
            self._turn_away(at)
            return False
        if self._is_ahead(robot, KEEP_M) or any(self._is_ahead(door, KEEP_M) for door in blocked):
            self._waits_since = at if self._waits_since is None else self._waits_since
            if at - self._waits_since > PATIENCE_S:
                self._turn_away(at)
            return False
        self._waits_since = None
        self._walk(self.plan.speed_mps * period_s)
        if not self._way:
            self._next = (self._next + 1) % len(self._stops)
            self._rests_until = at + self.plan.pause_s
        return True

    def _set_out(self) -> None:
        grid = _map()
        cells = plan(grid.cost, grid.cell(self.x, self.y), grid.cell(*self._stops[self._next]))
        self._way = [] if cells is None else [*map(grid.middle, cells[1:]), self._stops[self._next]]

    def _turn_away(self, at: float) -> None:
        self._way, self._waits_since = [], None
        self._next = (self._next + 1) % len(self._stops)
        self._rests_until = at + 1.0

    def _is_ahead(self, other: Point, within_m: float) -> bool:
        dx, dy = other[0] - self.x, other[1] - self.y
        away = math.hypot(dx, dy)
        x, y = self._way[0]
        towards = (x - self.x) * dx + (y - self.y) * dy
        return away < within_m and towards > -0.2 * away * math.dist((x, y), (self.x, self.y))

    def _walk(self, step_m: float) -> None:
        while self._way and step_m > 1e-9:
            x, y = self._way[0]
            left = math.dist((x, y), (self.x, self.y))
            if left > 1e-6:
                self.heading = math.atan2(y - self.y, x - self.x)
            share = min(1.0, step_m / left) if left > 1e-9 else 1.0
            self.x, self.y = self.x + share * (x - self.x), self.y + share * (y - self.y)
            step_m -= share * left
            if share >= 1.0:
                self._way.pop(0)


@cache
def _map() -> Costmap:
    """The map without anything that was seen."""
    return Costmap()

# SPDX-License-Identifier: Apache-2.0
"""Which obstacle lies in which alley, from the seed, and what the living ones do.

Rule: nothing here decides what may be driven over; that is found out by driving (`crossing_judge.py`).
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.worlds.options import check_names, check_number
from rai_missions.worlds.orchard.kinds import KINDS, LIVING
from rai_missions.worlds.orchard.layout import Layout

__all__ = ("Obstacle", "Walker", "place")

NEVER = 99
FIRST = 28138
"""Such that seed 7 shows a bit of everything: two branches, a sheep that minds the horn, a worker who does not."""
ODDS = (("none", 20), ("branch", 30), ("person", 16), ("animal", 16), ("crate", 6), ("log", 6), ("fallen_tree", 6))
AWAY_M = 14.0
"""How far beyond the mouths of the alleys a living thing stops when it walks away."""
MEETS_M, SHIES_M = 10.0, 7.0
SPEED_MPS = {"person": 1.5, "animal": 2.6, "cat": 3.0, "lying_person": 1.5}
ASIDE_M = 2.3
"""Where a worker attends to something, off the middle of the alley: between two trees."""


BOUNDS = {
    "along": (0, 1),
    "across_m": (-5, 5),
    "turn_deg": (-360, 360),
    "heeds_after": (0, NEVER),
    "lingers_s": (0, 1e6),
    "size": (0.2, 3),
}
"""Field of an obstacle → its least and its greatest number."""


@dataclass(frozen=True)
class Obstacle:
    """One thing in an alley."""

    kind: str
    alley: int
    along: float = 0.55
    """Where in the alley, from its western (0) to its eastern (1) end."""
    across_m: float = 0.0
    """Off the alley's middle, to the left of x."""
    turn_deg: float = 80.0
    heeds_after: int = 1
    """Of the living: it walks away after so many signals (99: it never heeds them)."""
    lingers_s: float = 40.0
    """Of the living: so long after the tractor first came near, it walks away by itself."""
    size: float = 1.0
    """1 is the usual one; a log's or branch's radius, the height of grass and the extent of a puddle scale with it."""
    variant: str = ""
    """One of its kind's: `full` (a bag), `bridged` (a hose), `deep` (a puddle), `muffs` (a deaf person),
    `tethered` (an animal), `resting` (a person who lies next to a basket)."""
    hides: str = ""
    """Of tall grass: the kind that lies in it."""
    attended: bool = False
    """A worker at the trees carries it away: after so many signals (`heeds_after`), or by himself (`lingers_s`)."""
    attends: int | None = None
    """Of that worker: the number of the thing."""

    @property
    def living(self) -> bool:
        return self.kind in LIVING

    def place_m(self, layout: Layout) -> tuple[float, float]:
        return self.along * layout.length_m, layout.centre_m(self.alley) + self.across_m


def place(seed: int, layout: Layout, wanted: Sequence[str | None | Mapping[str, Any]] | None) -> tuple[Obstacle, ...]:
    """The obstacles of an orchard, at most one an alley.

    Args:
        seed: What is not given is drawn from it.
        layout: The orchard.
        wanted: A kind for each alley in turn (None or `none`: nothing), or a mapping of `Obstacle`'s fields; left
            out, the kinds are drawn, too.

    Raises:
        UsageError: A kind or a field does not exist, it is no list, or there are more obstacles than alleys.
    """
    rng = random.Random(1009 * seed + FIRST)
    drawn = [_draw(rng, alley) for alley in range(layout.alleys)]
    if wanted is None:
        return _complete([obstacle for obstacle in drawn if obstacle.kind != "none"], layout)
    if isinstance(wanted, str):
        raise UsageError(f'obstacles: {wanted!r} is no list; give a kind for each alley in turn, ["branch", "none"]')
    if len(wanted) > layout.alleys:
        raise UsageError(f"obstacles: {len(wanted)} obstacles for {layout.alleys} alleys; at most one an alley")
    chosen = (_chosen(what, drawn[alley]) for alley, what in enumerate(wanted))
    return _complete([obstacle for obstacle in chosen if obstacle.kind != "none"], layout)


def _complete(things: list[Obstacle], layout: Layout) -> tuple[Obstacle, ...]:
    """The things, then what lies hidden in them, then who attends to them."""
    hidden = [replace(one, kind=one.hides, hides="", size=1.0, variant="") for one in things if one.hides]
    workers = [
        replace(
            one,
            kind="person",
            across_m=ASIDE_M,
            along=_between_trees(one.along, layout),
            turn_deg=270.0,
            size=1.0,
            variant="",
            hides="",
            attended=False,
            attends=number,
        )
        for number, one in enumerate(things)
        if one.attended
    ]
    return (*things, *hidden, *workers)


def _between_trees(along: float, layout: Layout) -> float:
    """The place between two trunks that is nearest to a share of the alley."""
    trunks = sorted({x for x, _ in layout.trees()})
    gaps = [(first + second) / 2 for first, second in itertools.pairwise(trunks)]
    return min(gaps, key=lambda x: abs(x - along * layout.length_m)) / layout.length_m


def _draw(rng: random.Random, alley: int) -> Obstacle:
    kind = rng.choices([kind for kind, _ in ODDS], [odds for _, odds in ODDS])[0]
    along, across, turn = rng.uniform(0.45, 0.65), rng.uniform(-0.2, 0.2), rng.uniform(70, 110)
    heeds, lingers = rng.choice((1, 2, NEVER)), rng.uniform(30, 60)
    if kind in LIVING:
        turn = rng.uniform(0, 360)
    return Obstacle(kind, alley, round(along, 3), round(across, 3), round(turn, 1), heeds, round(lingers, 1))


def _chosen(what: str | None | Mapping[str, Any], drawn: Obstacle) -> Obstacle:
    choice = dict(what) if isinstance(what, Mapping) else {"kind": what or "none"}
    known = [field.name for field in fields(Obstacle)]
    check_names("obstacles", choice, known)
    for field, kinds in (("kind", (*KINDS, "none")), ("hides", (*KINDS, ""))):
        if choice.get(field, "") not in kinds or (field == "kind" and "kind" not in choice):
            raise UsageError(f"obstacles: no kind {choice.get(field)!r}; there are: {', '.join(KINDS)}, none")
    for field, bounds in BOUNDS.items():
        if field in choice:
            check_number(f"obstacles: {field}", choice[field], *bounds)
    made = Obstacle(**{**{field: getattr(drawn, field) for field in known}, **choice})
    why = _fault(made)
    if why:
        raise UsageError(f"obstacles: {why}")
    return made


def _fault(one: Obstacle) -> str:
    """What cannot be built; empty if it can."""
    if one.kind == "none":
        return ""
    kind = KINDS[one.kind]
    if one.variant not in kind.variants:
        named = ", ".join(repr(variant) for variant in kind.variants)
        return f"{one.kind} has no variant {one.variant!r}; it has: {named}"
    if one.hides and one.kind != "tall_grass":
        return f"{one.kind} hides nothing; tall_grass does"
    if one.attended and not kind.carried:
        carried = ", ".join(name for name, each in KINDS.items() if each.carried)
        return f"no one carries away a {one.kind}; what one can carry: {carried}"
    return ""


class Walker:
    """A living obstacle that may walk away: along the alley, away from the tractor, out to the meadow.

    It never walks into the tractor: it turns around when the tractor comes towards it.
    """

    def __init__(self, obstacle: Obstacle, layout: Layout) -> None:
        self.obstacle, self._layout = obstacle, layout
        self.x, self.y = obstacle.place_m(layout)
        self.heading = math.radians(obstacle.turn_deg)
        self._signals = 0
        self._met_at: float | None = None
        self._goal_x: float | None = None

    def signal(self, tractor_x: float) -> None:
        """The tractor sounded its horn and flashed its lights nearby."""
        self._signals += 1
        if self._signals >= self.obstacle.heeds_after:
            self._leave(tractor_x)

    def step(self, at: float, period_s: float, tractor: tuple[float, float]) -> bool:
        """Live on for a period; whether it moved."""
        if self._has_waited(at, tractor):
            self._leave(tractor[0])
        if self._goal_x is None or self.x == self._goal_x:
            return False
        if math.hypot(tractor[0] - self.x, tractor[1] - self.y) < SHIES_M and self._is_ahead(tractor[0]):
            self._goal_x = self._away_from(tractor[0])
        self._walk(SPEED_MPS[self.obstacle.kind] * period_s)
        return True

    def _has_waited(self, at: float, tractor: tuple[float, float]) -> bool:
        """Whether the tractor came near so long ago that it has had enough."""
        middle = self._layout.centre_m(self.obstacle.alley)
        is_met = abs(tractor[1] - middle) < self._layout.radius_m and abs(tractor[0] - self.x) < MEETS_M
        if self._met_at is None and is_met:
            self._met_at = at
        return self._met_at is not None and at - self._met_at > self.obstacle.lingers_s

    def _leave(self, tractor_x: float) -> None:
        if self._goal_x is None:
            self._goal_x = self._away_from(tractor_x)

    def _away_from(self, tractor_x: float) -> float:
        return self._layout.length_m + AWAY_M if tractor_x < self.x else -AWAY_M

    def _is_ahead(self, tractor_x: float) -> bool:
        return self._goal_x is not None and (tractor_x - self.x) * (self._goal_x - self.x) > 0

    def _walk(self, step_m: float) -> None:
        """A step towards the goal, and to the middle of the alley on the way."""
        assert self._goal_x is not None
        along = self._goal_x - self.x
        aside = self._layout.centre_m(self.obstacle.alley) - self.y
        self.heading = math.atan2(max(-0.3, min(0.3, aside)), math.copysign(1.0, along))
        self.x += math.copysign(min(step_m, abs(along)), along)
        self.y += math.copysign(min(0.3 * step_m, abs(aside)), aside)

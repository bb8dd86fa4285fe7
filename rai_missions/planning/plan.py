# SPDX-License-Identifier: Apache-2.0
"""A plan as a value: which thing goes where, what each move assumes, and why it is made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rai_missions.planning.goal import Refusal
from rai_missions.planning.scene import Thing

__all__ = ("AvoidedPlace", "Plan", "PlannedMove", "Pose", "avoided_after", "is_avoided", "plan_data")

SAME_M = 0.02
"""Metres from a place that the arm refused within which it would refuse another."""


class Pose(NamedTuple):
    """Where the centre of a thing is: metres, and radians counter-clockwise seen from above."""

    x: float
    y: float
    z: float
    yaw: float

    @classmethod
    def of(cls, thing: Thing) -> Pose:
        return cls(*(round(float(value), 4) for value in (thing.x, thing.y, thing.z, thing.yaw)))

    def written(self) -> dict[str, float]:
        return self._asdict()


class AvoidedPlace(NamedTuple):
    """A place at which the arm did not set a thing down."""

    object: str
    """The thing's name."""
    place: Pose
    """Where its centre was to be."""

    def written(self) -> dict[str, Any]:
        """As plain data."""
        return {"object": self.object, "place": self.place.written()}


@dataclass(frozen=True)
class PlannedMove:
    """One thing, picked where it is and set down elsewhere."""

    object: str
    """The thing's name."""
    pick: Pose
    """Where its centre is."""
    place: Pose
    """Where its centre will be."""
    onto: str
    """What it will rest on or in: a thing, or `desk`."""
    assumes: tuple[str, ...]
    """What must be so when the move begins, for people who review the plan."""
    why: str
    """What it is for."""
    spare: Pose | None = None
    """Where else its centre may be meanwhile, should the arm set it down neither there nor where it was."""

    def written(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "kind": "pick_and_place",
            "object": self.object,
            "pick": self.pick.written(),
            "place": self.place.written(),
            "spare": self.spare.written() if self.spare is not None else None,
            "onto": self.onto,
            "assumes": list(self.assumes),
            "why": self.why,
        }


@dataclass(frozen=True)
class Plan:
    """The moves that lead to a goal, in their order; none where it holds already."""

    moves: tuple[PlannedMove, ...] = ()
    about: str = ""
    """What a person should know of it, as a sentence: a place that the arm refused is tried again."""

    @property
    def next(self) -> PlannedMove | None:
        """The move to make now."""
        return self.moves[0] if self.moves else None


def plan_data(
    found: Plan | Refusal, avoided: tuple[AvoidedPlace, ...] = (), aside: Pose | None = None
) -> dict[str, Any]:
    """A plan, or why there is none, as plain data: the same fields for both.

    Args:
        found: The plan, or the refusal.
        avoided: The places that were to be avoided.
        aside: Where what the gripper holds may be set down, where it holds something.
    """
    moves = [move.written() for move in found.moves] if isinstance(found, Plan) else []
    reason = "" if isinstance(found, Plan) else found.refused
    places = [each.written() for each in avoided]
    data = {"moves": moves, "next": moves[0] if moves else None, "reason": reason, "about": found.about}
    return {**data, "avoided": places, **({"aside": aside.written()} if aside is not None else {})}


def is_avoided(thing: Thing, avoided: Iterable[AvoidedPlace]) -> bool:
    """Whether the arm refused to set a thing down where it is."""
    here = (thing.x, thing.y, thing.z)
    return any(each.object == thing.name and math.dist(each.place[:3], here) < SAME_M for each in avoided)


def avoided_after(last: object) -> tuple[AvoidedPlace, ...]:
    """The places to avoid once the arm refused the next move of a plan: its own, and those that it avoided.

    Args:
        last: The plan as plain data; what is no place in it is left out.
    """
    if not isinstance(last, Mapping):
        return ()
    return tuple(dict.fromkeys(_places([*(last.get("avoided") or ()), last.get("next")])))


def _places(data: list[Any]) -> Iterator[AvoidedPlace]:
    for each in data:
        if isinstance(each, Mapping) and isinstance(each.get("place"), Mapping):
            yield AvoidedPlace(str(each["object"]), Pose(**each["place"]))

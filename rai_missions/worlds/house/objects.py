# SPDX-License-Identifier: Apache-2.0
"""Which objects are where in the house: drawn from the seed, or as a scene names them.

Rule: what is not given is drawn from the seed, each in its own place; no two objects share a spot.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rai_missions.errors import UsageError, suggestion
from rai_missions.plain_data import is_number
from rai_missions.worlds.house.figures import COLOURS, FIGURES
from rai_missions.worlds.house.layout import DEPTH_M, SPOTS, WIDTH_M, Spot
from rai_missions.worlds.options import check_names

__all__ = ("HouseObject", "Objects", "place_objects")

Objects = Sequence[str | Mapping[str, Any]]
"""Kinds, or mappings of the fields `kind`, `spot` or `at` (x, y and height in m), and `colour`."""
FIELDS = ("kind", "spot", "at", "colour")


@dataclass(frozen=True)
class HouseObject:
    """One object."""

    kind: str
    colour: str
    place: Spot
    turn_deg: float
    spot: str = ""
    """The name of its place, where it has one."""


def place_objects(seed: int, wanted: Objects | None) -> tuple[HouseObject, ...]:
    """The objects of a house.

    Args:
        seed: What is not given is drawn from it.
        wanted: None: one of each kind.

    Raises:
        UsageError: A kind, spot, colour or field does not exist, or two objects share a spot.
    """
    if isinstance(wanted, str) or (wanted is not None and not isinstance(wanted, Sequence)):
        raise UsageError(f'objects: {wanted!r} is no list; give kinds or objects, ["cup", {{"kind": "ball"}}]')
    rng = random.Random(f"objects {seed}")
    asked = [_fields(one) for one in (tuple(FIGURES) if wanted is None else wanted)]
    taken = [str(one["spot"]) for one in asked if "spot" in one]
    for spot in taken:
        if taken.count(spot) > 1:
            raise UsageError(f"objects: two are on {spot!r}; a spot holds one")
    free = [spot for spot in SPOTS if spot not in taken]
    rng.shuffle(free)
    return tuple(_placed(one, free, rng) for one in asked)


def _fields(given: str | Mapping[str, Any]) -> dict[str, Any]:
    one = dict(given) if isinstance(given, Mapping) else {"kind": given}
    check_names("objects", one, FIELDS)
    for field, known in (("kind", FIGURES), ("spot", SPOTS), ("colour", COLOURS)):
        if (field == "kind" or field in one) and one.get(field) not in known:
            raise UsageError(f"objects: no {field} {one.get(field)!r}{suggestion(str(one.get(field)), known)}")
    if "at" in one:
        if "spot" in one:
            raise UsageError(f"objects: a {one['kind']} is on a 'spot' or 'at' a place; keep one")
        _check_place(one["at"])
    return one


def _check_place(at: Any) -> None:
    is_place = isinstance(at, Sequence) and not isinstance(at, str) and len(at) == 3
    if not is_place or not all(map(is_number, at)):
        raise UsageError(f"objects: {at!r} is no place; give x, y and the height of what it is on, [2.6, 1.9, 0.74]")
    if not (0 <= at[0] <= WIDTH_M and 0 <= at[1] <= DEPTH_M and 0 <= at[2] <= 2.5):
        raise UsageError(f"objects: {list(at)} is outside of the house, {WIDTH_M} m by {DEPTH_M} m")


def _placed(one: Mapping[str, Any], free: list[str], rng: random.Random) -> HouseObject:
    kind = one["kind"]
    look = FIGURES[kind]
    colour, turn = one.get("colour", rng.choice(look.colours)), rng.uniform(0, 360)
    if "at" in one:
        return HouseObject(kind, colour, Spot(*map(float, one["at"])), turn)
    fitting = [spot for spot in free if (SPOTS[spot].height == 0) == look.on_floor]
    if "spot" not in one and not fitting:
        raise UsageError(f"objects: no spot is left for another {kind}; give it a place: {{'at': [x, y, height]}}")
    spot = one.get("spot") or fitting[0]
    if spot in free:
        free.remove(spot)
    return HouseObject(kind, colour, SPOTS[spot], turn, spot)

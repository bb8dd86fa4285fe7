# SPDX-License-Identifier: Apache-2.0
"""Examples of goals, of what is seen and of requests, which belong together: for proofs, and for played robots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ("GOALS", "PAIRS", "REQUESTS", "SIGHTS", "ways")

Json = dict[str, Any]
PAIRS = (("red_cube", "blue_cube"), ("green_cube", "yellow_cube"))
GOALS: tuple[Mapping[str, Any], ...] = tuple({"all": [{"on": list(pair)}]} for pair in PAIRS)
"""One thing on another, for each pair: goals without a thing in common."""
REQUESTS = tuple(f"put the {upper} on the {lower}".replace("_", " ") for upper, lower in PAIRS)
"""A request for each goal."""
SIDE_M = 0.044


def ways(upper: str, lower: str, x: float) -> Iterator[list[Json]]:
    """How two things may lie: stacked, side by side, on what nothing rests on; seen too seldom, or one of them not.

    Args:
        upper: The thing that is wanted on top.
        lower: The other.
        x: Where they are, in metres.
    """
    below, above = _thing(lower, x, 0.0, SIDE_M / 2), _thing(upper, x, 0.0, 1.5 * SIDE_M)
    aside = _thing(upper, x, 0.2, SIDE_M / 2)
    yield [below, above]
    yield [below, aside]
    yield [below | {"type": "tomato"}, aside]
    yield [below, aside | {"agreeing": 1}]
    yield [below]


def _thing(name: str, x: float, y: float, z: float) -> Json:
    return {
        "name": name,
        "type": "cube",
        "colour": name.partition("_")[0],
        "x": x,
        "y": y,
        "z": z,
        "yaw": 0.0,
        "size": [SIDE_M] * 3,
        "sigma_m": 0.001,
        "looks": 5,
        "agreeing": 5,
        "at_rest": True,
    }


_stacked, _apart, *_rest = ways(*PAIRS[0], x=0.5)
SIGHTS: tuple[Json, ...] = tuple({"things": things, "gripper": "empty"} for things in (_apart, _stacked, *_rest))
"""What may be seen of the first pair; first the two side by side."""

# SPDX-License-Identifier: Apache-2.0
"""Examples of goals, sights, requests, readings and plans, which belong together: for proofs and played robots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

__all__ = ("GOALS", "PAIRS", "PLANS", "READINGS", "REQUESTS", "SIGHTS", "ways")

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


_POSE: Json = {"x": 0.5, "y": 0.2, "z": 0.022, "yaw": 0.0}
_MOVE: Json = {
    "kind": "pick_and_place",
    "object": PAIRS[0][0],
    "pick": _POSE,
    "place": _POSE,
    "onto": PAIRS[0][1],
    "assumes": [],
    "why": "",
}
_MOVES: tuple[Json | None, ...] = (None, {**_MOVE, "spare": None}, {**_MOVE, "spare": _POSE})


def _plans(moves: Iterable[Json | None], reason: str) -> tuple[Json, ...]:
    """Plans with each of these next moves, with and without a thing in the hand."""
    return tuple(
        {"moves": [], "next": move, "reason": reason, "about": "", "avoided": [], **held}
        for move in moves
        for held in ({}, {"aside": _POSE})
    )


def _reading(goal: Mapping[str, Any] | None, **fields: str) -> Json:
    return {"goal": goal, "question": "", "candidates": [], "reason": "", "about": "", "covers_all": False, **fields}


PLANS: Mapping[str, Sequence[Json]] = {"succeeded": _plans(_MOVES, ""), "failed": _plans((None,), "unreachable")}
"""How planning can end → plans: which fields a plan has, and which of them are unknown, is so in one of these."""
READINGS: Mapping[str, Sequence[Json]] = {
    "succeeded": (_reading(GOALS[0]),),
    "unclear": (_reading(None, question="which one?", reason="ambiguous"),),
    "refused": (_reading(None, reason="forbidden"),),
}
"""How reading a request can end → readings, as in `PLANS`."""

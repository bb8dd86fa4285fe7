# SPDX-License-Identifier: Apache-2.0
"""Scenes of the orchard, drawn from seeds: what lies in the alley, how the light is, how well the detector sees.

Rule: a scene is a function of its seed alone. The cases name what lies there; which option is right, rollouts find
out. What they found on scenes for tuning decides weight and order of the cases.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from rai_missions.worlds.drawn_cases import DrawnCase, drawn_case

__all__ = ("CASES", "scene_options")

ALLEYS, LENGTH_M = 2, 14.0
NEVER, LONG_S = 99, 900.0
Draw = random.Random
Fields = dict[str, Any]


def scene_options(seed: int) -> tuple[str, Fields]:
    """The kind of the obstacle, and the keywords of `Orchard` that build the scene."""
    _, kind, draw = drawn_case(seed, CASES)
    rng = random.Random(f"orchard scene {seed}")
    obstacle = {
        "kind": kind,
        "alley": 0,
        "along": _round(rng.uniform(0.5, 0.62)),
        "across_m": _round(rng.uniform(-0.15, 0.15)),
        "turn_deg": _round(rng.uniform(72, 108)),
        "heeds_after": NEVER,
        "lingers_s": LONG_S,
    }
    obstacle |= {name: _round(value) for name, value in draw(rng).items()}
    air = _air(rng)
    bad = max(air.values(), default=0.0)
    options: Fields = {
        "seed": seed,
        "alleys": ALLEYS,
        "length_m": LENGTH_M,
        "obstacles": [obstacle],
        "detector": {
            "noise": _round(0.02 + 0.23 * bad * rng.random()),
            "miss": _round(0.15 * bad * rng.random()),
            "confuse": _round(rng.uniform(0.0, 0.04) + 0.26 * bad * rng.random()),
        },
        "stop_at_m": _round(rng.choice((4.0, 5.0, 5.0, 6.0, 7.0))),
    }
    return kind, options | ({"conditions": air} if air else {})


def _air(rng: Draw) -> dict[str, float]:
    """A clear day in half of the scenes; else one thing that is bad for the eyes."""
    what = rng.choice(("", "", "", "", "dusk", "glare", "fog", "dust"))
    return {what: _round(rng.uniform(0.3, 1.0))} if what else {}


def _round(value: Any) -> Any:
    return round(value, 3) if isinstance(value, float) else value


def _side(rng: Draw, low: float, high: float) -> float:
    return rng.choice((-1.0, 1.0)) * rng.uniform(low, high)


def _as_is(_rng: Draw) -> Fields:
    return {}


def _facing(rng: Draw) -> Fields:
    return {"turn_deg": rng.uniform(0, 360)}


def _heeding(rng: Draw) -> Fields:
    return {"heeds_after": rng.choice((1, 1, 2))}


def _leaving(rng: Draw) -> Fields:
    return {"lingers_s": rng.uniform(16, 26)}


def _attended(rng: Draw) -> Fields:
    return {"attended": True}


def _track(rng: Draw) -> Fields:
    """Where a wheel runs."""
    return {"across_m": _side(rng, 0.7, 0.95)}


def _flat(rng: Draw) -> Fields:
    return {"turn_deg": rng.uniform(-15, 15), "size": rng.uniform(0.8, 1.3)}


def _hidden(rng: Draw) -> Fields:
    return {**_flat(rng), "size": 1.25, "hides": rng.choice(("lying_person", "cat")), **_track(rng)}


def _lengthwise(rng: Draw) -> Fields:
    return {"turn_deg": _side(rng, 5, 9), "across_m": rng.uniform(-0.1, 0.1)}


def _has(**fields: Any) -> Callable[[Draw], Fields]:
    return lambda _rng: fields


def _sized(low: float, high: float) -> Callable[[Draw], Fields]:
    return lambda rng: {"size": rng.uniform(low, high)}


def _turned(middle_deg: float) -> Callable[[Draw], Fields]:
    return lambda rng: {"turn_deg": middle_deg + rng.uniform(-6, 6)}


def _all(*draws: Callable[[Draw], Fields]) -> Callable[[Draw], Fields]:
    def drawn(rng: Draw) -> Fields:
        return {name: value for draw in draws for name, value in draw(rng).items()}

    return drawn


FULL, THICK = _all(_has(variant="full"), _track), _sized(1.9, 2.4)
UPHILL, DOWNHILL = _turned(0.0), _turned(180.0)
MUFFS, TETHERED, RESTING = _has(variant="muffs"), _has(variant="tethered"), _has(variant="resting")
CASES: tuple[DrawnCase, ...] = (
    (4.8, "tall_grass", _flat),
    (4.7, "plastic_bag", _as_is),
    (1.6, "plastic_bag", _has(variant="full", across_m=0.05)),
    (2.8, "puddle", _sized(0.8, 1.2)),
    (5.0, "hose", _lengthwise),
    (1.9, "hose", _has(variant="bridged", across_m=0.0, turn_deg=90.0)),
    (7.3, "ladder", _lengthwise),
    (1.6, "fallen_fence", UPHILL),
    (5.0, "branch", _sized(0.7, 1.15)),
    (1.1, "crate", lambda rng: {"across_m": _side(rng, 1.3, 1.4), "turn_deg": 90.0}),
    (0.7, "log", _all(_lengthwise, _sized(0.7, 0.9))),
    (0.3, "branch", _all(THICK, _attended, _leaving)),
    # what leaves by itself
    (1.9, "plastic_bag", _all(FULL, _attended, _leaving)),
    (2.5, "hose", _all(_attended, _leaving)),
    (2.6, "ladder", _all(_attended, _leaving)),
    (1.3, "crate", _all(_attended, _leaving)),
    (1.2, "scarecrow", _all(_attended, _leaving)),
    (4.3, "person", _all(_facing, MUFFS, _leaving)),
    (3.4, "animal", _all(_facing, _leaving)),
    (3.2, "cat", _all(_track, _facing, _leaving)),
    (2.0, "lying_person", _all(RESTING, _leaving)),
    # what heeds a signal
    (2.0, "plastic_bag", _all(FULL, _attended, _heeding)),
    (2.2, "hose", _all(_attended, _heeding)),
    (2.3, "ladder", _all(_attended, _heeding)),
    (1.2, "crate", _all(_track, _attended, _heeding)),
    (1.3, "scarecrow", _all(_attended, _heeding)),
    (4.3, "person", _all(_facing, _heeding)),
    (3.5, "animal", _all(_facing, _heeding)),
    (3.2, "cat", _all(_track, _facing, _heeding)),
    (2.4, "lying_person", _all(RESTING, _heeding)),
    (0.3, "branch", _all(THICK, _attended, _heeding)),
    # what stays
    (0.1, "plastic_bag", FULL),
    (0.1, "puddle", _all(_sized(1.4, 1.6), _has(variant="deep", across_m=0.0))),
    (0.2, "fallen_fence", DOWNHILL),
    (0.4, "log", _sized(0.8, 1.2)),
    (0.4, "fallen_tree", _as_is),
    (0.6, "fallen_tree", _lengthwise),
    (4.5, "tall_grass", _hidden),
    (3.3, "hose", _as_is),
    (3.1, "ladder", _as_is),
    (1.2, "scarecrow", _facing),
    (0.5, "person", _all(_facing, MUFFS)),
    (0.5, "animal", _all(_facing, TETHERED)),
    (0.7, "lying_person", _as_is),
)
"""Weight, kind, and what is drawn for it. Cases that came out alike on scenes for tuning stand together: the golden
ratio's multiples fill neighbours evenly, so each outcome has about its share in any run of seeds."""

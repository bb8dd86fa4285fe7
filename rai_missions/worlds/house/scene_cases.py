# SPDX-License-Identifier: Apache-2.0
"""Scenes of the house, drawn from seeds: what blocks the pantry's only door, for how long, and who is there to help.

Rule: a scene is a function of its seed alone. The cases name what is there; which option is right, rollouts find out.
Times count from the start. The patrol to the study and the pantry asks after 23 s where a person blocks the door, and
after 16 s where a crate does.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

from rai_missions.worlds.drawn_cases import DrawnCase, drawn_case

__all__ = ("CASES", "scene_options")

DOOR, CORNER = "study_pantry", (8.7, 0.6)
PERSON_S, CRATE_S = 22.6, 16.0
"""When the question comes, where a person blocks the door, and where a crate does."""
STAYS_S = 1_000_000.0
LATER: Mapping[str, Mapping[str, str]] = {"operator": {"asking": "go_on"}, "agent": {"deciding": "wait"}}
"""What is answered later in a rollout where a person helps: the way is free."""
Draw = random.Random
Fields = dict[str, Any]


def scene_options(seed: int) -> tuple[str, Fields, Fields]:
    """The kind of the case, the keywords of `House` that build the scene, and who answers later questions."""
    _, kind, draw = drawn_case(seed, CASES)
    rng = random.Random(f"house scene {seed}")
    options = {"seed": seed, "objects": [], "battery": {"charge": round(rng.uniform(0.5, 1.0), 3)}, **draw(rng)}
    helped = any(one.get("helps") for one in options.get("people", ()))
    return kind, options, {who: dict(answers) for who, answers in LATER.items()} if helped else {}


def _between(rng: Draw, low: float, high: float) -> float:
    return round(rng.uniform(low, high), 2)


def _in_the_door(rng: Draw, leaves_s: float, **fields: Any) -> Fields:
    """A person who blocks the door, and walks into the pantry's corner later."""
    at = [_between(rng, 7.6, 7.72), _between(rng, 1.95, 2.05)]
    walk = {"walks": [list(CORNER)], "from_s": round(leaves_s, 2), "pause_s": STAYS_S}
    return {"at": at, **walk, "turn_deg": _between(rng, -60, 60), **fields}


def _leaves_now(rng: Draw) -> Fields:
    person = _in_the_door(rng, PERSON_S + rng.uniform(0.3, 3.0))
    return {"recoveries": 3, "people": [person], "battery": {"charge": round(rng.uniform(0.2618, 0.2624), 4)}}


def _closes_again(rng: Draw) -> Fields:
    person = _in_the_door(rng, PERSON_S + rng.uniform(0.1, 0.6))
    return {"recoveries": 3, "people": [person], "blocked": {DOOR: [PERSON_S + _between(rng, 17.5, 19.0), STAYS_S]}}


def _leaves_later(rng: Draw) -> Fields:
    return {"recoveries": 3, "people": [_in_the_door(rng, PERSON_S + rng.uniform(9.0, 18.0))]}


def _crate_leaves(rng: Draw) -> Fields:
    return {"recoveries": 1, "blocked": {DOOR: [0, CRATE_S + _between(rng, 6.0, 17.0)]}}


def _heeds(rng: Draw) -> Fields:
    facing = {"turn_deg": _between(rng, 150, 210), "helps": True}
    return {"recoveries": 3, "people": [_in_the_door(rng, STAYS_S, **facing)]}


def _crate_attended(rng: Draw) -> Fields:
    helper = {"at": [_between(rng, 7.15, 7.3), _between(rng, 2.8, 2.95)], "turn_deg": _between(rng, 210, 250)}
    return {"recoveries": 1, "blocked": {DOOR: []}, "people": [helper | {"helps": True}]}


def _lies(rng: Draw) -> Fields:
    at = [_between(rng, 6.95, 7.1), _between(rng, 2.1, 2.4)]
    lying = {"at": at, "lies": True, "turn_deg": _between(rng, 75, 105)}
    return {"recoveries": 3, "people": [_in_the_door(rng, PERSON_S + rng.uniform(0.3, 4.0)), lying]}


def _crate_stays(_rng: Draw) -> Fields:
    return {"recoveries": 1, "blocked": {DOOR: []}}


CASES: tuple[DrawnCase, ...] = (
    (16, "leaves_now_low_battery", _leaves_now),
    (13, "closes_again", _closes_again),
    (15, "leaves_later", _leaves_later),
    (14, "crate_leaves", _crate_leaves),
    (15, "heeds", _heeds),
    (14, "crate_attended", _crate_attended),
    (10, "lies", _lies),
    (3, "crate_stays", _crate_stays),
)
"""Weight, kind, and what is drawn for it. Cases of one outcome are neighbours, so that each outcome has about its
share in any run of seeds."""

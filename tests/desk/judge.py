# SPDX-License-Identifier: Apache-2.0
"""Whether what a person asked for is so, by the world's truth: for tests and benchmarks alone.

The mission's own guard reads what the camera measured and takes two sigma off each tolerance. The judge reads the
poses and contacts of the simulation, and adds one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.planning import DESK, JUDGE, Goal, OnTop, Scene, Thing, reached, read_scene
from rai_missions.worlds.desk.truth import DeskTruth, TrueThing

__all__ = ("is_so", "true_names", "true_scene")

SAME_M = 0.08
"""What the camera calls a thing is the thing of the truth that is nearest to it, and so near at the most."""


def true_names(seen: Mapping[str, Any], truth: DeskTruth) -> dict[str, str]:
    """The camera's names → the scene's names, each thing once: the nearest pairs first, then those alone in a class.

    A thing that a person moves between the picture and the truth is known by its class.
    """
    pairs = sorted(
        (math.dist((one.x, one.y, one.z), (true.x, true.y, true.z)), one.name, name)
        for one in read_scene(seen).things
        for name, true in truth.things.items()
    )
    found: dict[str, str] = {}
    for distance_m, name, true in pairs:
        if distance_m <= SAME_M and name not in found and true not in found.values():
            found[name] = true
    rest = [(name, one) for name, one in truth.things.items() if name not in found.values()]
    for one in read_scene(seen).things:
        alike = [name for name, true in rest if (true.kind, true.colour) == (one.type, one.colour)]
        if one.name not in found and len(alike) == 1:
            found[one.name] = alike[0]
    return found


def true_scene(seen: Mapping[str, Any], names: Mapping[str, str], truth: DeskTruth) -> Scene:
    """The things by the camera's names, where they truly are; with the camera's sigma, and with nothing left out."""
    sigmas = {one.name: one.sigma_m for one in read_scene(seen).things}
    called = {true: name for name, true in names.items()}
    things = tuple(
        _thing(called.get(name, f"unseen_{number}"), one, sigmas.get(called.get(name, ""), 0.0))
        for number, (name, one) in enumerate(truth.things.items())
    )
    return Scene(things, "holding" if truth.held else "empty", looks=1, stamp_s=truth.at)


def is_so(goal: Goal, seen: Mapping[str, Any], names: Mapping[str, str], truth: DeskTruth) -> bool:
    """Whether a goal holds truly: each relation within its tolerance plus one sigma, at rest, `on` by contact."""
    if reached(goal, true_scene(seen, names, truth), JUDGE) is not True:
        return False
    touching = [each.on for each in goal.all if isinstance(each, OnTop)]
    return all(
        truth.touch(names.get(upper, upper), DESK if lower == DESK else names.get(lower, lower))
        for upper, lower in touching
    )


def _thing(name: str, true: TrueThing, sigma_m: float) -> Thing:
    kind: Any = true.kind
    return Thing(
        name,
        kind,
        true.x,
        true.y,
        true.z,
        yaw=true.yaw,
        size=true.size,
        sigma_m=sigma_m,
        colour=true.colour,
        looks=1000,
        agreeing=1000,
        at_rest=true.at_rest,
    )

# SPDX-License-Identifier: Apache-2.0
"""Scenes: data with a seed, from which a world is built; which of them are for tuning, and which for reporting.

Rule: `split_of` was fixed before anything was tuned, and reads the seed alone. A rule, a guard, a prompt or the
generator is changed by what scenes of `tune` show; figures are of `report`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.campaign.records import SceneRecord, Split
from rai_missions.campaign.scene_spec import scene_spec
from rai_missions.errors import UsageError
from rai_missions.worlds.house.scene_cases import scene_options as house_scene
from rai_missions.worlds.orchard.scene_cases import scene_options as orchard_scene

__all__ = ("GENERATORS", "scene", "scenes", "split_of")

Drawn = tuple[str, dict[str, Any], dict[str, Any]]
GENERATORS: Mapping[str, Callable[[int], Drawn]] = {
    "orchard": lambda seed: (*orchard_scene(seed), {}),
    "house": house_scene,
}
"""World → from a seed, the kind of what is in the way, the options that the world is built with, and who answers later
questions of a rollout there."""


def split_of(seed: int) -> Split:
    """Even seeds are for tuning, odd ones for reporting.

    The generator takes its cases by multiples of the golden ratio, so both halves hold each case in about its share.
    """
    return "report" if seed % 2 else "tune"


def scene(world: str, seed: int) -> SceneRecord:
    """The scene of a seed; its name is the world and a digest of what it is built from, without the seed of the noise.

    Raises:
        UsageError: No scenes are generated for this world.
    """
    if world not in GENERATORS:
        raise UsageError(f"no scenes are generated for the world {world!r}; there are: {', '.join(GENERATORS)}")
    kind, options, later = GENERATORS[world](seed)
    named = json.dumps({**options, "seed": 0}, sort_keys=True, separators=(",", ":"))
    name = f"{world}-{hashlib.sha256(named.encode()).hexdigest()[:12]}"
    return SceneRecord(name, world, kind, seed, split_of(seed), scene_spec(world, options, later))


def scenes(world: str, count: int, first_seed: int = 0) -> tuple[SceneRecord, ...]:
    """Generated scenes, no two alike; a seed that repeats another's scene is left out.

    Args:
        world: Which world's.
        count: How many.
        first_seed: The first seed, 0 or more.

    Raises:
        UsageError: No scenes are generated for this world, or the numbers are negative.
    """
    if count < 0 or first_seed < 0:
        raise UsageError(f"scenes: count and first_seed are 0 or more, not {count} and {first_seed}")
    found: dict[str, SceneRecord] = {}
    seed = first_seed
    while len(found) < count:
        one = scene(world, seed)
        found.setdefault(one.scene, one)
        seed += 1
    return tuple(found.values())

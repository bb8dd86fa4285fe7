# SPDX-License-Identifier: Apache-2.0
"""The two ways in which the orchard's detector measures agree, so that what was tried without pictures counts."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from rai_missions.worlds import open_world
from rai_missions.worlds.orchard.extents import Extents
from rai_missions.worlds.orchard.sight import GeometrySight, ObstacleMeasures, PixelSight
from rai_missions.worlds.orchard.tractor import NOSE_M, TractorPose

KINDS = ("branch", "log", "crate", "person", "animal", "fallen_tree")
HIGH_M = 0.15
"""How far apart two heights may be: a pixel's percentile is not the highest point of a body."""


def put(world: Any, x: float, y: float) -> TractorPose:
    """Set the tractor somewhere in its alley, looking east."""
    world.data.qpos[world.model.joint("tractor").qposadr[0] :][:2] = x, y
    mujoco.mj_forward(world.model, world.data)
    return TractorPose(x, y, 0.0, 0.0)


@pytest.mark.parametrize(("away_m", "apart_m"), [(2.5, 0.6), (4.5, 0.35), (7.0, 0.35)])
def test_pixels_and_geometry_see_the_same(away_m: float, apart_m: float) -> None:
    """At 2.5 m the near end of what is long lies below the picture."""
    places = [{"kind": kind, "alley": alley, "along": 0.6, "across_m": 0.1} for alley, kind in enumerate(KINDS)]
    world: Any = open_world("orchard", alleys=6, obstacles=places)
    bodies = [int(world.model.body(f"obstacle_{number}").id) for number in range(len(KINDS))]
    extents = Extents(world.model, world.data, bodies)
    pixels, geometry = PixelSight(world.camera, bodies, extents), GeometrySight(extents, len(bodies))
    wrong = {}
    for alley, kind in enumerate(KINDS):
        pose = put(world, 12.0 - NOSE_M - away_m, world.layout.centre_m(alley))
        moment = world.camera.moment(world.data)
        seen, known = (each.seen(moment, world.places, pose) for each in (pixels, geometry))
        assert alley in known, f"{kind} is in the way"
        if seen.keys() != known.keys() or not is_near(seen[alley], known[alley], apart_m):
            wrong[kind] = seen.get(alley), known[alley]
    world.close()
    assert wrong == {}


def is_near(one: ObstacleMeasures, other: ObstacleMeasures, apart_m: float) -> bool:
    return bool(
        abs(one.distance_m - other.distance_m) < apart_m
        and abs(one.height_m - other.height_m) < HIGH_M
        and np.isclose(one.solid_m, other.solid_m)
    )

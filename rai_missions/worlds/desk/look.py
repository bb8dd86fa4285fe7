# SPDX-License-Identifier: Apache-2.0
"""What one look at the desk shows: bodies with their measured poses, and how exact those are.

Rule: how a look came about, from pixels or from rays, makes no difference to those who read it: both have the same
noise, `sigma_m`, by kind and by how much of the thing is in sight.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.desk.catalogue import KINDS

__all__ = ("FEWEST_SHARE", "DeskLook", "Eye", "SeenBody", "SurfacePoints", "sigma_m", "sigma_yaw", "surface_points")

Points = NDArray[np.float64]
Triple = tuple[float, float, float]
FEWEST_SHARE = 0.25
"""The share of what faces a camera that must be in sight for a thing to be detected."""
SIGMA_M: Mapping[str, float] = {
    "cube": 0.0005, "apple": 0.001, "tomato": 0.001, "carrot": 0.001, "corn": 0.001, "tray": 0.001, "bin": 0.001,
}  # fmt: skip
"""Standard deviation of a coordinate of a thing that is wholly in sight, by kind: above what the rendered pictures were
measured to have."""
WHOLE_SHARE = 0.95


class SeenBody(NamedTuple):
    """One thing in a look."""

    body: int
    """Of the model; the detector gives it a class."""
    x: float
    y: float
    z: float
    yaw: float
    share: float
    """Of what faces the camera that sees it best, how much is in sight."""
    sigma_m: float


class DeskLook(Protocol):
    """One moment, from all cameras."""

    bodies: tuple[SeenBody, ...]

    def is_free(self, x: float, y: float, z: float) -> bool:
        """Whether a camera sees what is behind a point, so that nothing solid is there."""


class Eye(Protocol):
    """What looks."""

    def look(self, data: Any, number: int) -> DeskLook:
        """Look at the present moment.

        Args:
            data: The data of the simulation, after a step.
            number: The number of the look; the noise is drawn from it.
        """


class SurfacePoints(NamedTuple):
    """Where a kind's surface is looked for, in its own frame."""

    points: Points
    normals: Points


def sigma_m(kind: str, share: float) -> float:
    """Standard deviation of a measured coordinate, m.

    Of a thing that is hidden in part it is larger: by the share that is hidden, and by its third power, fitted to the
    errors in rendered pictures of crowded desks.
    """
    hidden = max(0.0, WHOLE_SHARE - share) / WHOLE_SHARE
    return SIGMA_M[kind] * (1 + 2 * hidden + 40 * hidden**3)


def sigma_yaw(kind: str, share: float) -> float:
    """Standard deviation of a measured yaw, rad: a shift of one sigma at the end of the long axis."""
    return 2 * sigma_m(kind, share) / KINDS[kind].size[0]


@cache
def surface_points(kind: str) -> SurfacePoints:
    """Points spread over what of a kind can be seen, and their normals."""
    half = np.array(KINDS[kind].size) / 2
    if KINDS[kind].is_container:
        shape = _rim()
    elif kind == "cube":
        shape = _cube()
    else:
        shape = _long_body() if half[0] > 1.5 * half[1] else _round_body()
    outward = np.array(shape.normals)
    return SurfacePoints(np.array(shape.points) * half, outward / np.linalg.norm(outward, axis=1, keepdims=True))


class _Shape(NamedTuple):
    """Points in half sizes of the body, and what is outward there, of any length."""

    points: list[Triple]
    normals: list[Triple]


def _rim() -> _Shape:
    """The upper edge of a container, a little inside its outline."""
    ends = [(u, 0.0, 1.0) for u in (-0.97, 0.97)]
    rim = [(u, v, 1.0) for u in (-0.97, 0.0, 0.97) for v in (-0.96, 0.96)] + ends
    return _Shape(rim, [(0.0, 0.0, 1.0)] * len(rim))


def _cube() -> _Shape:
    """The top and four sides; the middle of the top, and otherwise nothing near an edge."""
    inset = (-0.75, 0.75)
    top = [(0.0, 0.0, 1.0), *((u, v, 1.0) for u in inset for v in inset)]
    ends = [(side, u, w) for side in (-1.0, 1.0) for u in inset for w in inset]
    flanks = [(u, side, w) for side, u, w in ends]
    outward = [(side, 0.0, 0.0) for side, _, _ in ends] + [(0.0, side, 0.0) for _, side, _ in flanks]
    return _Shape([*top, *ends, *flanks], [(0.0, 0.0, 1.0)] * len(top) + outward)


def _long_body() -> _Shape:
    """Rings along a spindle, as a carrot or a corn cob has them."""
    along = (-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75)
    points = [(u, 0.85 * (1 - 0.5 * abs(u)) * v, 0.85 * (1 - 0.5 * abs(u)) * w) for u in along for v, w in _around()]
    return _Shape(points, [(0.0, v, w) for _ in along for v, w in _around()])


def _round_body() -> _Shape:
    """Three rings of a ball."""
    rings = ((-0.6, 0.8), (0.0, 1.0), (0.6, 0.8))
    points = [(along, radius * v, radius * w) for along, radius in rings for v, w in _around()]
    return _Shape(points, [(along, v, w) for along, _ in rings for v, w in _around()])


def _around() -> list[tuple[float, float]]:
    """Eight directions across a long axis."""
    return [(math.cos(turn), math.sin(turn)) for turn in (step * math.pi / 4 for step in range(8))]

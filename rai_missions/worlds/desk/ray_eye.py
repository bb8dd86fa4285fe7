# SPDX-License-Identifier: Apache-2.0
"""A look without pictures: rays from each camera find what is in sight, and the noise model blurs where it is.

Rule: a thing that no ray reaches is not seen, and what is seen has the noise of `look.sigma_m`, the one that the
rendered pictures were measured to have; nothing else of the simulation gets out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.look import FEWEST_SHARE, SeenBody, sigma_m, sigma_yaw, surface_points
from rai_missions.worlds.desk.posture import lean_of, yaw_of
from rai_missions.worlds.desk.scene import CAMERAS

__all__ = ("RayEye", "RayLook")

SEEN_GROUPS = np.array([1, 1, 1, 0, 0, 0], np.uint8)
FARTHEST_M = 3.0
ASPECT = 4 / 3
"""The ratio of a picture's width to its height."""
FACING = 0.2
"""The least cosine between a surface's normal and the way to the camera."""
BEHIND_M = 0.005
"""A ray that goes so much farther than a point within a thing saw through it: the desk is not far behind."""

LEAN_SIGMA = 0.15
"""How far off the pose fitted to a leaning thing is, as a share of its length."""


class RayLook:
    """One moment, as rays find it."""

    def __init__(self, bodies: tuple[SeenBody, ...], model: Any, data: Any) -> None:
        self.bodies = bodies
        self._model, self._data = model, data

    def is_free(self, x: float, y: float, z: float) -> bool:
        return any(self._reaches(name, np.array((x, y, z))) for name in CAMERAS)

    def _reaches(self, camera: str, point: NDArray[np.float64]) -> bool:
        if not in_picture(self._model, self._data, camera, point[None])[0]:
            return False
        start = self._data.camera(camera).xpos
        away = float(np.linalg.norm(point - start))
        toward = (point - start) / away
        reach: float = mujoco.mj_ray(self._model, self._data, start, toward, SEEN_GROUPS, 1, -1, None)
        return reach > away + BEHIND_M


class RayEye:
    """Casts rays at the things.

    Args:
        model: The compiled desk.
        kinds: Body of the model → kind of thing.
        seed: The seed of the noise.
    """

    def __init__(self, model: Any, kinds: Mapping[int, str], seed: int) -> None:
        self._model, self._kinds, self._seed = model, kinds, seed
        self._bodies = np.array(list(kinds), int)
        surfaces = [surface_points(kind) for kind in kinds.values()]
        self._owner = np.repeat(np.arange(len(surfaces)), [len(each.points) for each in surfaces])
        self._points = np.concatenate([each.points for each in surfaces]) if surfaces else np.zeros((0, 3))
        self._normals = np.concatenate([each.normals for each in surfaces]) if surfaces else np.zeros((0, 3))
        self._geom_body = np.append(np.asarray(model.geom_bodyid), -1)

    def look(self, data: Any, number: int) -> RayLook:
        shares = self._shares(data)
        rng = np.random.default_rng((self._seed, number, 11))
        noise = rng.normal(size=(len(self._bodies), 4))
        found = tuple(
            _measured(data, body, kind, float(share), drawn)
            for (body, kind), share, drawn in zip(self._kinds.items(), shares, noise, strict=True)
            if share >= FEWEST_SHARE
        )
        return RayLook(found, self._model, data)

    def _shares(self, data: Any) -> NDArray[np.float64]:
        """How much of each thing the camera sees that sees most of it."""
        turned = data.xmat[self._bodies].reshape(-1, 3, 3)[self._owner]
        points = data.xpos[self._bodies][self._owner] + np.einsum("nij,nj->ni", turned, self._points)
        normals = np.einsum("nij,nj->ni", turned, self._normals)
        best = np.zeros(len(self._bodies))
        for name in CAMERAS:
            best = np.maximum(best, self._from(data, name, points, normals))
        return best

    def _from(
        self, data: Any, camera: str, points: NDArray[np.float64], normals: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        start = data.camera(camera).xpos
        back = start - points
        away = np.linalg.norm(back, axis=1)
        facing = np.flatnonzero(np.einsum("ni,ni->n", back, normals) > FACING * away)
        if not len(facing):
            return np.zeros(len(self._bodies))
        rays = (points[facing] - start) / away[facing, None]
        geoms, reach = np.empty(len(facing), np.int32), np.empty(len(facing))
        mujoco.mj_multiRay(
            self._model, data, start, rays.ravel(), SEEN_GROUPS, 1, -1, geoms, reach, None, len(facing), FARTHEST_M
        )
        owners = self._owner[facing]
        own = (self._geom_body[geoms] == self._bodies[owners]) & in_picture(self._model, data, camera, points[facing])
        asked = np.bincount(owners, minlength=len(self._bodies))
        return np.bincount(owners[own], minlength=len(self._bodies)) / np.maximum(asked, 1)


def in_picture(model: Any, data: Any, camera: str, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether each of the points is within a camera's picture."""
    view = data.camera(camera)
    local = (points - view.xpos) @ view.xmat.reshape(3, 3)
    high = -local[:, 2] * math.tan(math.radians(float(model.camera(camera).fovy[0])) / 2)
    inside: NDArray[np.bool_] = (np.abs(local[:, 1]) < high) & (np.abs(local[:, 0]) < high * ASPECT)
    return inside


def _measured(data: Any, body: int, kind: str, share: float, drawn: NDArray[np.float64]) -> SeenBody:
    axes = data.xmat[body].reshape(3, 3)
    leaning = LEAN_SIGMA * KINDS[kind].size[0] * math.sin(lean_of(kind, axes))
    sigma = math.hypot(sigma_m(kind, share), leaning)
    x, y, z = data.xpos[body] + sigma * drawn[:3]
    yaw = yaw_of(axes) + sigma_yaw(kind, share) * float(drawn[3])
    return SeenBody(body, float(x), float(y), float(z), yaw, share, sigma)

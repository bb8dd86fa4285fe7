# SPDX-License-Identifier: Apache-2.0
"""A look at rendered pictures: each thing's outline and depth, from both cameras, give its pose.

Rule: all that gets out was measured in the pixels of one moment: segmentation and depth with the sensor's noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.camera import Camera, Frame, Sight
from rai_missions.worlds.desk.look import FEWEST_SHARE, SeenBody, sigma_m, surface_points
from rai_missions.worlds.desk.posture import about_z
from rai_missions.worlds.desk.ray_eye import BEHIND_M, FACING
from rai_missions.worlds.desk.scene import CAMERAS
from rai_missions.worlds.desk.silhouette import Fit, fit, outline, project

__all__ = ("DEPTH_NOISE", "PixelEye", "PixelLook")

DEPTH_NOISE = 0.001
"""Standard deviation of a pixel's depth, as a share of it."""
WORLD = (0,)
"""The desk and the floor."""
GOOD_M, LEANING = 0.003, 3.0
GOOD_PX, LOST_M = 0.8, 0.005
"""A fit with larger residuals is trusted less, by so much a pixel: three times what a pixel shows of the desk."""

SPREADS = 2.0
"""What the outlines leave open counts so often."""
MOST_M = 0.1


class CameraView(NamedTuple):
    """One camera's part of a look."""

    frame: Frame
    sight: Sight


class PixelLook:
    """One moment, as the pictures show it."""

    def __init__(self, bodies: tuple[SeenBody, ...], views: tuple[CameraView, ...]) -> None:
        self.bodies = bodies
        self._views = views

    def is_free(self, x: float, y: float, z: float) -> bool:
        return any(_sees_through(view, np.array([[x, y, z]])) for view in self._views)


class PixelEye:
    """Measures the things in the pictures of both cameras.

    Args:
        camera: Its frames are what is measured in.
        kinds: Body of the model → kind of thing.
        seed: The seed of the depth's noise.
    """

    def __init__(self, camera: Camera, kinds: Mapping[int, str], seed: int) -> None:
        self._camera, self._kinds, self._seed = camera, kinds, seed

    def look(self, data: Any, number: int) -> PixelLook:
        moment = self._camera.moment(data)
        views = tuple(self._view(moment, name, (self._seed, number, index)) for index, name in enumerate(CAMERAS))
        found = (self._measured(body, kind, views) for body, kind in self._kinds.items())
        return PixelLook(tuple(one for one in found if one is not None), views)

    def _view(self, moment: Any, name: str, seed: tuple[int, int, int]) -> CameraView:
        frame, sight = self._camera.frame(moment, name)
        noise = np.random.default_rng(seed).standard_normal(frame.depth_m.shape, np.float32)
        return CameraView(Frame(frame.depth_m * (1 + DEPTH_NOISE * noise), frame.body), sight)

    def _measured(self, body: int, kind: str, views: tuple[CameraView, ...]) -> SeenBody | None:
        outlines = [each for view in views if (each := outline(*view, body, WORLD)) is not None]
        if not outlines:
            return None
        found = fit(kind, outlines)
        share = max(_share(body, kind, found, view) for view in views)
        if share < FEWEST_SHARE:
            return None
        doubts = (found.residual_px - GOOD_PX) * LOST_M, (found.gap_m - GOOD_M) * LEANING, found.spread_m * SPREADS
        sigma = min(MOST_M, max(sigma_m(kind, share), *doubts))
        return SeenBody(body, *found[:4], share, sigma)


def _share(body: int, kind: str, found: Fit, view: CameraView) -> float:
    """How much of what faces the camera shows the body."""
    turn = about_z(found.yaw)
    surface = surface_points(kind)
    points, normals = surface.points @ turn.T + np.array(found[:3]), surface.normals @ turn.T
    back = view.sight.position - points
    facing = np.einsum("ni,ni->n", back, normals) > FACING * np.linalg.norm(back, axis=1)
    if not facing.any():
        return 0.0
    lines, columns, inside, _ = _pixels(view, points[facing])
    return float(np.mean(inside & (view.frame.body[lines, columns] == body)))


def _sees_through(view: CameraView, point: NDArray[np.float64]) -> bool:
    lines, columns, inside, depth = _pixels(view, point)
    return bool(inside[0] and view.frame.depth_m[lines[0], columns[0]] > depth[0] + BEHIND_M)


def _pixels(view: CameraView, points: NDArray[np.float64]) -> tuple[Any, Any, Any, NDArray[np.float64]]:
    """Lines and columns of points, whether they are in the picture, and their depth."""
    height, width = view.frame.body.shape
    pixels, depth = project(points, view.sight, (height, width))
    columns, lines = np.floor(pixels).astype(int).T
    inside = (lines >= 0) & (lines < height) & (columns >= 0) & (columns < width)
    return np.clip(lines, 0, height - 1), np.clip(columns, 0, width - 1), inside, depth

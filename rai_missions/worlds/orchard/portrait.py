# SPDX-License-Identifier: Apache-2.0
"""A clean picture of the tractor, for its identity."""

from __future__ import annotations

import io
import math

import mujoco
import numpy as np
from PIL import Image

from rai_missions.worlds.orchard import scene
from rai_missions.worlds.orchard.layout import Layout

__all__ = ("portrait",)


def portrait(width: int = 800, height: int = 600) -> bytes:
    """The tractor on a meadow, front wheels turned a little, as a PNG file.

    Args:
        width, height: Pixels, at most 1280 by 960.
    """
    layout = Layout(1)
    model = scene.build(layout, (), shadows=True, trees=False)
    data = mujoco.MjData(model)
    for wheel in ("fl_steer", "fr_steer"):
        data.joint(wheel).qpos[0] = math.radians(16)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    x, y, _ = layout.home
    camera.lookat = np.array([x + 0.9, y, 1.22])
    camera.distance, camera.azimuth, camera.elevation = 5.6, 152.0, -11.0
    renderer = mujoco.Renderer(model, height, width)
    try:
        renderer.update_scene(data, camera)
        out = io.BytesIO()
        Image.fromarray(renderer.render()).save(out, "PNG", optimize=True)
        return out.getvalue()
    finally:
        renderer.close()

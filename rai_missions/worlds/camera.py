# SPDX-License-Identifier: Apache-2.0
"""A world's cameras: colour, depth and segmentation, rendered when someone looks.

Rule: a picture can be asked for from any thread, and shows the moment at which it was taken, whenever it is rendered.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from rai_missions.image import Image
from rai_missions.worlds.renderers import Renderers

__all__ = ("Camera", "Frame", "Moment", "Sight")

FRONT = "front"
AS_NUMBERS = [int(mujoco.mjtRndFlag.mjRND_SEGMENT), int(mujoco.mjtRndFlag.mjRND_IDCOLOR)]
"""What has each shape drawn in the colour that is its number."""


class Moment(NamedTuple):
    """All that a picture of the world depends on."""

    qpos: NDArray[np.float64]
    mocap_pos: NDArray[np.float64]
    mocap_quat: NDArray[np.float64]


class Frame(NamedTuple):
    """One view in numbers, from one moment."""

    depth_m: NDArray[np.float32]
    """Distance along the camera's axis, a pixel."""
    body: NDArray[np.int32]
    """The body that each pixel shows; -1 is the sky."""


class Sight(NamedTuple):
    """Where the camera is and how wide it looks."""

    position: NDArray[np.float64]
    axes: NDArray[np.float64]
    """Columns: right, up, back."""
    focal_px: float
    """For the height of the frames that it came with."""


class Camera:
    """Renders what a robot's camera sees.

    Args:
        model: The compiled world.
        width, height: Pixels of a colour picture.
        frame_width, frame_height: Pixels of what the detector measures in.
        is_checked: It is known that pictures can be rendered here.
        paint: Gives the model what is only seen, when it is first looked at.
    """

    def __init__(
        self,
        model: Any,
        *,
        width: int = 640,
        height: int = 480,
        frame_width: int = 320,
        frame_height: int = 240,
        is_checked: bool = False,
        paint: Callable[[Any], None] = lambda model: None,
    ) -> None:
        self.width, self.height = width, height
        self.model = model
        self._frame_size = frame_height, frame_width
        self._is_checked = is_checked
        self._scratch = mujoco.MjData(model)
        self._bodies = np.asarray(model.geom_bodyid)
        self._has_fog = any(model.numeric(n).name == "fog" for n in range(model.nnumeric))
        self._paint = paint
        self._renderers = Renderers(model, paint)

    @classmethod
    def aligned(cls, model: Any) -> Camera:
        """A camera whose depth and segmentation are as large as its pictures, pixel by pixel."""
        return cls(model, frame_width=640, frame_height=480)

    def twin(self, model: Any) -> Camera:
        """A camera with pictures of these sizes in another world, with renderers of its own."""
        height, width = self._frame_size
        return Camera(
            model,
            width=self.width,
            height=self.height,
            frame_width=width,
            frame_height=height,
            is_checked=self._is_checked,
            paint=self._paint,
        )

    def check(self) -> None:
        """Make sure that it can render, once; a `UsageError` names what is missing."""
        if not self._is_checked:
            self._renderers.do(self._renderers.check)
            self._is_checked = True

    @property
    def has_rendered(self) -> bool:
        """Whether the camera has made its renderers: something was looked at."""
        return self._renderers.are_made

    def moment(self, data: Any) -> Moment:
        """Keep the present moment, to be rendered later or never."""
        return Moment(data.qpos.copy(), data.mocap_pos.copy(), data.mocap_quat.copy())

    def picture(self, moment: Moment, ref: str) -> Image:
        """A colour picture of a moment; it is rendered when its bytes are asked for."""
        return Image(ref, self.width, self.height, "rgb8", lambda: self.colour(moment).tobytes())

    def colour(self, moment: Moment) -> NDArray[np.uint8]:
        """Pixels (rows, columns, 3)."""
        return self._renderers.do(lambda: self._colour(moment))

    def depth_m(self, moment: Moment) -> NDArray[np.float32]:
        """Distance along the camera's axis in m, as large as a colour picture."""
        return self._renderers.do(lambda: self._depth(moment, (self.height, self.width), FRONT))

    def segmentation(self, moment: Moment) -> NDArray[np.int32]:
        """The body that each pixel shows, as large as a colour picture."""
        return self._renderers.do(lambda: self._segments(moment, (self.height, self.width), FRONT))

    def frame(self, moment: Moment, camera: str = FRONT) -> tuple[Frame, Sight]:
        """Depth and segmentation for measuring, and where they were seen from."""
        return self._renderers.do(lambda: self._measure(moment, camera))

    def close(self) -> None:
        """Free the renderers; a picture that is asked for later makes new ones."""
        self._renderers.close()

    def _at(self, moment: Moment, size: tuple[int, int], camera: str) -> Any:
        scratch = self._scratch
        scratch.qpos[:], scratch.mocap_pos[:], scratch.mocap_quat[:] = moment
        mujoco.mj_kinematics(self.model, scratch)
        mujoco.mj_comPos(self.model, scratch)
        mujoco.mj_camlight(self.model, scratch)
        renderer = self._renderers.of(*size)
        renderer.update_scene(scratch, camera)
        return renderer

    def _render(self, moment: Moment, size: tuple[int, int], camera: str) -> NDArray[Any]:
        pixels: NDArray[Any] = self._at(moment, size, camera).render().copy()
        return pixels

    def _colour(self, moment: Moment) -> NDArray[np.uint8]:
        """With fog, where the model has the number `fog`; what is measured is not fogged."""
        flags = self._renderers.of(self.height, self.width).scene.flags
        flags[mujoco.mjtRndFlag.mjRND_FOG] = self._has_fog
        try:
            return self._render(moment, (self.height, self.width), FRONT)
        finally:
            flags[mujoco.mjtRndFlag.mjRND_FOG] = 0

    def _depth(self, moment: Moment, size: tuple[int, int], camera: str) -> NDArray[np.float32]:
        renderer = self._renderers.of(*size)
        renderer.enable_depth_rendering()
        try:
            return self._render(moment, size, camera)
        finally:
            renderer.disable_depth_rendering()

    def _segments(self, moment: Moment, size: tuple[int, int], camera: str) -> NDArray[np.int32]:
        """The body of each pixel; MuJoCo's renderer finds a kind and a number of each, in four times as long."""
        renderer = self._at(moment, size, camera)
        scene = renderer.scene
        scene.flags[AS_NUMBERS] = 1
        try:
            colours = renderer.render()
        finally:
            scene.flags[AS_NUMBERS] = 0
        numbers = sum(colours[..., n].astype(np.int32) << 8 * n for n in range(-(-scene.ngeom.bit_length() // 8)))
        body_of = np.full(scene.ngeom + 1, -1, np.int32)
        for shape in scene.geoms[: scene.ngeom]:
            if shape.segid >= 0 and shape.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                body_of[shape.segid + 1] = self._bodies[shape.objid]
        bodies: NDArray[np.int32] = body_of[numbers]
        return bodies

    def _measure(self, moment: Moment, camera: str) -> tuple[Frame, Sight]:
        size = self._frame_size
        frame = Frame(self._depth(moment, size, camera), self._segments(moment, size, camera))
        number = self.model.camera(camera).id
        focal = self._frame_size[0] / 2 / math.tan(math.radians(float(self.model.cam_fovy[number])) / 2)
        axes = self._scratch.cam_xmat[number].reshape(3, 3).copy()
        return frame, Sight(self._scratch.cam_xpos[number].copy(), axes, focal)

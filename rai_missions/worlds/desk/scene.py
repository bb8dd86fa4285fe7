# SPDX-License-Identifier: Apache-2.0
"""The desk as one MuJoCo model: floor, table, light, cameras, things, and the arm's parts if there is one.

Rule: the frame is `panda_link0`: x forward over the desk, y to the left, z up, the desk's top at 0. Geom groups: 0 the
desk and the floor, 1 what collides and is seen, 2 what is only seen, 3 what only collides.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from rai_missions.image import png
from rai_missions.worlds.desk import catalogue
from rai_missions.worlds.desk.scene_file import DeskObject

__all__ = ("CAMERAS", "FRONT_FOVY_DEG", "TIMESTEP_S", "Fragment", "build", "object_name", "put", "put_free", "settle")

TIMESTEP_S = 0.002
CAMERAS = ("front", "top")
FRONT_FOVY_DEG = 46
LIFT_M = 0.005
TOUCHING_M = 0.0005
"""A contact that is deeper is one of two things in each other."""
SETTLED_M_S, LONGEST_S = 0.003, 3.0


class Fragment(NamedTuple):
    """What a robot adds to the model; angles in radians."""

    assets: str
    files: Mapping[str, bytes]
    bodies: str
    actuators: str
    extras: str
    """Elements directly below `mujoco`: defaults, tendons, equalities, contacts."""


NO_ARM = Fragment("", {}, "", "", "")


def object_name(number: int) -> str:
    """The name of a thing's body and of its free joint."""
    return f"object_{number}"


def build(objects: Sequence[DeskObject], robot: Fragment = NO_ARM) -> Any:
    """Compile the desk; the things are where they were asked for, in each other or not."""
    listed, files = catalogue.assets()
    bodies = "".join(catalogue.body(object_name(number), one.kind, one.colour) for number, one in enumerate(objects))
    legs = "".join(
        f'<geom type="box" pos="{x} {y} -.395" size=".03 .03 .355" rgba=".3 .3 .32 1"/>'
        for x in (-0.2, 0.95)
        for y in (-0.75, 0.75)
    )
    xml = f"""<mujoco model="desk"><compiler angle="radian" autolimits="true"/>
<option timestep="{TIMESTEP_S}" integrator="implicitfast" cone="elliptic" impratio="10"/>
<visual><global offwidth="1280" offheight="960"/><quality shadowsize="0" offsamples="0"/><map znear=".02" zfar="12"/>
 <headlight ambient=".42 .42 .42" diffuse=".3 .3 .3" specular="0 0 0"/></visual>
<statistic extent="1.2" center=".4 0 .2"/>{robot.extras}
<asset>
 <texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood" specular=".1"/>
 <texture type="skybox" builtin="flat" rgb1=".78 .82 .86" width="16" height="96"/>{listed}{robot.assets}</asset>
<worldbody>
 <light pos=".3 -.7 1.9" dir=".1 .35 -1" diffuse=".45 .45 .43" castshadow="false"/>
 <light pos=".9 .8 1.7" dir="-.3 -.5 -1" diffuse=".2 .2 .2" castshadow="false"/>
 <geom name="floor" type="plane" pos="0 0 -.75" size="4 4 .1" rgba=".6 .61 .63 1"/>
 <geom name="desk" type="box" pos=".38 0 -.02" size=".62 .8 .02" material="wood" friction="1 .01 .001"/>{legs}
 <camera name="front" pos="1.25 0 .75" xyaxes="0 1 0 -.6838 0 .7297" fovy="{FRONT_FOVY_DEG}"/>
 <camera name="top" pos=".5 0 1.3" xyaxes="0 -1 0 1 0 0" fovy="45"/>
 {robot.bodies}{bodies}
</worldbody><actuator>{robot.actuators}</actuator></mujoco>"""
    return mujoco.MjModel.from_xml_string(xml, {**files, **robot.files, "wood.png": _wood()})


def put(data: Any, number: int, position: Sequence[float], yaw: float) -> None:
    """Place a thing, at rest."""
    joint = data.joint(object_name(number))
    joint.qpos[:] = [*position, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
    joint.qvel[:] = 0


def settle(model: Any, data: Any, objects: Sequence[DeskObject]) -> None:
    """Put the things where they were asked for, the lowest first, each lifted out of those below, and let them fall."""
    bodies = [int(model.body(object_name(number)).id) for number in range(len(objects))]
    for number in range(len(objects)):
        put(data, number, (0.0, 2.0 + number, 5.0), 0.0)
    placed: set[int] = {0}
    for number in sorted(range(len(objects)), key=lambda each: (objects[each].z, each)):
        one = objects[number]
        lowest = max(one.z, catalogue.KINDS[one.kind].size[2] / 2)
        put_free(model, data, number, (one.x, one.y, lowest), one.yaw, placed)
        placed.add(bodies[number])
    still = 0
    for _ in range(round(LONGEST_S / TIMESTEP_S / 25)):
        mujoco.mj_step(model, data, 25)
        moving = max(
            (float(np.abs(data.joint(object_name(n)).qvel[:3]).max()) for n in range(len(objects))), default=0.0
        )
        still = still + 1 if moving < SETTLED_M_S else 0
        if still >= 4:
            break
    mujoco.mj_forward(model, data)


def put_free(
    model: Any, data: Any, number: int, position: Sequence[float], yaw: float, among: Collection[int] | None = None
) -> None:
    """Place a thing at a position, or above it, so that it is in nothing else.

    Args:
        model, data: The simulation.
        number: The number of the thing.
        position: Of its middle, the lowest.
        yaw: How it is turned.
        among: Bodies that it may be in; None: all.
    """
    body = int(model.body(object_name(number)).id)
    x, y, z = position
    put(data, number, (x, y, z), yaw)
    while _is_inside(model, data, body, among):
        z += LIFT_M
        put(data, number, (x, y, z), yaw)


def _is_inside(model: Any, data: Any, body: int, among: Collection[int] | None) -> bool:
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    for contact in data.contact[: data.ncon]:
        pair = {int(model.geom_bodyid[contact.geom[0]]), int(model.geom_bodyid[contact.geom[1]])}
        others = pair - {body}
        if body in pair and contact.dist < -TOUCHING_M and (among is None or others <= set(among)):
            return True
    return False


def _wood() -> bytes:
    """A table of light wood, its grain along y."""
    size = 256
    rng = np.random.default_rng(9)
    grain = np.zeros((size, size))
    for waves, weight in ((4, 0.4), (16, 0.3), (64, 0.2)):
        line = np.interp(np.linspace(0, waves, size), np.arange(waves + 1), rng.random(waves + 1))
        bend = np.interp(np.linspace(0, 3, size), np.arange(4), rng.random(4)) * size / 16
        shifted = (np.arange(size)[None, :] + bend[:, None]).astype(int) % size
        grain += weight * line[shifted]
    pixels: NDArray[np.float64] = np.stack([176 + 44 * grain, 142 + 40 * grain, 104 + 34 * grain], -1)
    return png(size, size, np.clip(pixels, 0, 255).astype(np.uint8).tobytes())

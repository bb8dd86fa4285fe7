# SPDX-License-Identifier: Apache-2.0
"""The robot: a skid-steered base of the size of a ROSbot XL, as a MuJoCo model, and the commands that move it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rai_missions.worlds.house.layout import NamedPose

__all__ = (
    "ACTUATORS", "BODY_M", "CAMERA_AT", "CAMERA_FOVY_DEG", "CAMERA_PITCH", "LIDAR_AT", "OUTLINE_M", "RADIUS_M",
    "RobotPose", "Rosbot", "body",
)  # fmt: skip

WHEEL_M, TRACK_M = 0.048, 0.27
SKID = 1.55
"""How much wider a skid-steered base turns than its track reports, on this floor."""
RADIUS_M = 0.2
"""The radius of the circle around the robot."""
OUTLINE_M = 0.15, 0.16
"""Half as long and half as wide as it is, wheels included."""
FASTEST_MPS, FASTEST_RADPS = 0.5, 1.8
PULL_MPS2, TWIST_RADPS2 = 1.0, 6.0
"""How quickly the commanded speeds change."""
WHEELS = {"fl": (0.085, 0.135), "fr": (0.085, -0.135), "rl": (-0.085, 0.135), "rr": (-0.085, -0.135)}
BODY_M = 0.048
"""How high the body's origin is when it stands on its wheels."""
CAMERA_AT = 0.14, 0.15
"""Where the camera is: m ahead of the body's origin, and above it."""
LIDAR_AT = -0.02, 0.175
"""Where the lidar is, in the same way."""
CAMERA_PITCH, CAMERA_FOVY_DEG = 0.1, 58
"""How far it looks up (rad), so that it sees what is on a table, and how high its picture is."""
GHOST = 'contype="0" conaffinity="0" mass=".01"'

ACTUATORS = "".join(f'<velocity name="{name}" joint="{name}" kv="1.2" forcerange="-3 3"/>' for name in WHEELS)


class RobotPose(NamedTuple):
    """Where the robot is, and how it moves."""

    x: float
    y: float
    heading: float
    """rad, 0 looks along x, counter-clockwise."""
    speed: float
    """m/s ahead."""
    turn: float
    """rad/s, counter-clockwise."""


def body(start: NamedPose) -> str:
    """The robot's MJCF: base, lidar, camera and wheels."""
    wheels = "".join(
        f'<body name="{name}" pos="{x} {y} 0"><joint name="{name}" axis="0 1 0" damping=".02" armature=".005"/>'
        f'<geom type="ellipsoid" size="{WHEEL_M} .024 {WHEEL_M}" mass=".25" friction=".8 .005 .0001" condim="3" '
        f'group="3"/><geom type="cylinder" euler="90 0 0" size="{WHEEL_M} .019" rgba=".08 .08 .08 1" group="2" '
        f"{GHOST}/></body>"
        for name, (x, y) in WHEELS.items()
    )
    return f"""<body name="rosbot" pos="{start.x} {start.y} .05" euler="0 0 {math.degrees(start.heading)}">
<freejoint name="rosbot"/>
<geom type="box" size=".15 .105 .05" pos="0 0 .03" rgba=".12 .12 .13 1" mass="4" group="2"/>
<geom type="box" size=".145 .13 .008" pos="0 0 .09" rgba=".7 .08 .1 1" mass=".5" group="2"/>
<geom type="cylinder" size=".038 .02" pos="-.02 0 .165" rgba=".05 .05 .05 1" group="2" {GHOST}/>
<geom type="cylinder" size=".012 .03" pos="-.02 0 .12" rgba=".3 .3 .3 1" group="2" {GHOST}/>
<geom type="box" size=".012 .045 .012" pos=".12 0 .15" rgba=".6 .6 .62 1" group="2" {GHOST}/>
<site name="laser" pos="{LIDAR_AT[0]} 0 {LIDAR_AT[1]}"/>
<camera name="front" pos="{CAMERA_AT[0]} 0 {CAMERA_AT[1]}" xyaxes="0 -1 0 {-math.tan(CAMERA_PITCH):.4f} 0 1"
 fovy="{CAMERA_FOVY_DEG}"/>{wheels}</body>"""


class Rosbot:
    """The robot in one simulation.

    Args:
        model: The compiled house.
        data: Its state.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._data = data
        self.body_id = model.body("rosbot").id
        self._left = [model.actuator(name).id for name in ("fl", "rl")]
        self._right = [model.actuator(name).id for name in ("fr", "rr")]
        self._first_dof = model.joint("rosbot").dofadr[0]
        self._rolls = [model.joint(name).dofadr[0] for name in WHEELS]
        self._speed = self._turn = 0.0

    @property
    def pose(self) -> RobotPose:
        x, y, _ = self._data.xpos[self.body_id]
        ahead = self._data.xmat[self.body_id][[0, 3]]
        velocity = self._data.qvel[self._first_dof : self._first_dof + 6]
        heading = math.atan2(ahead[1], ahead[0])
        return RobotPose(float(x), float(y), heading, float(velocity[:2] @ ahead), float(velocity[5]))

    @property
    def power_w(self) -> float:
        """What the motors give to the wheels."""
        return float(np.abs(self._data.actuator_force * self._data.qvel[self._rolls]).sum())

    def command(self, speed: float, turn: float, period_s: float) -> None:
        """Drive so fast (m/s) and turn so fast (rad/s), as quickly as the motors follow."""
        speed = max(-FASTEST_MPS, min(FASTEST_MPS, speed))
        turn = max(-FASTEST_RADPS, min(FASTEST_RADPS, turn))
        pull, twist = PULL_MPS2 * period_s, TWIST_RADPS2 * period_s
        self._speed += max(-pull, min(pull, speed - self._speed))
        self._turn += max(-twist, min(twist, turn - self._turn))
        apart = self._turn * TRACK_M * SKID / 2
        self._data.ctrl[self._left] = (self._speed - apart) / WHEEL_M
        self._data.ctrl[self._right] = (self._speed + apart) / WHEEL_M

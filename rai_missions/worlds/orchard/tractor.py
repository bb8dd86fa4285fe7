# SPDX-License-Identifier: Apache-2.0
"""The tractor: its body, wheels and drive as a MuJoCo model, and the commands that move it.

The body's origin lies on the ground below the middle of the rear axle; x points ahead, y to the left, z up.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rai_missions.worlds.meshes import Mesh, turned

__all__ = ("ACTUATORS", "CONTACT", "NOSE_M", "TAIL_M", "Tractor", "TractorPose", "body", "meshes")

WHEELBASE_M, TRACK_M, FRONT_TRACK_M = 2.0, 1.7, 1.5
REAR_RADIUS_M, FRONT_RADIUS_M = 0.78, 0.5
NOSE_M, TAIL_M = 2.45, 0.85
"""From the rear axle to the foremost and the hindmost point."""
FASTEST_TURN = 1 / 1.9
"""The tightest curvature that the front wheels can steer, 1/m."""
PULL_MPS2 = 1.0
"""How quickly the commanded speed changes."""

ACTUATORS = """
<velocity name="drive_l" joint="rl_roll" kv="4000" forcerange="-6000 6000"/>
<velocity name="drive_r" joint="rr_roll" kv="4000" forcerange="-6000 6000"/>
<position name="steer_l" joint="fl_steer" kp="20000" forcerange="-5000 5000"/>
<position name="steer_r" joint="fr_steer" kp="20000" forcerange="-5000 5000"/>"""

CONTACT = """
<exclude body1="tractor" body2="rl"/><exclude body1="tractor" body2="rr"/>
<exclude body1="tractor" body2="fl_hub"/><exclude body1="tractor" body2="fr_hub"/>"""
"""Wheels do not rub on the body that carries them."""

GHOST = 'contype="0" conaffinity="0" mass="0"'


class TractorPose(NamedTuple):
    """Where the tractor is: the middle of the rear axle, and how fast it goes ahead."""

    x: float
    y: float
    heading: float
    """rad, 0 looks along x, counter-clockwise."""
    speed: float
    """m/s; negative backwards."""


class Tractor:
    """The tractor in one simulation.

    Args:
        model: The compiled orchard.
        data: Its state.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._data = data
        self.body_id = model.body("tractor").id
        self._drive = [model.actuator(name).id for name in ("drive_l", "drive_r")]
        self._steer = [model.actuator(name).id for name in ("steer_l", "steer_r")]
        self._first_dof = model.joint("tractor").dofadr[0]
        self._rolls = [model.joint(name).dofadr[0] for name in ("rl_roll", "rr_roll")]
        self._wheels = [model.body(name).id for name in ("rl", "rr", "fl", "fr")]
        self._rest = np.array([REAR_RADIUS_M] * 2 + [FRONT_RADIUS_M] * 2)
        self._speed = self._trim = 0.0

    @property
    def pose(self) -> TractorPose:
        x, y, _ = self._data.xpos[self.body_id]
        ahead = self._data.xmat[self.body_id][[0, 3]]
        velocity = self._data.qvel[self._first_dof : self._first_dof + 2]
        return TractorPose(float(x), float(y), math.atan2(ahead[1], ahead[0]), float(velocity @ ahead))

    @property
    def tilt_deg(self) -> tuple[float, float]:
        """Pitch and roll."""
        turn = self._data.xmat[self.body_id].reshape(3, 3)
        pitch = math.asin(max(-1.0, min(1.0, -turn[2, 0])))
        return math.degrees(pitch), math.degrees(math.atan2(turn[2, 1], turn[2, 2]))

    @property
    def lift_m(self) -> float:
        """How far the highest wheel is above where it stands on flat ground."""
        return float(np.max(self._data.xpos[self._wheels, 2] - self._rest))

    @property
    def power_w(self) -> float:
        """What the drive takes, without losses; braking gives nothing back."""
        return float(np.sum(np.abs(self._data.actuator_force[self._drive] * self._data.qvel[self._rolls])))

    def command(self, speed: float, curvature: float, period_s: float) -> None:
        """Go towards a speed (m/s) on a curvature (1/m, left positive); wheels turn as Ackermann's do."""
        change = PULL_MPS2 * period_s
        self._trim = (
            0.0 if speed == 0 else max(-1.0, min(1.0, self._trim + 0.8 * period_s * (self._speed - self.pose.speed)))
        )
        self._speed += max(-change, min(change, speed - self._speed))
        bend = max(-FASTEST_TURN, min(FASTEST_TURN, curvature))
        for side, drive, steer in ((-1, self._drive[0], self._steer[0]), (1, self._drive[1], self._steer[1])):
            self._data.ctrl[drive] = (self._speed + self._trim) * (1 + side * bend * TRACK_M / 2) / REAR_RADIUS_M
            self._data.ctrl[steer] = math.atan2(bend * WHEELBASE_M, 1 + side * bend * FRONT_TRACK_M / 2)


def meshes() -> dict[str, Mesh]:
    """The tractor's meshes by name."""
    return {
        "rear_tyre": _tyre(REAR_RADIUS_M, 0.42, 22),
        "front_tyre": _tyre(FRONT_RADIUS_M, 0.30, 18),
        "bonnet": _bonnet(),
        "mudguard": _mudguard(),
    }


def body(x: float, y: float, heading: float) -> str:
    """The tractor's MJCF, standing at a place (m, rad)."""
    return f"""<body name="tractor" pos="{x} {y} 0.02" euler="0 0 {math.degrees(heading)}"><freejoint name="tractor"/>
 <camera name="front" pos="2.5 0 1.75" xyaxes="0 -1 0 .12 0 .99" fovy="55"/>
 <geom name="chassis" type="box" pos=".9 0 .85" size="1.5 .28 .22" mass="2000" rgba=".13 .13 .13 1" group="2"/>
 <geom name="engine" type="box" pos="1.55 0 1.25" size=".85 .36 .26" mass="300" group="5"/>
 <geom name="cab" type="box" pos="0 0 1.35" size=".65 .62 .3" mass="300" material="paint" group="2"/>
 <geom name="axle" type="box" pos="2 0 .58" size=".12 .6 .08" mass="60" rgba=".13 .13 .13 1" group="2"/>
 <geom type="mesh" mesh="bonnet" material="paint" {GHOST} group="2"/>
 <geom type="box" pos="2.405 0 1.2" size=".025 .29 .23" rgba=".09 .09 .1 1" {GHOST} group="2"/>
 {"".join(_slat(z) for z in (1.06, 1.14, 1.22, 1.30))}
 {"".join(_lamp(y) for y in (0.24, -0.24))}
 <geom type="cylinder" pos="1.5 .3 1.8" size=".035 .38" rgba=".22 .22 .23 1" {GHOST} group="2"/>
 <geom type="cylinder" pos="1.5 .3 1.62" size=".06 .16" rgba=".3 .3 .31 1" {GHOST} group="2"/>
 <geom type="box" pos="-.02 0 2.62" size=".76 .72 .05" material="paint" mass="40" group="2"/>
 <geom type="box" pos="-.02 0 2.7" size=".6 .58 .035" material="paint" {GHOST} group="2"/>
 <geom type="cylinder" pos="-.3 0 2.79" size=".07 .07" rgba="1 .5 0 1" {GHOST} group="2"/>
 {"".join(_post(x, y) for x in (-0.6, 0.58) for y in (-0.57, 0.57))}
 {_glass(0.0, 0.58, 0.56, 0.005)}{_glass(0.0, -0.58, 0.56, 0.005)}{_glass(0.6, 0.0, 0.005, 0.54)}
 <geom type="box" pos="-.25 0 1.72" size=".22 .24 .08" rgba=".1 .1 .1 1" {GHOST} group="2"/>
 <geom type="box" pos="-.45 0 2.0" size=".06 .22 .26" rgba=".1 .1 .1 1" {GHOST} group="2"/>
 <geom type="mesh" mesh="mudguard" pos="0 .85 .78" material="paint" {GHOST} group="2"/>
 <geom type="mesh" mesh="mudguard" pos="0 -.85 .78" material="paint" {GHOST} group="2"/>
 <geom type="box" pos="2.49 0 1.66" size=".04 .07 .04" rgba=".05 .05 .05 1" {GHOST} group="2"/>
 <geom type="cylinder" pos="2.42 0 1.56" size=".02 .1" rgba=".3 .3 .3 1" {GHOST} group="2"/>
 {_wheel("rl", 0, 0.85, REAR_RADIUS_M, 0.42, False)}{_wheel("rr", 0, -0.85, REAR_RADIUS_M, 0.42, False)}
 {_wheel("fl", 2.0, 0.75, FRONT_RADIUS_M, 0.3, True)}{_wheel("fr", 2.0, -0.75, FRONT_RADIUS_M, 0.3, True)}
</body>"""


def _slat(z: float) -> str:
    return f'<geom type="box" pos="2.435 0 {z}" size=".006 .25 .012" rgba=".32 .33 .34 1" {GHOST} group="2"/>'


def _lamp(y: float) -> str:
    return (
        f'<geom type="cylinder" pos="2.43 {y} 1.4" euler="0 90 0" size=".075 .02" rgba="1 1 .85 1" {GHOST} group="2"/>'
        f'<geom type="cylinder" pos="2.42 {y} 1.4" euler="0 90 0" size=".09 .02" rgba=".2 .2 .2 1" {GHOST} group="2"/>'
    )


def _post(x: float, y: float) -> str:
    return f'<geom type="box" pos="{x} {y} 2.1" size=".035 .035 .48" rgba=".1 .1 .1 1" mass="3" group="2"/>'


def _glass(x: float, y: float, half_x: float, half_y: float) -> str:
    return f'<geom type="box" pos="{x} {y} 2.1" size="{half_x} {half_y} .44" rgba=".6 .75 .85 .3" {GHOST} group="2"/>'


def _wheel(name: str, x: float, y: float, radius: float, width: float, steers: bool) -> str:
    """A wheel: an ellipsoid meets the ground, a mesh is seen."""
    tyre = "front_tyre" if steers else "rear_tyre"
    roll = f"""<joint name="{name}_roll" axis="0 1 0" damping="20" armature="10"/>
 <geom class="tyre" name="{name}_tyre" type="ellipsoid" size="{radius} {width * 0.9} {radius}" mass="120" group="5"/>
 <geom type="mesh" mesh="{tyre}" rgba=".075 .075 .08 1" {GHOST} group="2"/>
 <geom type="cylinder" euler="90 0 0" size="{radius * 0.58} {width * 0.3}" rgba=".93 .76 .1 1" {GHOST} group="2"/>
 <geom type="cylinder" euler="90 0 0" size="{radius * 0.2} {width * 0.42}" rgba=".55 .45 .1 1" {GHOST} group="2"/>
 {"".join(_bolt(radius, width, turn) for turn in range(6))}"""
    if not steers:
        return f'<body name="{name}" pos="{x} {y} {radius}">{roll}</body>'
    return f"""<body name="{name}" pos="{x} {y} {radius}">
 <joint name="{name}_steer" axis="0 0 1" range="-62 62" damping="800" armature="20"/>
 <inertial pos="0 0 0" mass="20" diaginertia="1 1 1"/><body name="{name}_hub">{roll}</body></body>"""


def _bolt(radius: float, width: float, turn: int) -> str:
    x, z = radius * 0.33 * math.cos(turn * math.pi / 3), radius * 0.33 * math.sin(turn * math.pi / 3)
    size = f"{radius * 0.05} {width * 0.36}"
    return (
        f'<geom type="cylinder" pos="{x:.3f} 0 {z:.3f}" euler="90 0 0" size="{size}" rgba=".3 .26 .1 1" {GHOST}'
        ' group="2"/>'
    )


def _tyre(radius: float, width: float, lugs: int) -> Mesh:
    """A tyre with slanted lugs, open in the middle for its rim."""
    half, r = width / 2, radius * 0.95
    profile = [(-half * 0.75, r * 0.6), (-half, r * 0.8), (-half * 0.85, r * 0.97), (0, r), (half * 0.85, r * 0.97)]
    tyre = turned([*profile, (half, r * 0.8), (half * 0.75, r * 0.6)], 26)
    for lug in range(2 * lugs):
        side = 1 if lug % 2 else -1
        _add_lug(tyre, math.pi * lug / lugs, side, radius, half)
    return tyre


def _add_lug(tyre: Mesh, turn: float, side: int, radius: float, half: float) -> None:
    swept, thick, low = turn + 0.22, 0.085, radius * 0.9

    def at(angle: float, y: float, r: float) -> list[float]:
        return [r * math.cos(angle), y, r * math.sin(angle)]

    inner, outer = -0.04 * side, side * half * 1.0
    corners = np.array(
        [at(turn + d, inner, r) for r in (low, radius) for d in (-thick / 2, thick / 2)]
        + [at(swept + d, outer, r) for r in (low * 0.97, radius * 0.97) for d in (-thick / 2, thick / 2)]
    )
    quads = [(2, 3, 7, 6), (0, 2, 6, 4), (3, 1, 5, 7), (4, 6, 7, 5)]
    tyre.flat_faces(corners, quads if side < 0 else [tuple(reversed(quad)) for quad in quads])


def _bonnet() -> Mesh:
    """The bonnet: a box with a sloping, chamfered top."""

    def ring(x: float, top: float) -> list[tuple[float, float, float]]:
        return [
            (x, -0.36, 0.98),
            (x, -0.36, top - 0.1),
            (x, -0.26, top),
            (x, 0.26, top),
            (x, 0.36, top - 0.1),
            (x, 0.36, 0.98),
        ]

    corners = np.array(ring(0.62, 1.60) + ring(2.1, 1.52) + ring(2.4, 1.46))
    quads = [(k, k + 1, k + 7, k + 6) for k in (0, 1, 2, 3, 4, 6, 7, 8, 9, 10)]
    return Mesh().flat_faces(corners, [*(tuple(reversed(quad)) for quad in quads), (12, 17, 14, 13), (14, 17, 16, 15)])


def _mudguard() -> Mesh:
    """An arch over a rear wheel, seen from both sides."""
    turns = np.radians(np.linspace(10, 165, 9))
    arch = np.array([[0.9 * np.cos(t), y, 0.9 * np.sin(t)] for t in turns for y in (-0.24, 0.24)])
    quads = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(8)]
    return Mesh().flat_faces(arch, [*quads, *(tuple(reversed(quad)) for quad in quads)])

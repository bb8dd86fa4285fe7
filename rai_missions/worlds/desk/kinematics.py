# SPDX-License-Identifier: Apache-2.0
"""Where the gripper is for given joints, and which joints bring it to a pose.

Rule: poses are of the TCP in the frame `panda_link0`, with the fingers' closing direction horizontal; a hand that
cannot reach a place from straight above leans about that direction.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.desk.panda.model import HOME, JOINTS, LOWER, TCP, UPPER, bodies

__all__ = ("TILTS", "Joints", "Kinematics", "ToolPose", "Unreachable", "rotation", "tool_pose", "toward")

Joints = NDArray[np.float64]
"""Seven angles, rad."""
DAMPING = 1e-3
"""The damping of the least squares, (m or rad)²: converges in few steps, and is enough next to singularities."""
ROUNDS = 40
CLOSE_M, CLOSE_RAD = 2e-4, 2e-3
"""How exactly a pose is reached."""
MARGIN_RAD = 0.03
"""From the joints' limits."""
STEP_RAD = 0.4
"""Most that a joint turns in one round."""
TILTS = tuple(math.radians(degrees) for degrees in (0, 12, -12, 24, -24, 36, -36, 48))
"""Leans that are tried, smallest first, rad."""


class ToolPose(NamedTuple):
    """A pose of the TCP."""

    x: float
    y: float
    z: float
    yaw: float
    """Direction in which the fingers close, rad from y, counter-clockwise; half a turn more is the same grasp."""
    tilt: float = 0.0
    """How far the hand leans about that direction, rad; positive: the finger tips point away from the base where the
    fingers close along y."""

    def at(self, *, z: float) -> ToolPose:
        return self._replace(z=z)


class Unreachable(Exception):
    """No joints bring the gripper to a pose; the text states which pose and what the limit is."""


def rotation(yaw: float, tilt: float) -> NDArray[np.float64]:
    """The orientation of the TCP: columns are the hand's x, the closing direction y, and the approach z."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    lean, upright = math.sin(tilt), math.cos(tilt)
    ahead = np.array([cos, sin, 0.0])
    closing = np.array([sin, -cos, 0.0])
    approach = lean * ahead + np.array([0.0, 0.0, -upright])
    return np.column_stack([np.cross(closing, approach), closing, approach])


def tool_pose(position: NDArray[np.float64], turn: NDArray[np.float64]) -> ToolPose:
    """The pose of a TCP with that position and orientation; the closing direction is taken as horizontal."""
    yaw = math.atan2(turn[0, 1], -turn[1, 1])
    lean = math.atan2(turn[0, 2] * math.cos(yaw) + turn[1, 2] * math.sin(yaw), -turn[2, 2])
    x, y, z = position.tolist()
    return ToolPose(x, y, z, yaw, lean)


class Kinematics:
    """Kinematics of the arm alone: a model without meshes, so that it costs the same however full the desk is."""

    def __init__(self) -> None:
        xml = f'<mujoco><compiler angle="radian"/><worldbody>{bodies(hulls=False)}</worldbody></mujoco>'
        self._model: Any = mujoco.MjModel.from_xml_string(xml)
        self._data = mujoco.MjData(self._model)
        self._site = self._model.site(TCP).id
        self._addresses = [int(self._model.joint(name).qposadr[0]) for name in JOINTS]
        self._jacobian = np.zeros((6, self._model.nv))
        self._lower, self._upper = np.array(LOWER) + MARGIN_RAD, np.array(UPPER) - MARGIN_RAD

    def place(self, joints: Joints) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position (m) and orientation (3 × 3) of the TCP."""
        self._data.qpos[self._addresses] = joints
        mujoco.mj_kinematics(self._model, self._data)
        return self._data.site_xpos[self._site].copy(), self._data.site_xmat[self._site].reshape(3, 3).copy()

    def pose(self, joints: Joints) -> ToolPose:
        """The pose of the TCP; the closing direction is taken as horizontal."""
        return tool_pose(*self.place(joints))

    def solve(self, pose: ToolPose, near: Joints) -> Joints | None:
        """The joints that reach a pose, by damped least squares from others; None where they do not.

        dq = Jᵀ(JJᵀ + λI)⁻¹e (Wampler, "Manipulator inverse kinematic solutions based on vector formulations and
        damped least-squares methods", 1986).
        """
        joints = np.clip(near, self._lower, self._upper)
        wanted_at, wanted_turn = np.array(pose[:3]), rotation(pose.yaw, pose.tilt)
        data, jacobian, error = self._data, self._jacobian, np.empty(6)
        for _ in range(ROUNDS):
            data.qpos[self._addresses] = joints
            mujoco.mj_kinematics(self._model, data)
            error[:3] = wanted_at - data.site_xpos[self._site]
            error[3:] = _turn_between(data.site_xmat[self._site].reshape(3, 3), wanted_turn)
            if np.max(abs(error[:3])) < CLOSE_M and np.max(abs(error[3:])) < CLOSE_RAD:
                return joints
            mujoco.mj_comPos(self._model, data)
            mujoco.mj_jacSite(self._model, data, jacobian[:3], jacobian[3:], self._site)
            turns = jacobian[:, :7]
            step = turns.T @ np.linalg.solve(turns @ turns.T + DAMPING * np.eye(6), error)
            joints = np.clip(joints + np.clip(step, -STEP_RAD, STEP_RAD), self._lower, self._upper)
        return None

    def reach(self, pose: ToolPose, near: Joints | None = None) -> Joints:
        """The joints that reach a pose from afar, begun at home turned towards it, or at others.

        Raises:
            Unreachable: None do.
        """
        for start in ([near] if near is not None else []) + [toward(pose)]:
            found = self.solve(pose, start)
            if found is not None:
                return found
        far = math.hypot(pose.x, pose.y)
        raise Unreachable(
            f"the gripper cannot reach ({pose.x:.3f}, {pose.y:.3f}, {pose.z:.3f}) m, {far:.2f} m from the base, "
            f"leaning by {math.degrees(pose.tilt):.0f} degrees"
        )


def toward(pose: ToolPose) -> Joints:
    """A posture to begin at: the elbow up, the base and the wrist turned to the pose."""
    azimuth = math.atan2(pose.y, pose.x)
    joints = np.array(HOME)
    joints[:6] = azimuth, 0.1, 0.0, -2.2, 0.0, 2.3
    turn = pose.yaw - azimuth
    joints[6] = HOME[6] - math.remainder(turn, math.pi)
    return joints


def _turn_between(present: NDArray[np.float64], wanted: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation from one orientation to another, as axis times angle (rad); exact up to half a turn."""
    difference = wanted @ present.T
    axis = np.array(
        [
            difference[2, 1] - difference[1, 2],
            difference[0, 2] - difference[2, 0],
            difference[1, 0] - difference[0, 1],
        ]
    )
    sine = float(np.linalg.norm(axis)) / 2
    angle = math.atan2(sine, (float(np.trace(difference)) - 1) / 2)
    return axis / 2 if sine < 1e-9 else axis * (angle / (2 * sine))

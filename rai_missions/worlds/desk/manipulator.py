# SPDX-License-Identifier: Apache-2.0
"""Upstream's service that moves the manipulator: rai_interfaces/srv/ManipulatorMoveTo.

Its target is a pose of the flange (`panda_link8`), as upstream's tools send it. It is answered when the arm is there,
which takes simulated time: at once it is answered only where it is refused. Upstream's response has no word for why.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rai_missions.connectors.connector import Data
from rai_missions.redaction import logger
from rai_missions.worlds.desk.kinematics import ToolPose, tool_pose
from rai_missions.worlds.desk.motion import Motion
from rai_missions.worlds.desk.posture import about_z
from rai_missions.worlds.goal_server import Later

__all__ = ("MOVE_TO", "ManipulatorMoveTo")

log = logger(__name__)

MOVE_TO = "/manipulator_move_to", "rai_interfaces/srv/ManipulatorMoveTo"
FRAMES = ("", "panda_link0", "world")
TCP_M, TCP_TURN = 0.1034, -math.pi / 4
"""From the flange to the TCP: along its z, and about it."""
LEVEL = 0.1
"""How far from the horizontal the fingers may close, as a sine."""


class ManipulatorMoveTo:
    """The service over the arm's motion.

    Args:
        motion: The arm's.
        later: Answers go out through it.
    """

    LEADS_OUT: ClassVar = {"_pending": lambda: None}

    def __init__(self, motion: Motion, later: Later) -> None:
        self._motion, self._later = motion, later
        self._pending: Future[Data] | None = None

    def answer(self, request: Data) -> dict[str, Any] | Future[Data]:
        """Begin what is asked for; the future is set when it has ended."""
        pose = "the arm is busy" if self._motion.is_busy else _target(request.get("target_pose"))
        if isinstance(pose, str):
            log.warning("%s is refused: %s", MOVE_TO[0], pose)
            return {"success": False}
        before, after = (
            "open" if request.get(field) else "closed" for field in ("initial_gripper_state", "final_gripper_state")
        )
        self._motion.begin(self._motion.move(pose, before=before, after=after))
        self._pending = Future()
        return self._pending

    def step(self) -> None:
        """Answer, if the arm has come to its end."""
        pending, ending = self._pending, self._motion.ending
        if pending is None or ending is None:
            return
        self._pending = None
        if ending.end != "succeeded":
            log.warning("%s: %s", MOVE_TO[0], ending.message)
        self._later(lambda: pending.set_result({"success": ending.end == "succeeded"}))


def _target(stamped: Any) -> ToolPose | str:
    """The TCP's pose for the flange's geometry_msgs/msg/PoseStamped, or what is wrong with it."""
    if not isinstance(stamped, Mapping):
        return "there is no 'target_pose'"
    frame = (stamped.get("header") or {}).get("frame_id", "")
    if frame not in FRAMES:
        return f"the target is in the frame '{frame}'; there is: panda_link0"
    pose = stamped.get("pose") or {}
    position = np.array([float((pose.get("position") or {}).get(axis, 0.0)) for axis in "xyz"])
    turn = np.array([float((pose.get("orientation") or {}).get(axis, 0.0)) for axis in "xyzw"])
    length = float(np.linalg.norm(turn))
    if not (np.isfinite(position).all() and math.isfinite(length)) or length < 1e-6:
        return "the target is not a finite pose with an orientation"
    flange = _matrix(*(turn / length))
    tcp = flange @ about_z(TCP_TURN)
    if abs(tcp[2, 1]) > LEVEL or tcp[2, 2] > -0.5:
        return "the target has the hand turned away from the desk; its z axis is to point down"
    return tool_pose(position + TCP_M * flange[:, 2], tcp)


def _matrix(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    """The rotation of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )

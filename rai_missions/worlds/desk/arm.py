# SPDX-License-Identifier: Apache-2.0
"""The arm as the desk's world has it: its place in the model, its control, its topics and its actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.connectors.connector import Answer
from rai_missions.worlds import messages
from rai_missions.worlds.desk.actions import MOVE, PICK, PLACE, ArmServer, MoveArm, PickAt, PlaceAt
from rai_missions.worlds.desk.kinematics import Kinematics
from rai_missions.worlds.desk.manipulator import MOVE_TO, ManipulatorMoveTo
from rai_missions.worlds.desk.motion import Motion
from rai_missions.worlds.desk.panda.drive import PandaDrive
from rai_missions.worlds.desk.panda.model import FINGER_JOINTS, JOINTS
from rai_missions.worlds.publish_queue import Outbox

__all__ = ("TOPICS", "Arm")

GRIPPER, JOINT_STATES = "gripper", "joint_states"
TOPICS: Mapping[str, str] = {
    GRIPPER: "std_msgs/msg/String",
    JOINT_STATES: "sensor_msgs/msg/JointState",
}
"""What is published, and its types."""
PUBLISHED_S = 0.1


class Arm:
    """The arm of one simulation, at home with its fingers open.

    Args:
        model: Compiled, with the fragment of `panda.model`.
        data: Its state.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._drive = PandaDrive(model, data)
        self.motion = Motion(self._drive, Kinematics())
        self._servers: Mapping[tuple[str, str], ArmServer] = {}
        self._manipulator: ManipulatorMoveTo | None = None
        self._next_s = 0.0

    def actions(self, outbox: Outbox, at: float) -> list[tuple[str, str, ArmServer]]:
        """Name, type and server of each; made once."""
        self._servers = self._servers or {
            MOVE: MoveArm(self.motion, outbox.add, at),
            PICK: PickAt(self.motion, outbox.add, at),
            PLACE: PlaceAt(self.motion, outbox.add, at),
        }
        return [(*name, server) for name, server in self._servers.items()]

    def services(self, outbox: Outbox) -> dict[tuple[str, str], Answer]:
        """Name and type → what answers; made once."""
        self._manipulator = ManipulatorMoveTo(self.motion, outbox.add)
        return {MOVE_TO: self._manipulator.answer}

    def see(self, things: Sequence[Mapping[str, Any]], _at: float) -> None:
        """Take note of the things of the fact `objects`, as the camera measured them."""
        self.motion.see(things)

    def step(self, _at: float, _period_s: float) -> None:
        """Command what is due in one control period of 10 ms, before the physics of that period."""
        self.motion.step()

    def report(self, at: float) -> None:
        """Have the servers report what has come about, after the facts that it rests on."""
        for server in self._servers.values():
            server.step(at)
        if self._manipulator is not None:
            self._manipulator.step()

    def gripper(self) -> dict[str, Any]:
        """The fact `/gripper`: width (m), what presses on each finger (N), and whether something is held."""
        grip = self._drive.grip()
        return {
            "width_m": round(grip.width_m, 4),
            "holding": grip.is_holding,
            "left_n": round(grip.left_n, 2),
            "right_n": round(grip.right_n, 2),
        }

    def publish(self, outbox: Outbox, at: float) -> None:
        """Publish both topics, ten times a simulated second."""
        if at < self._next_s - 1e-9:
            return
        self._next_s = at + PUBLISHED_S
        outbox.publish(GRIPPER, messages.text(self.gripper()))
        places, speeds = self._drive.states()
        outbox.publish(
            JOINT_STATES,
            {
                "header": messages.header(at, ""),
                "name": [*JOINTS, *FINGER_JOINTS],
                "position": [round(place, 5) for place in places.tolist()],
                "velocity": [round(speed, 5) for speed in speeds.tolist()],
                "effort": [],
            },
        )

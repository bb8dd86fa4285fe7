# SPDX-License-Identifier: Apache-2.0
"""What the robot sees: its pictures with their depth, the detector's services, and the object finder on them."""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import Close, Connector
from rai_missions.worlds.camera import Camera, Moment
from rai_missions.worlds.detector_services import Answer, DetectorServices
from rai_missions.worlds.frame_history import FrameHistory
from rai_missions.worlds.house import interface
from rai_missions.worlds.house.rosbot import CAMERA_FOVY_DEG
from rai_missions.worlds.open_set_detector import OpenSetDetector
from rai_missions.worlds.perception.finder import ObjectFinder
from rai_missions.worlds.publish_queue import Outbox

__all__ = ("Vision",)


class Vision:
    """The camera of one house and what reads it.

    Args:
        camera: The front camera, depth aligned.
        detector: The simulated one; None where another one is used.
        seed: Of the depth's noise.
        now: Simulated seconds since the start.
    """

    def __init__(self, camera: Camera, detector: OpenSetDetector | None, seed: int, now: Callable[[], float]) -> None:
        self._frames = FrameHistory(camera, seed)
        self._finder = ObjectFinder(interface.FINDER)
        self._served = DetectorServices(self._frames, detector, now) if detector is not None else None

    def services(self) -> dict[tuple[str, str], Answer]:
        """Name and type → what answers."""
        return self._served.services() if self._served is not None else {}

    def open(self, connector: Connector) -> list[Close]:
        """Start the object finder on a connector; what ends it."""
        return self._finder.open(connector)

    def publish(self, outbox: Outbox, moment: Moment, at: float) -> None:
        """Publish a moment's depth and the lens; the picture itself follows."""
        self._frames.publish(outbox, moment, at, depth=interface.DEPTH, lens=interface.LENS, fovy_deg=CAMERA_FOVY_DEG)

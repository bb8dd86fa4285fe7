# SPDX-License-Identifier: Apache-2.0
"""What the robot sees: its pictures with their depth, the detector's services, and the object finder on them.

Rule: a request is answered for the picture that it holds, by its stamp; a picture that the camera did not take lately
is refused, so no detection is of another moment than its picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Close, Connector
from rai_missions.errors import ConnectorError
from rai_missions.image import Image
from rai_missions.worlds import messages
from rai_missions.worlds.camera import Camera, Frame, Moment
from rai_missions.worlds.house import interface
from rai_missions.worlds.house.detector import OpenSetDetector
from rai_missions.worlds.house.frames import FrameHistory
from rai_missions.worlds.perception.detections import CLASSIFY, SEGMENT, array_message, classes_of, detections_of
from rai_missions.worlds.perception.finder import ObjectFinder
from rai_missions.worlds.publish_queue import Outbox

__all__ = ("Vision",)

Answer = Callable[[Mapping[str, Any]], dict[str, Any]]


class Vision:
    """The camera of one house and what reads it.

    Args:
        camera: The front camera, depth aligned.
        detector: The simulated one; None where another one is used.
        seed: Of the depth's noise.
        now: Simulated seconds since the start.
    """

    def __init__(self, camera: Camera, detector: OpenSetDetector | None, seed: int, now: Callable[[], float]) -> None:
        self._camera, self._detector, self._now = camera, detector, now
        self.frames = FrameHistory(camera, seed)

    def services(self) -> dict[tuple[str, str], Answer]:
        """Name and type → what answers."""
        if self._detector is None:
            return {}
        served: list[tuple[tuple[tuple[str, ...], str], Answer]] = [
            (CLASSIFY, self._classify), (SEGMENT, self._segment),
        ]  # fmt: skip
        return {(name, kind): answer for (names, kind), answer in served for name in names}

    def open(self, connector: Connector) -> list[Close]:
        """Start the object finder on a connector; what ends it."""
        return ObjectFinder(connector, interface.FINDER).open()

    def publish(self, outbox: Outbox, moment: Moment, at: float) -> None:
        """Publish a moment's depth and the lens; the picture itself follows."""
        self.frames.keep(at, moment)
        width, height = self._camera.width, self._camera.height
        depth = Image(f"/{interface.DEPTH}@{at:.3f}", width, height, "16UC1", lambda: self.frames.depth_mm(at, moment))
        outbox.publish(interface.LENS, interface.camera_info(width, height, at))
        outbox.publish(interface.DEPTH, messages.image(depth, at))

    def _classify(self, request: Mapping[str, Any]) -> dict[str, Any]:
        detector, (moment_ms, frame), picture = self._read(request)
        names = classes_of(str(request.get("classes", "")))
        found = detector.detect(frame, moment_ms, names, float(request.get("box_threshold") or 0.0))
        return {"detections": array_message(found, names, picture["header"])}

    def _segment(self, request: Mapping[str, Any]) -> dict[str, Any]:
        detector, (_, frame), picture = self._read(request)
        boxes = [one.box for one in detections_of(request.get("detections"))]
        height, width = frame.body.shape
        masks = (
            Image(f"mask {number}", width, height, "mono8", detector.mask(frame, box).tobytes())
            for number, box in enumerate(boxes)
        )
        return {"masks": [{**messages.image(mask, 0.0), "header": dict(picture["header"])} for mask in masks]}

    def _read(self, request: Mapping[str, Any]) -> tuple[OpenSetDetector, tuple[int, Frame], Mapping[str, Any]]:
        assert self._detector is not None
        if self._detector.is_down(self._now()):
            raise ConnectorError("the detector is down")
        picture = request.get("source_img") or {}
        found = self.frames.of_picture(picture)
        if found is None:
            raise ConnectorError("source_img is none of the last pictures of this camera; send one as it was received")
        return self._detector, found, picture

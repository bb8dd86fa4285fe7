# SPDX-License-Identifier: Apache-2.0
"""The services of a world's detector: boxes around what a picture shows, and masks.

Rule: a request is answered for the picture that it holds, by its stamp; a picture that the camera did not take lately
is refused, so no detection is of another moment than its picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Answer
from rai_missions.errors import ConnectorError
from rai_missions.image import Image
from rai_missions.worlds import messages
from rai_missions.worlds.camera import Frame
from rai_missions.worlds.frame_history import FrameHistory
from rai_missions.worlds.open_set_detector import OpenSetDetector
from rai_missions.worlds.perception.detections import CLASSIFY, SEGMENT, array_message, classes_of, detections_of

__all__ = ("DetectorServices",)


class DetectorServices:
    """Answers about the last pictures of one camera.

    Args:
        frames: The pictures.
        detector: What reads them.
        now: Simulated seconds since the start.
    """

    def __init__(self, frames: FrameHistory, detector: OpenSetDetector, now: Callable[[], float]) -> None:
        self._frames, self._detector, self._now = frames, detector, now

    def services(self) -> dict[tuple[str, str], Answer]:
        """Name and type → what answers."""
        served: list[tuple[tuple[tuple[str, ...], str], Answer]] = [
            (CLASSIFY, self._classify),
            (SEGMENT, self._segment),
        ]
        return {(name, kind): answer for (names, kind), answer in served for name in names}

    def _classify(self, request: Mapping[str, Any]) -> dict[str, Any]:
        (moment_ms, frame), picture = self._read(request)
        names = classes_of(str(request.get("classes", "")))
        found = self._detector.detect(frame, moment_ms, names, float(request.get("box_threshold") or 0.0))
        return {"detections": array_message(found, names, picture["header"])}

    def _segment(self, request: Mapping[str, Any]) -> dict[str, Any]:
        (_, frame), picture = self._read(request)
        boxes = [one.box for one in detections_of(request.get("detections"))]
        height, width = frame.body.shape
        masks = (
            Image(f"mask {number}", width, height, "mono8", self._detector.mask(frame, box).tobytes())
            for number, box in enumerate(boxes)
        )
        return {"masks": [{**messages.image(mask, 0.0), "header": dict(picture["header"])} for mask in masks]}

    def _read(self, request: Mapping[str, Any]) -> tuple[tuple[int, Frame], Mapping[str, Any]]:
        if self._detector.is_down(self._now()):
            raise ConnectorError("the detector is down")
        picture = request.get("source_img") or {}
        found = self._frames.of_picture(picture)
        if found is None:
            raise ConnectorError("source_img is none of the last pictures of this camera; send one as it was received")
        return found, picture

# SPDX-License-Identifier: Apache-2.0
"""The open-set detector's contract in plain data: its services, its request, and the detections in its reply.

Source: rai_interfaces of RobotecAI/rai: srv/RAIGroundingDino, srv/RAIGroundedSam, msg/RAIDetectionArray; vision_msgs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

__all__ = ("CLASSIFY", "SEGMENT", "Box2D", "ObjectDetection", "array_message", "classes_of", "detections_of", "request")

CLASSIFY = ("/grounding_dino_classify", "/detection"), "rai_interfaces/srv/RAIGroundingDino"
"""The names that upstream's detectors have had, the older first, and their type."""
SEGMENT = ("/grounded_sam_segment", "/segmentation"), "rai_interfaces/srv/RAIGroundedSam"
BOX_THRESHOLD, TEXT_THRESHOLD = 0.35, 0.45
"""Upstream's usual ones."""


class Box2D(NamedTuple):
    """A box in a picture, in pixels from the upper left corner."""

    left: float
    top: float
    right: float
    bottom: float


class ObjectDetection(NamedTuple):
    """One thing that a detector reports."""

    name: str
    """The class as it was asked for."""
    score: float
    """0 to 1, the detector's own."""
    box: Box2D


def classes_of(text: str) -> list[str]:
    """The names in a comma-separated list, as upstream's detectors read it."""
    return [name for part in text.split(",") if (name := part.strip())]


def request(names: Sequence[str], picture: Mapping[str, Any]) -> dict[str, Any]:
    """A request of RAIGroundingDino.

    Args:
        names: What is looked for.
        picture: A sensor_msgs/msg/Image.
    """
    thresholds = {"box_threshold": BOX_THRESHOLD, "text_threshold": TEXT_THRESHOLD}
    return {"classes": ", ".join(names), **thresholds, "source_img": dict(picture)}


def array_message(
    detections: Sequence[ObjectDetection], names: Sequence[str], header: Mapping[str, Any]
) -> dict[str, Any]:
    """A RAIDetectionArray."""
    return {
        "header": dict(header),
        "detections": [_detection(one, header) for one in detections],
        "detection_classes": list(names),
    }


def detections_of(array: Any) -> list[ObjectDetection]:
    """The detections of a RAIDetectionArray; what has no name, no finite score or no finite box is left out."""
    given = array.get("detections") if isinstance(array, Mapping) else None
    listed = given if isinstance(given, list | tuple) else ()
    read = (_read(one) for one in listed if isinstance(one, Mapping))
    return [one for one in read if one is not None]


def _detection(one: ObjectDetection, header: Mapping[str, Any]) -> dict[str, Any]:
    box = one.box
    middle = {"x": (box.left + box.right) / 2, "y": (box.top + box.bottom) / 2}
    return {
        "header": dict(header),
        "results": [{"hypothesis": {"class_id": one.name, "score": one.score}}],
        "bbox": {
            "center": {"position": middle, "theta": 0.0},
            "size_x": box.right - box.left,
            "size_y": box.bottom - box.top,
        },
    }


def _read(one: Mapping[str, Any]) -> ObjectDetection | None:
    try:
        hypothesis = one["results"][0]["hypothesis"]
        name, score = str(hypothesis["class_id"]).strip(), float(hypothesis["score"])
        centre, wide, high = (
            one["bbox"]["center"]["position"],
            float(one["bbox"]["size_x"]),
            float(one["bbox"]["size_y"]),
        )
        x, y = float(centre["x"]), float(centre["y"])
    except (KeyError, IndexError, TypeError, ValueError, OverflowError):
        return None
    if not name or not all(map(math.isfinite, (score, wide, high, x, y))) or min(wide, high) <= 0:
        return None
    box = Box2D(x - wide / 2, y - high / 2, x + wide / 2, y + high / 2)
    return ObjectDetection(name, min(1.0, max(0.0, score)), box)

# SPDX-License-Identifier: Apache-2.0
"""What a detector reports: boxes in a picture, with the names of what is in them.

Source: vision_msgs/msg/Detection2DArray, and the plain JSON that small detectors send.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut, cut_repr

__all__ = ("Box", "Detection", "detections_of")

Box = tuple[float, float, float, float]
"""Left, top, right, bottom, in pixels."""
MOST = 100
"""Detections of one picture that are looked at."""
EDGES = ("x_min", "y_min", "x_max", "y_max")
LONGEST_NAME = 100


class Detection(NamedTuple):
    name: str
    score: float | None
    """How sure the detector is, 0 to 1; None: it does not state."""
    box: Box


def detections_of(message: Any) -> list[Detection]:
    """The detections in a message.

    Args:
        message: `{"detections": […]}` as vision_msgs has it, or with `name`, `score` and `box` (left, top, right,
            bottom) or `x_min`, `y_min`, `x_max`, `y_max`; or such JSON in a std_msgs/msg/String.

    Raises:
        ConnectorError: It is none of these.
    """
    if isinstance(message, Mapping) and "detections" not in message and isinstance(message.get("data"), str):
        try:
            message = json.loads(message["data"])
        except (ValueError, RecursionError):
            raise ConnectorError(f"{cut_repr(message['data'], 80)} is no JSON of detections") from None
    found = message.get("detections") if isinstance(message, Mapping) else message
    if not isinstance(found, list | tuple):
        raise ConnectorError(f"{cut_repr(message, 80)} has no 'detections'")
    return [_detection(each) for each in found[:MOST]]


def _detection(given: Any) -> Detection:
    try:
        best = _best(given.get("results") or ())
        name = best.get("class_id", best.get("id", given.get("name", given.get("label", given.get("class_id", "")))))
        score = best.get("score", given.get("score", given.get("confidence")))
        box = _box(given)
        score = None if score is None else float(score)
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as fault:
        raise ConnectorError(
            f"{cut_repr(given, 80)} is no detection with a name and a box: {cut_repr(fault, 60)}"
        ) from None
    if score is not None and not math.isfinite(score):
        raise ConnectorError(f"{score} is no score of a detection; it is 0 to 1")
    if not all(map(math.isfinite, box)) or box[0] > box[2] or box[1] > box[3]:
        raise ConnectorError(f"{box} is no box of left, top, right and bottom")
    return Detection(cut(name, LONGEST_NAME), score, box)


def _best(results: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The surest hypothesis of a vision_msgs/msg/Detection2D."""
    hypotheses = [each.get("hypothesis", each) for each in results]
    return max(hypotheses, key=lambda each: float(each.get("score", 0.0)), default={})


def _box(given: Mapping[str, Any]) -> Box:
    box = given.get("bbox", given.get("box"))
    if isinstance(box, Mapping) and "center" in box:
        center = box["center"].get("position", box["center"])
        x, y, half, tall = (float(each) for each in (center["x"], center["y"], box["size_x"] / 2, box["size_y"] / 2))
        return (x - half, y - tall, x + half, y + tall)
    edges = (
        box if isinstance(box, list | tuple) else [(box if isinstance(box, Mapping) else given)[edge] for edge in EDGES]
    )
    left, top, right, bottom = (float(edge) for edge in edges)
    return (left, top, right, bottom)

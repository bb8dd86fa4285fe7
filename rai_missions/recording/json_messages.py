# SPDX-License-Identifier: Apache-2.0
"""What a recording reports, as JSON: messages of the robot, pictures, steps, writes and lines for a log.

Rule: pure. Whatever comes becomes JSON; what JSON has not, becomes the text that states it.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.connectors.connector import Report
from rai_missions.engine.description import step_json, way_words
from rai_missions.engine.step import Step
from rai_missions.image import Image
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.recording.schemas import COMPRESSED_IMAGE, RAW_IMAGE, Schema
from rai_missions.runtime.lifecycle import Status

__all__ = (
    "call_of",
    "image_in",
    "log_of",
    "picture_of",
    "report_of",
    "short",
    "stamp",
    "status_of",
    "step_of",
    "without_bytes",
    "write_of",
)

Json = dict[str, Any]
INFO, WARNING, ERROR = 2, 3, 4
SHORT = 200


def stamp(at_ns: int) -> Json:
    """A time as Foxglove has it."""
    sec, nsec = divmod(max(0, at_ns), 10**9)
    return {"sec": sec, "nsec": nsec}


def short(value: Any) -> str:
    """A value in a line of bounded length."""
    if isinstance(value, Image):
        return value.ref
    text = value if isinstance(value, str) else json.dumps(plain(value), ensure_ascii=False)
    return text if len(text) <= SHORT else f"{text[: SHORT - 1]}…"


def image_in(data: Any) -> Image | None:
    """The picture that a message carries, if it carries one."""
    if isinstance(data, Image):
        return data
    for item in data.values() if isinstance(data, Mapping) else ():
        if isinstance(item, Image):
            return item
    return None


def without_bytes(value: Any) -> Any:
    """A value as it waits: of a picture its reference alone is written, so its bytes need not wait with it."""
    return Image(value.ref, value.width, value.height, value.encoding, b"") if isinstance(value, Image) else value


def picture_of(image: Image, data: Any, at_ns: int) -> tuple[Schema, Json]:
    """A picture as Foxglove shows it; its bytes are made here if no one has asked for them before."""
    header = data.get("header") if isinstance(data, Mapping) else None
    frame = header.get("frame_id") if isinstance(header, Mapping) else None
    words: Json = {"timestamp": stamp(at_ns), "frame_id": str(frame or "")}
    pixels = base64.b64encode(image.data).decode()
    if image.encoding != "rgb8":
        return COMPRESSED_IMAGE, words | {"data": pixels, "format": image.encoding}
    size = {"width": image.width, "height": image.height, "encoding": "rgb8", "step": image.width * 3}
    return RAW_IMAGE, words | size | {"data": pixels}


def write_of(key: str, value: Any, at: float) -> Json:
    """A write of the blackboard."""
    words: Json = {"key": key, "value": plain(value), "at": at, "text": short(value)}
    if isinstance(value, bool | int) or (isinstance(value, float) and math.isfinite(value)):
        words["number"] = float(value)
    return words


def call_of(service: str, request: Mapping[str, Any], seconds: float, outcome: str, data: Any, why: str) -> Json:
    """A call of a service, with its request in a line of bounded length."""
    return {
        "service": service,
        "request": short(request),
        "seconds": seconds,
        "outcome": outcome,
        "data": plain(data),
        "why": why,
    }


def report_of(action: str, report: Report) -> Json:
    """What an action's server has reported of a goal."""
    rest = report._asdict()
    return {"action": action, "said": rest.pop("status"), **plain(rest)}  # the file's word


def status_of(status: Status, mission: Mission) -> Json:
    """A status, with the innermost states as one text."""
    return {
        "revision": status.revision,
        "mode": status.mode,
        "control": status.control,
        "state": state_of(status.active, mission),
        "active": list(status.active),
        "outcome": status.outcome or "",
        "why": status.why,
    }


def state_of(active: Sequence[str], mission: Mission) -> str:
    """The innermost of the active states, in one text."""
    all_of_them = set(active)
    return ", ".join(name for name in active if all_of_them.isdisjoint(mission.state(name).children()))


def step_of(step: Step) -> Json:
    """A step, with each effect in a line of bounded length."""
    found = step_json(step)
    return found | {"effects": [each | {"about": short(each["about"])} for each in found["effects"]]}


def log_of(step: Json, mission: str, at_ns: int) -> Json:
    """A step in one line."""
    way = way_words(step["exited"], step["entered"])
    ended = f"{step['outcome']}: {step['why']}" if step["outcome"] else step["why"]
    parts = [way, *step["verdicts"], *step["notes"], ended]
    level = INFO
    if step["outcome"] in ("failed", "aborted"):
        level = ERROR
    elif step["outcome"] == "canceled" or step["notes"]:
        level = WARNING
    message = " · ".join([f"{step['at']:.2f} s  {step['event']['name']}", *filter(None, parts)])
    return {
        "timestamp": stamp(at_ns),
        "level": level,
        "message": message,
        "name": "rai_missions",
        "file": mission,
        "line": step["seq"],
    }

# SPDX-License-Identifier: Apache-2.0
"""The process that holds a recogniser, a voice or an ear: one order after the other, each with its reply.

Rule: it opens what the first order names, and nothing that a later order has is ever executed.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.connectors.process.frames import read_frame, write_frame
from rai_missions.errors import raised_text
from rai_missions.redaction import cut, cut_repr
from rai_missions.voice.kind import Reading, opened

__all__ = ("work",)

PIECE = 1 << 18
"""Bytes of sound in one message."""


def work(request_fd: int, reply_fd: int) -> None:
    """Open what the first order names, and take orders until there are no more."""
    first = read_frame(request_fd)
    if first is None:
        return
    order = first[0]
    sys.path[:] = order["path"]
    try:
        held = opened(order["sort"], order["name"], order["options"])
    except BaseException as error:  # noqa: BLE001 - whatever a package raises, it is not there
        write_frame(reply_fd, {"absent": cut(error, 400)})
        return
    write_frame(reply_fd, {"ready": True})
    while (found := read_frame(request_fd)) is not None:
        message, blobs = found
        try:
            reply = ORDERS[order["sort"]](held, message, blobs, reply_fd)
        except Exception as error:  # noqa: BLE001 - one sound or sentence that it cannot take ends nothing
            reply = {"failed": cut(raised_text(error), 400)}
        write_frame(reply_fd, {"reply": message["id"], **reply})


def _transcribe(held: Any, message: Mapping[str, Any], blobs: Sequence[bytes], _: int) -> dict[str, Any]:
    reading = held.transcribe(blobs[0], message["phrases"])
    if not isinstance(reading, Reading):
        raise TypeError(f"what it makes of sound is a Reading, not {cut_repr(reading, 60)}")
    kept = {name: dict(getattr(reading, name)) for name in ("evidence", "guesses", "odds")}
    return {"text": reading.text, **kept}


def _speak(held: Any, message: Mapping[str, Any], _: Sequence[bytes], reply_fd: int) -> dict[str, Any]:
    for sound in held.speak(message["text"]):
        for start in range(0, len(sound), PIECE):
            piece = base64.b64encode(sound[start : start + PIECE]).decode("ascii")
            write_frame(reply_fd, {"part": message["id"], "sound": piece})
    return {}


def _take(held: Any, _message: Mapping[str, Any], blobs: Sequence[bytes], _: int) -> dict[str, Any]:
    reading = held.take(blobs[0], blobs[1])
    clear, quiet = (base64.b64encode(each).decode("ascii") for each in (reading.clear, reading.quiet))
    return {"speech": reading.speech, "wake": reading.wake, "clear": clear, "quiet": quiet}


ORDERS = {"recogniser": _transcribe, "voice": _speak, "ear": _take}

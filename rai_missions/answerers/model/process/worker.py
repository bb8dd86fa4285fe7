# SPDX-License-Identifier: Apache-2.0
"""The process that holds a model: opens it, asks it, and sends back what is read of its answers.

Rule: the main thread takes orders alone, so that it answers while a model hangs; each question has a thread of its own.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rai_missions.connectors.process.frames import outward, read_frame, write_all

if TYPE_CHECKING:
    from rai_missions.redaction import Redaction

__all__ = ("work",)


class Outlet:
    """Where replies go; threads take turns."""

    def __init__(self, fd: int) -> None:
        self._fd, self._lock = fd, threading.Lock()

    def send(self, message: Mapping[str, Any]) -> None:
        """Send one message; a pipe that has ended ends nothing here, the guard does."""
        pieces = outward(message)
        with self._lock, contextlib.suppress(BrokenPipeError):
            write_all(self._fd, pieces)


def work(request_fd: int, reply_fd: int) -> None:
    """Take orders until there are no more."""
    outlet = Outlet(reply_fd)
    first = read_frame(request_fd)
    if first is None:
        return
    opened = _opened(first[0], outlet)
    if opened is None:
        return
    model, _redactions = opened  # what the model's keys are is hidden for as long as these live
    talks: dict[int, tuple[Any, threading.Event]] = {}
    """Question → its conversation, and whether it is waited for no longer."""
    while (order := read_frame(request_fd)) is not None:
        message, blobs = order
        number = message["id"]
        dropped = talks[number][1] if number in talks else threading.Event()
        if message["do"] == "drop":
            dropped.set()
            talks.pop(number, None)
            outlet.send({"dropped": number})
            continue
        if message["do"] == "begin":
            talks[number] = (None, dropped)
        given = (model, message, blobs, talks, dropped, outlet)
        threading.Thread(target=_answer, args=given, name=f"question {number}", daemon=True).start()


def _opened(order: Mapping[str, Any], outlet: Outlet) -> tuple[Any, list[Redaction]] | None:
    """The model, as the engine's process would have opened it, and what hides its keys; None where it cannot be."""
    os.environ.update(order["environment"])
    sys.path[:] = order["path"]
    from rai_missions.answerers.model.chat import Abilities
    from rai_missions.answerers.model.process.words import ability_words
    from rai_missions.answerers.model.providers import open_model
    from rai_missions.answerers.model.secrets import secrets_of
    from rai_missions.redaction import Redaction, cut

    opened = [Redaction(order["secrets"])]
    try:
        model = open_model(order["model"], isolated=order["isolated"])
        opened.append(Redaction(secrets_of(model)))
        words = ability_words(Abilities.of(model))
    except BaseException as error:  # noqa: BLE001 - whatever the provider's package raises, the model is not there
        outlet.send({"absent": cut(error, 400)})
        return None
    outlet.send(words)
    return model, opened


def _answer(
    model: Any,
    message: Mapping[str, Any],
    blobs: Sequence[bytes],
    talks: dict[int, tuple[Any, threading.Event]],
    dropped: threading.Event,
    outlet: Outlet,
) -> None:
    """Put one question, or what was looked up for it, to the model."""
    from rai_missions.answerers.model.chat import ThreadConversation
    from rai_missions.answerers.model.output_modes import AnswerForm
    from rai_missions.answerers.model.process.words import messages_in, reply_words

    number = message["id"]
    try:
        if message["do"] == "begin":
            form = AnswerForm(message["schema"], message["tools"])
            talk = ThreadConversation(model, message["mode"], form, lambda: not dropped.is_set())
            talks[number] = (talk, dropped)
        else:
            talk = talks[number][0]
        words = reply_words(talk.ask(messages_in(message["messages"], blobs)))
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is reported, and this process stays
        words = reply_words(error)
    outlet.send({"reply": number, **words})

# SPDX-License-Identifier: Apache-2.0
"""Carries the orders of a dialogue to a run, and reports what the run made of each.

Rule: an order is an event in the run's mailbox like any other, with its sentence and role in it; what became of it is
read from the Step that took it.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.conversation import Order
from rai_missions.conversation.inputs import by_words
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.runtime.runner import Runner

__all__ = ("GOOD_FOR_S", "LASTING", "OnOrderEnd", "RunOrders")

OnOrderEnd = Callable[[str], None]
"""Receives once, from any thread, why an order was not carried out; empty where it was."""
GOOD_FOR_S = 5.0
"""Wall seconds within which the run has to take an order; anyone who gave it has continued since."""
LASTING = frozenset({"stop", "cancel"})
"""Orders that are carried out however late the run takes them."""
OVER = "the mission has ended"


class GivenOrder(NamedTuple):
    """An order that the run has yet to take."""

    order: Order
    on_end: OnOrderEnd
    until: float
    """By `time.monotonic`."""


class RunOrders:
    """The orders to one run.

    Args:
        runner: The run.
    """

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._lock = threading.Lock()
        self._waiting: dict[str, GivenOrder] = {}
        self._is_over = False
        runner.drop_if(self._drops)

    def perform(self, order: Order, on_end: OnOrderEnd) -> None:
        """Carry out an order; never waits."""
        if order.name == "start":
            on_end(self._runner.start(order.arguments))
            return
        request = uuid.uuid4().hex[:12]
        with self._lock:
            is_over = self._is_over
            if not is_over:
                self._waiting[request] = GivenOrder(order, on_end, time.monotonic() + GOOD_FOR_S)
        if is_over:
            on_end(OVER)
            return
        event = self._event(order, request)
        if event.name == "kill":
            self._runner.post_urgent(event)
        else:
            self._runner.post(event)

    def step(self, step: Step) -> None:
        """Report what became of the order that a step took; on the run's thread."""
        request = step.event.data.get("request") if self._waiting else None
        with self._lock:
            waiting = self._waiting.pop(request, None) if isinstance(request, str) else None
        if waiting is not None:
            waiting.on_end(_refusal(waiting.order, step))

    def close(self) -> None:
        """The run is over: what it has not taken is not carried out."""
        with self._lock:
            self._is_over = True
            left, self._waiting = tuple(self._waiting.values()), {}
        for each in left:
            each.on_end(OVER)

    def _event(self, order: Order, request: str) -> Event:
        at = self._runner.view.now()
        data: dict[str, Any] = {
            "by": by_words(order.role, order.author, order.channel),
            "role": order.role,
            "request": request,
        }
        if order.name == "answer":
            data |= {"option": order.option, "parameters": dict(order.parameters)}
            return Event("operator", at, data, "proposal", order.question)
        return Event(self._command(order), at, data, "command")

    def _command(self, order: Order) -> str:
        """A mission that is being canceled may move still, and has no pause: there a stop is the e-stop."""
        return "kill" if order.name == "stop" and self._runner.view.mode == "canceling" else order.name

    def _drops(self, event: Event) -> bool:
        """Whether an order is taken too late; then that is reported."""
        request = event.data.get("request") if self._waiting else None
        waiting = self._waiting.get(request) if isinstance(request, str) else None
        if waiting is None or waiting.order.name in LASTING or time.monotonic() <= waiting.until:
            return False
        with self._lock:
            self._waiting.pop(str(request), None)
        waiting.on_end(f"the run did not get to it within {GOOD_FOR_S:g} s, and it was dropped")
        return True


def _refusal(order: Order, step: Step) -> str:
    if order.name != "answer":
        return step.why if step.ignored and step.why else ""
    verdict = step.verdict
    if step.kept or (verdict is not None and verdict.accepted):
        return ""
    words: Mapping[int, str] = dict(enumerate(step.notes))
    note = verdict.note if verdict is not None else None
    return (words.get(note, "") if note is not None else "") or step.why or "its time was over"

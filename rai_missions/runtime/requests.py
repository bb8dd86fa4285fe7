# SPDX-License-Identifier: Apache-2.0
"""The requests to a run: each is an event in its mailbox, and its client learns once what became of it.

Rule: a request is known by the name that its event carries; anyone may call something so, and mean anything by it.
"""

from __future__ import annotations

import math
import threading
import time
import uuid
from typing import Generic, NamedTuple, Protocol, TypeVar

from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.runtime.commands import RunCommands

__all__ = ("GOOD_FOR_S", "OVER", "PendingRequest", "RunRequests", "refusal_text")

GOOD_FOR_S = 5.0
"""Wall seconds within which a run has to take a request: anyone who gave it has continued since."""
OVER = "the mission has ended"


class PendingRequest(Protocol):
    """What a run has yet to take; one of these is called, once, from any thread."""

    def take(self, step: Step) -> None:
        """A step was made of it."""

    def drop(self, waited_s: float) -> None:
        """The run was busy for so long, and it was dropped."""

    def end(self) -> None:
        """The run has ended without it."""


P = TypeVar("P", bound=PendingRequest)


class _RequestEntry(NamedTuple, Generic[P]):
    request: P
    since: float
    """By `time.monotonic`; infinite for one that is carried out however late the run takes it."""

    @property
    def waited_s(self) -> float:
        return time.monotonic() - self.since


class RunRequests(Generic[P]):
    """The requests to one run.

    Args:
        run: Whose mailbox they are put into.
    """

    def __init__(self, run: RunCommands) -> None:
        self._lock = threading.Lock()
        self._waiting: dict[str, _RequestEntry[P]] = {}
        self.is_over = False
        run.drop_if(self.drops)

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, request: P, *, lasts: bool) -> str:
        """Await what becomes of a request.

        Args:
            request: Which.
            lasts: It is carried out however late the run takes it.

        Returns:
            The name that its event is to carry; empty where the run is over, which the request has received.
        """
        name = uuid.uuid4().hex[:12]
        with self._lock:
            if not self.is_over:
                self._waiting[name] = _RequestEntry(request, math.inf if lasts else time.monotonic())
                return name
        request.end()
        return ""

    def taken(self, name: str) -> P | None:
        """The request of a name, which the run takes now; None where none waits, or it is dropped."""
        waiting = self._pop(name)
        if waiting is None:
            return None
        if (waited_s := waiting.waited_s) > GOOD_FOR_S:
            waiting.request.drop(waited_s)
            return None
        return waiting.request

    def drops(self, event: Event) -> bool:
        """Whether an event is a request that the run takes too late; then that is reported."""
        name = self._name(event)
        waiting = self._waiting.get(name)
        if waiting is None or (waited_s := waiting.waited_s) <= GOOD_FOR_S or self._pop(name) is None:
            return False
        waiting.request.drop(waited_s)
        return True

    def step(self, step: Step) -> P | None:
        """Report a step to the client whose request it took; on the run's thread.

        Returns:
            That request; None where it took none.
        """
        waiting = self._pop(self._name(step.event))
        if waiting is None:
            return None
        waiting.request.take(step)
        return waiting.request

    def close(self) -> None:
        """The run is over: what it has not taken is not carried out."""
        with self._lock:
            self.is_over = True
            left, self._waiting = tuple(self._waiting.values()), {}
        for each in left:
            each.request.end()

    def _pop(self, name: str) -> _RequestEntry[P] | None:
        with self._lock:
            return self._waiting.pop(name, None)

    def _name(self, event: Event) -> str:
        name = event.data.get("request") if self._waiting else ""
        return name if isinstance(name, str) else ""


def refusal_text(step: Step) -> str:
    """Why a step did not do what its command, answer or event asks for; empty where it did, or will after a pause."""
    if step.event.kind != "proposal":
        return step.why if step.ignored else ""
    verdict = step.verdict
    if step.kept or (verdict is not None and verdict.accepted):
        return ""
    words = step.notes[verdict.note] if verdict is not None and verdict.note is not None else ""
    return words or step.why or "its time was over"

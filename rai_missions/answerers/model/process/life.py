# SPDX-License-Identifier: Apache-2.0
"""The engine's end of one process that holds a model: from its start to the end of everything that descends from it.

Rule: no thread of the engine's waits for the process where something waits for that thread: what is written and what is
read have threads of their own, and whatever asked is released when the process ends.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rai_missions.answerers.model.chat import UNWANTED, Abilities, Absent, BudgetExceeded, ModelExit
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.process.words import abilities_in, reply_in
from rai_missions.connectors.process.frames import Broken
from rai_missions.connectors.process.life import ProcessLife
from rai_missions.redaction import cut, secrets_held, variables

__all__ = ("ModelLife", "PendingCall")

WORK = "rai_missions.answerers.model.process.worker:work"
UNASKED = "it sent what was not asked for"


class PendingCall:
    """One thing asked of the process: released by its reply, by the process's end, or since nothing waits for it."""

    def __init__(self) -> None:
        self._over = threading.Event()
        self._result: ModelReply | BaseException | None = None

    def release(self, result: ModelReply | BaseException | None) -> None:
        """What came of it; the first counts."""
        if not self._over.is_set():
            self._result = result
            self._over.set()

    def wait(self) -> ModelReply | None:
        """What came of it; raised where it is an exception."""
        self._over.wait()
        if isinstance(self._result, BaseException):
            raise self._result
        return self._result


class ModelLife(ProcessLife):
    """One process that holds a model, from its start to its end.

    Args:
        model: What it holds, by name.
        most_bytes: How much memory it may be resident in, with all that descends from it.
        ended: Called once, on a thread of this object, after everything has ended.
        isolated: As `open_model` has it.
    """

    def __init__(
        self, model: str, most_bytes: int, ended: Callable[[ModelLife], None], *, isolated: bool = False
    ) -> None:
        self._report_end = ended
        self._calls_lock = threading.Lock()
        self._waiting: list[PendingCall] = []
        self.able: Abilities | None = None
        """What the model can do; None until it is opened."""
        self.absent = ""
        """Why the model cannot be opened; empty unless the process reports it."""
        self._calls: dict[int, PendingCall] = {}
        self._dropped: set[int] = set()
        """Questions that were dropped while the model had them; taken out when its thread comes back."""
        self._unconfirmed: set[int] = set()
        """Questions whose drop the process has yet to confirm."""
        self._all_confirmed = threading.Event()
        self._all_confirmed.set()
        self._is_over = False
        first = {
            "model": model,
            "isolated": isolated,
            "environment": variables(secret=True),
            "path": [os.path.abspath(entry) for entry in sys.path],
            "secrets": secrets_held(),
        }
        super().__init__("model", WORK, first, most_bytes, on_message=self._take, on_end=self._release_all)
        self.start()

    # -- what is asked of it -------------------------------------------------------------------------------------------

    @property
    def busy(self) -> int:
        """Calls whose answers are waited for."""
        return len(self._calls)

    @property
    def lingering(self) -> int:
        """Questions that were dropped and that the model still has."""
        return len(self._dropped)

    def has_confirmed(self, number: int) -> bool:
        """Whether the drop of a question was confirmed; where it was not, the interpreter there is held."""
        return number not in self._unconfirmed

    def confirms_within(self, seconds: float) -> bool:
        """Whether every drop was confirmed, or is in so many seconds; waits."""
        return self._all_confirmed.wait(seconds)

    def lingers(self, number: int) -> bool:
        """Whether a question that was dropped is still with the model."""
        return number in self._dropped

    def wait_able(self, when_closed: Callable[[Callable[[], None]], None]) -> Abilities:
        """Wait until it is known what the model can do.

        Args:
            when_closed: Has a function called when the question is closed.

        Raises:
            Absent: The model cannot be opened.
            ModelExit: The process ended.
            BudgetExceeded: The question was closed.
        """
        call = PendingCall()
        with self._calls_lock:
            if (able := self.able) is not None:
                return able
            if self.absent:
                raise Absent(self.absent)
            if self._is_over or not self.alive:
                raise self._ended()
            self._waiting.append(call)
        when_closed(lambda: call.release(BudgetExceeded(UNWANTED)))
        call.wait()
        able = self.able
        assert able is not None
        return able

    def ask(self, number: int, order: Mapping[str, Any], blobs: Sequence[bytes]) -> PendingCall:
        """Send an order; its reply comes to the call."""
        call = PendingCall()
        with self._calls_lock:
            if self._is_over or not self.alive:
                call.release(self._ended())
                return call
            self._calls[number] = call
        self.send(order, blobs)
        return call

    def drop(self, number: int) -> bool:
        """An answer is no longer waited for; whether the model has the question still."""
        with self._calls_lock:
            call = self._calls.pop(number, None)
            if call is not None:
                self._dropped.add(number)
            if self.able is not None:
                self._unconfirmed.add(number)
                self._all_confirmed.clear()
        self.send({"do": "drop", "id": number})
        if call is None:
            return False
        call.release(BudgetExceeded(UNWANTED))
        return True

    # -- on the thread of the process ----------------------------------------------------------------------------------

    def _ended(self) -> ModelExit:
        return ModelExit(f"the model's process ended: {self.why or 'it was closed'}")

    def _release_all(self) -> None:
        with self._calls_lock:
            self._is_over = True
            calls, self._calls = list(self._calls.values()), {}
            self._all_confirmed.set()
            waiting, self._waiting = self._waiting, []
        ended = self._ended()
        for call in calls:
            call.release(ended)
        for call in waiting:
            call.release(Absent(self.absent) if self.absent else ended)
        self._report_end(self)

    def _take(self, message: Mapping[str, Any]) -> None:
        """One message of the process, which may be anything.

        Raises:
            Broken: It is none that was asked for.
        """
        if "ready" in message and self.able is None:
            able = abilities_in(message)
            with self._calls_lock:
                self.able = able
                waiting, self._waiting = self._waiting, []
            for call in waiting:
                call.release(None)
        elif "absent" in message and self.able is None:
            self.absent = cut(message["absent"], 400)
        elif type(number := message.get("dropped")) is int and number in self._unconfirmed:
            with self._calls_lock:
                self._unconfirmed.discard(number)
                if not self._unconfirmed:
                    self._all_confirmed.set()
        elif type(number := message.get("reply")) is int:
            self._reply(number, message)
        else:
            raise Broken(UNASKED)

    def _reply(self, number: int, message: Mapping[str, Any]) -> None:
        with self._calls_lock:
            call = self._calls.pop(number, None)
            late = number in self._dropped
            self._dropped.discard(number)
        if call is None and not late:
            raise Broken(UNASKED)
        if call is None:
            return
        try:
            call.release(reply_in(message))
        except Broken as broken:
            call.release(ModelExit(f"the model's process was ended: {broken}"))
            raise
        except BaseException as raised:  # noqa: BLE001 - what the model raised goes to whatever asked
            call.release(raised)

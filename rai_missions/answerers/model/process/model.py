# SPDX-License-Identifier: Apache-2.0
"""A model that is named by text, asked in a process of its own, which is replaced when it dies or answers no more.

Rule: whatever the model does – hang, hold its interpreter's lock, crash, take memory – costs its question an attempt.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Sequence

from langchain_core.messages import BaseMessage

from rai_missions.answerers.model.chat import Abilities, Absent, BudgetExceeded
from rai_missions.answerers.model.output_modes import AnswerForm, OutputMode
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.answerers.model.process.life import ModelLife
from rai_missions.answerers.model.process.words import packed
from rai_missions.connectors.process.life import PATIENCE_S
from rai_missions.connectors.worker import Worker
from rai_missions.redaction import logger

__all__ = ("ModelProcess",)

log = logger(__name__)

GIB = 2**30
PROMPT_S, CONFIRM_S = 0.5, 2.0
"""How long a process may take to confirm that a question was dropped before another question has another process asked,
and before it is ended; one that holds its interpreter's lock cannot."""
LINGER_S = 60.0
"""How long a question that was dropped may stay with the model, where its process answers otherwise."""
MOST_LINGERING = 3
START_S = 120.0
"""How long a model may take to be opened."""
YOUNG_S = 10.0
"""A process that dies younger, and was asked nothing, is started again by the next question alone."""


class ModelProcess:
    """A model named by text, in a process of its own.

    Args:
        spec: `PROVIDER:NAME`, or `local`, as `open_model` has it; what can be checked without opening it was checked.
        memory_gib: How much memory the process may be resident in, with all that descends from it.
        isolated: As `open_model` has it.
    """

    def __init__(self, spec: str, *, memory_gib: float = 2.0, isolated: bool = False) -> None:
        self._spec, self._most_bytes, self._isolated = spec, int(memory_gib * GIB), isolated
        self._lock = threading.Lock()
        self._life: ModelLife | None = None
        self._old: set[ModelLife] = set()
        """Processes that were replaced and have yet to end."""
        self._closed = self._used = False
        self._absent = self._name = ""
        self._numbers = itertools.count(1)
        self._timers = Worker("model's timers")

    @property
    def name(self) -> str:
        return self._name or self._spec.partition(":")[2] or self._spec

    def open(self) -> None:
        """Start the process; returns at once."""
        with self._lock:
            self._closed = False
            self._timers.start()
            self._begin()

    def abilities(self, pending: PendingQuestion) -> Abilities:
        able = self._able(self._current(), pending)
        self._name = able.name
        return able

    def converse(self, mode: OutputMode, form: AnswerForm, pending: PendingQuestion) -> Exchange:
        life = self._current()
        if not life.confirms_within(PROMPT_S) or life.lingering >= MOST_LINGERING:
            self._replace(life)
            life = self._current()
        self._able(life, pending)
        with self._lock:
            self._used = True
        return Exchange(self, life, next(self._numbers), mode, form, pending)

    def _able(self, life: ModelLife, pending: PendingQuestion) -> Abilities:
        try:
            return life.wait_able(pending.when_closed)
        except BudgetExceeded:
            waited_s = time.monotonic() - life.began
            log.warning("the model '%s' is still opening, after %.1f s; its question has ended", self._spec, waited_s)
            raise

    def close(self, within_s: float = PATIENCE_S) -> None:
        """End every process and all that descends from them."""
        with self._lock:
            self._closed = True
            lives = [*self._old, *([self._life] if self._life is not None else [])]
            self._life = None
        until = time.monotonic() + within_s
        for life in lives:
            life.end("it was closed")
        self._timers.close(within_s)
        for life in lives:
            life.join(until - time.monotonic())

    def _current(self) -> ModelLife:
        with self._lock:
            if self._absent:
                raise Absent(self._absent)
            if self._closed:
                raise BudgetExceeded("the run has ended")
            life = self._begin()
        if life.able is None and not life.absent and time.monotonic() - life.began > START_S:
            life.end(f"it was not opened within {START_S:g} s")
            return self._current()
        return life

    def _begin(self) -> ModelLife:
        """The process that lives, or a new one; under the lock."""
        if self._life is None or not self._life.alive:
            self._used = False
            self._life = ModelLife(self._spec, self._most_bytes, self._ended, isolated=self._isolated)
            self._old.add(self._life)
        return self._life

    def _ended(self, life: ModelLife) -> None:
        """A process has ended, on its own or not."""
        with self._lock:
            self._old.discard(life)
            if self._life is not life:
                return
            self._life = None
            self._absent = self._absent or life.absent
            if self._closed:
                return
            if not life.absent and life.able is not None and (self._used or time.monotonic() - life.began > YOUNG_S):
                self._begin()
        if life.absent:
            log.warning("the model '%s' is absent: %s", self._spec, life.absent)
        else:
            log.warning("the process of the model '%s' ended: %s", self._spec, life.why)

    def _replace(self, life: ModelLife, why: str = "it answered no more") -> None:
        """Have another process asked from now on; this one ends with the last answer that is waited for."""
        with self._lock:
            if self._life is life and not self._closed:
                self._life = None
                self._begin()
        if not life.busy:
            life.end(why)

    def dropped(self, life: ModelLife, number: int) -> None:
        """A question was dropped while the model had it: see to it that its process is still of use."""
        self._timers.after(CONFIRM_S, lambda: self._look(life, number))

    def answered(self, life: ModelLife) -> None:
        """An answer has come to a process that may have been replaced."""
        with self._lock:
            is_old = self._life is not life
        if is_old and not life.busy:
            life.end("it was replaced")

    def _look(self, life: ModelLife, number: int) -> None:
        if not life.alive:
            return
        if not life.has_confirmed(number):
            log.warning("the model '%s' holds its process: it is ended, and started again", self._spec)
            self._replace(life)
            life.end("it answered no more")
        elif life.lingers(number):
            self._timers.after(LINGER_S, lambda: self._replace(life) if life.lingers(number) else None)


class Exchange:
    """A conversation with the model in its process."""

    def __init__(
        self,
        model: ModelProcess,
        life: ModelLife,
        number: int,
        mode: OutputMode,
        form: AnswerForm,
        pending: PendingQuestion,
    ) -> None:
        self._model, self._life, self._number, self._pending = model, life, number, pending
        self._first = {"do": "begin", "mode": mode, "schema": form.schema, "tools": list(form.tools)}
        pending.when_closed(self._drop)

    def ask(self, messages: Sequence[BaseMessage]) -> ModelReply | None:
        """The model's answer; see `Conversation`."""
        order, self._first = self._first, {"do": "more"}
        written, blobs = packed(messages)
        call = self._life.ask(self._number, {**order, "id": self._number, "messages": written}, blobs)
        if not self._pending.open:  # it was closed before there was something to drop
            self._drop()
        try:
            return call.wait()
        finally:
            self._model.answered(self._life)

    def _drop(self) -> None:
        if self._life.drop(self._number):
            self._model.dropped(self._life, self._number)

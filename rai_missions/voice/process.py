# SPDX-License-Identifier: Apache-2.0
"""Our end of the process that holds a recogniser, a voice or an ear, which is replaced when it dies or hangs.

Rule: each order gets exactly one end, a reply or a fault, within the time given; nothing here waits.
"""

from __future__ import annotations

import base64
import binascii
import itertools
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.connectors.process.frames import Broken
from rai_missions.connectors.process.life import PATIENCE_S, ProcessLife
from rai_missions.connectors.worker import Work, Worker
from rai_missions.errors import UsageError
from rai_missions.redaction import cut, logger
from rai_missions.voice.kind import SpeechSort

__all__ = ("SpeechProcess", "SpeechReply")

log = logger(__name__)

WORK = "rai_missions.voice.worker:work"
MOST_BYTES = 3 * 2**29
"""How much memory it may be resident in: 1.5 GiB."""
START_S = 60.0
"""How long it may take to be opened."""
YOUNG_S = 5.0
"""One that ends younger, without a reply, is started again by the next order alone."""
LONGEST_TEXT = 4_000


class SpeechReply(NamedTuple):
    """What came of an order."""

    data: Mapping[str, Any] = {}
    fault: str = ""
    """Why there is no reply, in a sentence; empty if there is one."""
    is_lost: bool = False
    """The process ended while it had the order, and in time: the next one may have a reply."""


OnReply = Callable[[SpeechReply], object]


class PendingOrder(NamedTuple):
    """An order whose reply is waited for."""

    life: ProcessLife
    """The process that has it."""
    on_reply: OnReply
    on_part: Callable[[bytes], object] | None
    cancel: Work
    is_late: bool = False


class SpeechProcess:
    """A recogniser, a voice or an ear, by its name, in a process of its own.

    Args:
        sort: What it is.
        name: As the registry has it, or an entry point of another package.
        options: How it is opened.
        within_s: How long a reply may take; after that the process is ended and another is started.
        on_fault: Called with a sentence each time the process ended, hung or could not be opened; None: it is logged.
    """

    def __init__(
        self,
        sort: SpeechSort,
        name: str,
        options: Mapping[str, Any] | None = None,
        *,
        within_s: float = 5.0,
        on_fault: Callable[[str], object] | None = None,
    ) -> None:
        self.sort, self.name = sort, name
        self._options, self._within_s, self._on_fault = dict(options or {}), within_s, on_fault
        self._lock = threading.RLock()
        self._life: ProcessLife | None = None
        self._is_ready, self._replied, self._is_open = False, False, False
        self._is_settled = threading.Event()
        """It is ready, or is not going to be."""
        self._absent = self._ended_by = ""
        self._asked: dict[int, PendingOrder] = {}
        self._numbers = itertools.count(1)
        self._timers = Worker(f"{sort}'s timers")
        self.restarts = 0
        """How often it was started again."""

    @property
    def absent(self) -> str:
        """Why it cannot be opened; empty where it can, or that is not known yet."""
        return self._absent

    def open(self) -> None:
        """Start the process; returns at once."""
        with self._lock:
            self._is_open, self._absent = True, ""
            self._timers.start()
            self._begin()

    def wait_ready(self, within_s: float = START_S) -> bool:
        """Wait until it is open, or cannot be opened; whether it is open."""
        self._is_settled.wait(within_s)
        return self._is_ready

    def wait_open(self) -> None:
        """Wait until it is open.

        Raises:
            UsageError: It cannot be opened; the sentence states what is missing, or how it ended.
        """
        if not self.wait_ready():
            raise UsageError(self._absent or self._ended_by or f"the {self.sort} '{self.name}' does not start")

    def close(self, within_s: float = PATIENCE_S) -> None:
        """End the process and all that descends from it; what was asked ends with a fault."""
        with self._lock:
            self._is_open = False
            life, self._life = self._life, None
        if life is not None:
            life.end("it was closed")
            life.join(within_s)
        self._release("it was closed")
        self._timers.close(within_s)

    def ask(
        self,
        order: Mapping[str, Any],
        blobs: Sequence[bytes] = (),
        *,
        on_reply: OnReply,
        on_part: Callable[[bytes], object] | None = None,
    ) -> None:
        """Send an order; the reply comes on a thread of this object.

        Args:
            order: As `voice.worker` has it.
            blobs: Sound.
            on_reply: Called once.
            on_part: Called with each piece of sound that is made, before the reply.
        """
        with self._lock:
            fault = "" if self._is_open else "it was closed"
            fault = fault or self._absent
            if not fault:
                life = self._begin()
                number = next(self._numbers)
                within_s = self._within_s + (0.0 if self._replied else START_S)
                cancel = self._timers.after(within_s, lambda: self._give_up(number, life, within_s))
                self._asked[number] = PendingOrder(life, on_reply, on_part, cancel)
        if fault:
            on_reply(SpeechReply(fault=f"the {self.sort} '{self.name}': {fault}"))
            return
        life.send({**order, "id": number}, blobs)

    def ask_and_wait(self, order: Mapping[str, Any], blobs: Sequence[bytes] = ()) -> tuple[SpeechReply, bytes]:
        """Send an order, and wait for its reply and all sound before it; for programs that do nothing else."""
        done, sound, found = threading.Event(), bytearray(), list[SpeechReply]()

        def take(reply: SpeechReply) -> None:
            found.append(reply)
            done.set()

        self.ask(order, blobs, on_reply=take, on_part=sound.extend)
        done.wait()
        return found[0], bytes(sound)

    def _begin(self) -> ProcessLife:
        """The process that lives, or a new one; under the lock."""
        if self._life is not None and self._life.alive:
            return self._life
        self._is_settled.clear()
        self._is_ready = self._replied = False
        first = {
            "sort": self.sort,
            "name": self.name,
            "options": self._options,
            "path": [os.path.abspath(entry) for entry in sys.path],
        }
        life = ProcessLife(
            self.sort,
            WORK,
            first,
            MOST_BYTES,
            on_message=lambda message: self._take(life, message),
            on_end=lambda: self._ended(life),
        )
        self._life = life
        life.start()
        return life

    def _take(self, life: ProcessLife, message: Mapping[str, Any]) -> None:
        """One message of the process, which may be anything."""
        with self._lock:
            if life is not self._life:
                return
            if message.get("ready") is True:
                self._is_ready = True
                self._is_settled.set()
                return
            if "absent" in message:
                self._absent = cut(message["absent"], 400)
                return
            number = message.get("reply", message.get("part"))
            asked = self._asked.get(number) if type(number) is int else None
            if asked is None:
                raise Broken("it sent what was not asked for")
            if "reply" in message:
                del self._asked[number]
                self._replied = True
                asked.cancel()
        if "part" in message:
            if asked.on_part is not None:
                asked.on_part(sound_in(message, "sound"))
            return
        fault = cut(message["failed"], 400) if "failed" in message else ""
        asked.on_reply(SpeechReply(message, f"the {self.sort} '{self.name}' failed ({fault})" if fault else ""))

    def _give_up(self, number: int, life: ProcessLife, within_s: float) -> None:
        with self._lock:
            asked = self._asked.get(number)
            if asked is not None:
                self._asked[number] = asked._replace(is_late=True)
        if asked is not None:
            life.end(f"it did not reply within {within_s:g} s")

    def _ended(self, life: ProcessLife) -> None:
        """A process has ended, on its own or not; an order that came meanwhile may have started the next."""
        with self._lock:
            if not self._is_open:
                return  # what was asked of it ends where it is closed
            sentence = self._ended_by = self._absent or f"the {self.sort} '{self.name}' ended: {life.why}"
            asked, again = self._drop_asked(life), self._follow(life)
        if self._on_fault is None:
            log.warning("%s%s", sentence, "; it is started again" if again else "")
        for each in asked:
            each.on_reply(SpeechReply(fault=sentence, is_lost=not (self._absent or each.is_late)))
        if self._on_fault is not None:
            self._on_fault(sentence)

    def _follow(self, life: ProcessLife) -> bool:
        """Whether another process follows one that has ended; under the lock."""
        if life is not self._life:
            again = self._life is not None
        else:
            self._life, self._is_ready = None, False
            again = not self._absent and (self._replied or time.monotonic() - life.began > YOUNG_S)
            if again:
                self._begin()
            else:
                self._is_settled.set()
        self.restarts += again
        return again

    def _drop_asked(self, life: ProcessLife | None = None) -> list[PendingOrder]:
        """Take away what is asked, of one process or of all."""
        dropped = {number: each for number, each in self._asked.items() if life in (None, each.life)}
        self._asked = {number: each for number, each in self._asked.items() if number not in dropped}
        for each in dropped.values():
            each.cancel()
        return list(dropped.values())

    def _release(self, why: str) -> None:
        with self._lock:
            asked = self._drop_asked()
        for each in asked:
            each.on_reply(SpeechReply(fault=f"the {self.sort} '{self.name}': {why}"))


def sound_in(message: Mapping[str, Any], name: str) -> bytes:
    """Sound in a message of the process.

    Raises:
        Broken: There is none.
    """
    try:
        sound = base64.b64decode(message[name], validate=True)
    except (KeyError, TypeError, ValueError, binascii.Error):
        raise Broken(f"it sent no sound '{name}'") from None
    if len(sound) % 2:
        raise Broken(f"it sent half a sample in '{name}'")
    return sound


def text_in(data: Mapping[str, Any], name: str) -> str:
    """A text in a reply; empty where there is none, and cut where it is too long."""
    text = data.get(name)
    return cut(text, LONGEST_TEXT) if isinstance(text, str) else ""

# SPDX-License-Identifier: Apache-2.0
"""The engine's end of one process that holds a model: from its start to the end of everything that descends from it.

Rule: no thread of the engine's waits for the process where something waits for that thread: what is written and what is
read have threads of their own, and whatever asked is released when the process ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rai_missions.answerers.model.chat import Abilities, Absent, BudgetExceeded, Ended
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.process.frames import CHUNK, Broken, Inlet, outward
from rai_missions.answerers.model.process.words import abilities_in, reply_in
from rai_missions.connectors.worker import Worker
from rai_missions.redaction import cut, secrets_held, variables

__all__ = ("Life", "PendingCall")

GUARD = "rai_missions.answerers.model.process.guard"
UNASKED = "it sent what was not asked for"
UNWANTED = "the answer is waited for no longer"
PIPE_BYTES = 1 << 20
REPORT_S = 0.5
"""How long the guard may take to report how the model's process ended."""
PATIENCE_S = 1.0
"""How long the guard may take to end everything; then the session is ended from here."""
ROOT = str(Path(__file__).resolve().parents[3])


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


class Life:
    """One process, from its start to its end.

    Args:
        model: What it holds, by name.
        most_bytes: How much memory it may be resident in, with all that descends from it.
        ended: Called once, on a thread of this object, after everything has ended.
    """

    def __init__(self, model: str, most_bytes: int, ended: Callable[[Life], None]) -> None:
        self._most_bytes, self._on_end = most_bytes, ended
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._ends = False
        self._waiting: list[PendingCall] = []
        self._able: Abilities | None = None
        self._absent = ""
        self._calls: dict[int, PendingCall] = {}
        self._dropped: set[int] = set()
        """Questions that were dropped while the model had them; taken out when its thread comes back."""
        self._unheeded: set[int] = set()
        """Questions whose drop the process has yet to confirm."""
        self._heeds = threading.Event()
        self._heeds.set()
        self._requests, self._orders_fd = os.pipe()
        with contextlib.suppress(OSError, AttributeError):  # a picture is then written at once
            fcntl.fcntl(self._orders_fd, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        first = {
            "model": model,
            "environment": variables(secret=True),
            "path": [os.path.abspath(entry) for entry in sys.path],
            "secrets": secrets_held(),
        }
        # What cannot be written any more is for a process that has ended, which is noticed where replies are read.
        self._orders = Worker("model's orders", on_error=lambda _: None, at_end=partial(os.close, self._orders_fd))
        self._send(first)
        self.began = time.monotonic()
        self.why = ""
        """How it ended; empty while it lives."""
        self._thread = threading.Thread(target=self._live, name="model's process", daemon=True)
        self._thread.start()

    # -- what is asked of it -------------------------------------------------------------------------------------------

    @property
    def able(self) -> Abilities | None:
        """What the model can do; None until it is opened."""
        return self._able

    @property
    def absent(self) -> str:
        """Why the model cannot be opened; empty unless the process reports it."""
        return self._absent

    @property
    def alive(self) -> bool:
        return not self.why and not self._ends

    @property
    def busy(self) -> int:
        """Calls whose answers are waited for."""
        return len(self._calls)

    @property
    def lingering(self) -> int:
        """Questions that were dropped and that the model still has."""
        return len(self._dropped)

    def heeds(self, number: int) -> bool:
        """Whether the drop of a question was confirmed; where it was not, the interpreter there is held."""
        return number not in self._unheeded

    def heeds_within(self, seconds: float) -> bool:
        """Whether every drop was confirmed, or is in so many seconds; waits."""
        return self._heeds.wait(seconds)

    def lingers(self, number: int) -> bool:
        """Whether a question that was dropped is still with the model."""
        return number in self._dropped

    def wait_able(self, when_closed: Callable[[Callable[[], None]], None]) -> Abilities:
        """Wait until it is known what the model can do.

        Args:
            when_closed: Has a function called when the question is closed.

        Raises:
            Absent: The model cannot be opened.
            Ended: The process ended.
            BudgetExceeded: The question was closed.
        """
        call = PendingCall()
        with self._lock:
            if (able := self._able) is not None:
                return able
            if self._absent:
                raise Absent(self._absent)
            if (why := self.why) or self._ends:
                raise Ended(f"the model's process ended: {why or 'it was closed'}")
            self._waiting.append(call)
        when_closed(lambda: call.release(BudgetExceeded(UNWANTED)))
        call.wait()
        able = self.able
        assert able is not None
        return able

    def ask(self, number: int, order: Mapping[str, Any], blobs: Sequence[bytes]) -> PendingCall:
        """Send an order; its reply comes to the call."""
        call = PendingCall()
        with self._lock:
            if self.why or self._ends:
                call.release(Ended(f"the model's process ended: {self.why or 'it was closed'}"))
                return call
            self._calls[number] = call
        self._send(order, blobs)
        return call

    def drop(self, number: int) -> bool:
        """An answer is no longer waited for; whether the model has the question still."""
        with self._lock:
            call = self._calls.pop(number, None)
            if call is not None:
                self._dropped.add(number)
            if self.able is not None:
                self._unheeded.add(number)
                self._heeds.clear()
        self._send({"do": "drop", "id": number})
        if call is None:
            return False
        call.release(BudgetExceeded(UNWANTED))
        return True

    def _send(self, order: Mapping[str, Any], blobs: Sequence[bytes] = ()) -> None:
        self._orders.post(partial(_write_all, self._orders_fd, outward(order, blobs)))

    # -- its end -------------------------------------------------------------------------------------------------------

    def end(self, why: str = "") -> None:
        """Have it end, with all that descends from it; never waits.

        Args:
            why: What is reported to those that wait for an answer, where the guard knows nothing better.
        """
        with self._lock:
            self._ends = True
            self.why = self.why or why
            process = self._process
            if process is not None and process.stdin is not None:
                lifeline, process.stdin = process.stdin, None
                with contextlib.suppress(OSError):
                    lifeline.close()

    def join(self, within_s: float) -> None:
        """Wait until everything has ended; what does not by then is killed from here."""
        self._thread.join(max(0.0, within_s))
        if self._thread.is_alive() and self._process is not None:
            end_session(self._process.pid)
            self._thread.join(PATIENCE_S)

    # -- the threads ---------------------------------------------------------------------------------------------------

    def _live(self) -> None:
        reply_fd, why = -1, ""
        try:
            reply_fd = self._start()
            self._read(reply_fd)
        except Broken as broken:
            why = str(broken)
        except Exception as error:  # noqa: BLE001 - without this, whatever asked would wait for ever
            why = cut(f"{type(error).__name__}: {error}", 200)
        with contextlib.suppress(OSError):
            os.close(reply_fd)
        self._orders.close(0.0)
        self.end(why)
        report = self._conclude()
        with self._lock:
            self.why = why or self.why or report or "it is gone"
            calls, self._calls = list(self._calls.values()), {}
            self._heeds.set()
            waiting, self._waiting = self._waiting, []
        ended = Ended(f"the model's process ended: {self.why}")
        for call in calls:
            call.release(ended)
        for call in waiting:
            call.release(Absent(self._absent) if self._absent else ended)
        self._on_end(self)

    def _start(self) -> int:
        """Start the guard; the descriptor from which replies are read."""
        requests = self._requests
        replies, reply_end = os.pipe()
        command = [sys.executable, "-P", "-m", GUARD, str(requests), str(reply_end), str(self._most_bytes)]
        try:
            with self._lock:
                if self._ends:
                    raise Broken("it was closed")
                self._process = subprocess.Popen(
                    command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                    pass_fds=(requests, reply_end), start_new_session=True, env=_environment(),
                )  # fmt: skip
        except BaseException:
            os.close(replies)
            raise
        finally:
            os.close(requests)
            os.close(reply_end)
        return replies

    def _read(self, fd: int) -> None:
        """Take replies until the process has closed the pipe, or the guard is gone."""
        assert self._process is not None
        assert self._process.stdout is not None
        inlet, guard = Inlet(), self._process.stdout.fileno()
        while True:
            ready, _, _ = select.select([fd, guard], [], [])
            if fd not in ready:
                return
            data = os.read(fd, CHUNK)
            if not data:
                select.select([guard], [], [], REPORT_S)
                return
            for message in inlet.feed(data):
                self._take(message)

    def _take(self, message: Mapping[str, Any]) -> None:
        """One message of the process, which may be anything.

        Raises:
            Broken: It is none that was asked for.
        """
        if "ready" in message and self._able is None:
            able = abilities_in(message)
            with self._lock:
                self._able = able
                waiting, self._waiting = self._waiting, []
            for call in waiting:
                call.release(None)
        elif "absent" in message and self._able is None:
            self._absent = cut(message["absent"], 400)
        elif type(number := message.get("dropped")) is int and number in self._unheeded:
            with self._lock:
                self._unheeded.discard(number)
                if not self._unheeded:
                    self._heeds.set()
        elif type(number := message.get("reply")) is int:
            self._reply(number, message)
        else:
            raise Broken(UNASKED)

    def _reply(self, number: int, message: Mapping[str, Any]) -> None:
        with self._lock:
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
            call.release(Ended(f"the model's process was ended: {broken}"))
            raise
        except BaseException as raised:  # noqa: BLE001 - what the model raised goes to whatever asked
            call.release(raised)

    def _conclude(self) -> str:
        """Wait for the guard, then see to it that nothing of the session is left; what the guard reports."""
        process = self._process
        if process is None:
            return ""
        try:
            words, _ = process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            words = b""
        if not words:
            end_session(process.pid)
            process.kill()
            process.communicate()
        try:
            return cut(json.loads(words)["ended"], 200)
        except (ValueError, KeyError, TypeError):
            return "its guard was killed"


def end_session(session: int) -> None:
    """Kill all that is left of a session, and of the groups in it."""
    with contextlib.suppress(OSError):
        os.killpg(session, signal.SIGKILL)
    for name in os.listdir("/proc") if os.path.isdir("/proc") else ():
        if name.isdecimal():
            with contextlib.suppress(OSError):
                if os.getsid(int(name)) == session:
                    os.kill(int(name), signal.SIGKILL)


def _environment() -> dict[str, str]:
    """What the process is begun with: no secret, since others may read it; and a way to this package."""
    given = variables(secret=False)
    if not any(part in ("site-packages", "dist-packages") for part in Path(ROOT).parts):
        given["PYTHONPATH"] = os.pathsep.join(filter(None, (ROOT, given.get("PYTHONPATH"))))
    return given


def _write_all(fd: int, pieces: Sequence[bytes]) -> None:
    for piece in pieces:
        data = memoryview(piece)
        while data:
            data = data[os.write(fd, data) :]

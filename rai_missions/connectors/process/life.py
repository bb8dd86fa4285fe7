# SPDX-License-Identifier: Apache-2.0
"""Our end of one process: from its start to the end of everything that descends from it.

Rule: no thread waits for the process where something waits for that thread: what is written and what is read have
threads of their own.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rai_missions.connectors.process.frames import CHUNK, Broken, Inlet, outward, write_all
from rai_missions.connectors.readable import readable
from rai_missions.connectors.worker import Worker
from rai_missions.errors import raised_text
from rai_missions.redaction import cut, variables

__all__ = ("PATIENCE_S", "ProcessLife")

GUARD = "rai_missions.connectors.process.guard"
PIPE_BYTES = 1 << 20
REPORT_S = 0.5
"""How long the guard may take to report how the process ended."""
PATIENCE_S = 1.0
"""How long the guard may take to end everything; then the session is ended from here."""
ROOT = str(Path(__file__).resolve().parents[3])


class ProcessLife:
    """One process, from its start to its end.

    Args:
        name: What it holds, for the names of threads: `model`.
        work: What it does, as `module:function`, a module of ours; called with the descriptors of requests and replies.
        first: The first order that it receives.
        most_bytes: How much memory it may be resident in, with all that descends from it.
        on_message: Called with each message of the process, on a thread of this object; raises `Broken` for what was
            not asked for, which ends the process.
        on_end: Called once, on the same thread, after everything has ended.
    """

    def __init__(
        self,
        name: str,
        work: str,
        first: Mapping[str, Any],
        most_bytes: int,
        *,
        on_message: Callable[[Mapping[str, Any]], object],
        on_end: Callable[[], object],
    ) -> None:
        self._work, self._most_bytes, self._on_message, self._on_end = work, most_bytes, on_message, on_end
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._ends = False
        self._requests, self._orders_fd = os.pipe()
        with contextlib.suppress(OSError, AttributeError):  # a picture is then written at once
            fcntl.fcntl(self._orders_fd, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        # What cannot be written any more is for a process that has ended, which is noticed where replies are read.
        self._orders = Worker(f"{name}'s orders", on_error=lambda _: None, at_end=partial(os.close, self._orders_fd))
        self.send(first)
        self.began = time.monotonic()
        """When it was made."""
        self.why = ""
        """How it ended; empty while it lives."""
        self._thread = threading.Thread(target=self._live, name=f"{name}'s process", daemon=True)

    def start(self) -> None:
        """Start the process; returns at once."""
        self._thread.start()

    @property
    def alive(self) -> bool:
        return not self.why and not self._ends

    def send(self, order: Mapping[str, Any], blobs: Sequence[bytes] = ()) -> None:
        """Send an order; never waits."""
        self._orders.post(partial(write_all, self._orders_fd, outward(order, blobs)))

    def end(self, why: str = "") -> None:
        """Have it end, with all that descends from it; never waits.

        Args:
            why: What is reported of its end, where the guard knows nothing better.
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

    def _live(self) -> None:
        reply_fd, why = -1, ""
        try:
            reply_fd, guard_fd = self._start()
            self._read(reply_fd, guard_fd)
        except Broken as broken:
            why = str(broken)
        except Exception as error:  # noqa: BLE001 - without this, whatever asked would wait for ever
            why = cut(raised_text(error), 200)
        with contextlib.suppress(OSError):
            os.close(reply_fd)
        self._orders.close(0.0)
        self.end(why)
        report = self._conclude()
        with self._lock:
            self.why = why or self.why or report or "it is gone"
        self._on_end()

    def _start(self) -> tuple[int, int]:
        """Start the guard; the descriptors from which replies, and the guard's report, are read."""
        requests = self._requests
        replies, reply_end = os.pipe()
        given = map(str, (requests, reply_end, self._most_bytes))
        try:
            with self._lock:
                if self._ends:
                    raise Broken("it was closed")
                process = self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", GUARD, self._work, *given],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    pass_fds=(requests, reply_end),
                    start_new_session=True,
                    env=_environment(),
                )
        except BaseException:
            os.close(replies)
            raise
        finally:
            os.close(requests)
            os.close(reply_end)
        assert process.stdout is not None
        return replies, process.stdout.fileno()

    def _read(self, fd: int, guard: int) -> None:
        """Take replies until the process has closed the pipe, or the guard is gone."""
        inlet = Inlet()
        while True:
            if fd not in readable(fd, guard):
                return
            data = os.read(fd, CHUNK)
            if not data:
                readable(guard, within_s=REPORT_S)
                return
            for message in inlet.feed(data):
                self._on_message(message)

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

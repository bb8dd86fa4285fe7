# SPDX-License-Identifier: Apache-2.0
"""Another program as an agent: in a process and a session of its own, of which nothing is left after its end."""

from __future__ import annotations

import signal
import subprocess
import threading
from collections import deque
from collections.abc import Mapping, Sequence

from rai_missions.agents.agent import AgentHealth
from rai_missions.connectors.process.life import end_session
from rai_missions.errors import UsageError
from rai_missions.redaction import cut, shown

__all__ = ("ProcessAgent",)

MOST_LINES, LONGEST_LINE = 20, 4096
"""How many of the last lines of stderr are kept, and how many characters of each."""
CLOSES_S = 1.5
"""What is left after a program's time to end: it is killed, and its last lines are read."""
END_SIGNALS = frozenset({signal.SIGTERM, signal.SIGINT, signal.SIGHUP})
"""What asks a program to end; a shell adds 128 to the number of one that has ended it."""


class ProcessAgent:
    """A program that is run; it ends on SIGTERM, or is killed.

    Args:
        command: The program and its arguments; no shell reads them.
        stop_s: How long it may take to end; a run of a mission needs its `cancel_s`.
        environment: Its variables; this process's own where left out.

    Raises:
        UsageError: The command is no list of words.
    """

    def __init__(
        self, command: Sequence[str], *, stop_s: float = 1.5, environment: Mapping[str, str] | None = None
    ) -> None:
        if isinstance(command, str) or not command:
            words = command.split() if isinstance(command, str) and command.strip() else ["sleep", "600"]
            raise UsageError(f"a program is a list of its words, such as {words}, not {shown(command)}")
        self._command, self._stop_s, self._environment = tuple(command), stop_s, environment
        self._process: subprocess.Popen[str] | None = None
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self._reader: threading.Thread | None = None
        self._is_stopped = False
        self._is_clean = True
        self._lock = threading.Lock()

    def run(self) -> None:
        """Begin it; one that has ended begins again.

        Raises:
            OSError: There is no such program, or it may not be run.
        """
        if self._process is not None and self._process.poll() is None:
            return
        self._clean_up()
        self._lines.clear()
        self._is_stopped = False
        process = subprocess.Popen(
            self._command,
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,
            env=dict(self._environment) if self._environment is not None else None,
        )
        self._process, self._is_clean = process, False
        self._reader = threading.Thread(target=self._read, args=(process,), name="agent's errors", daemon=True)
        self._reader.start()

    @property
    def stop_s(self) -> float:
        """How long `stop` may take."""
        return self._stop_s + CLOSES_S

    def stop(self) -> None:
        """Have it end by SIGTERM; what is left of its session after `stop_s` is killed."""
        process = self._process
        if process is None:
            return
        self._is_stopped = self._is_stopped or process.poll() is None
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(self._stop_s)
            except subprocess.TimeoutExpired:
                pass
        if process.poll() is None:
            process.kill()
            process.wait()
        self._clean_up()
        if self._reader is not None:
            self._reader.join(1.0)

    @property
    def health(self) -> AgentHealth:
        """How it fares; failed, where it ended by itself with another status than 0, and died, where a signal ended it.

        Signals that ask a program to end, and the exit status that shells give for them, are a stop by another.
        """
        process = self._process
        if process is None:
            return AgentHealth("ready")
        status = process.poll()
        values = {"pid": str(process.pid)}
        if status is None:
            return AgentHealth("running", "", values)
        self._clean_up()
        if self._is_stopped:
            return AgentHealth("stopped", "", values)
        if status == 0:
            return AgentHealth("ended", "", values)
        how = f"ended by {signal.Signals(-status).name}" if status < 0 else f"exit status {status}"
        if (-status if status < 0 else status - 128) in END_SIGNALS:
            return AgentHealth("stopped", how, values)
        if self._reader is not None:
            self._reader.join(0.2)
        last = next((line for line in reversed(self._lines) if line.strip()), "")
        why = f"{how}: {cut(last.strip(), 200)}" if last else how
        return AgentHealth("died" if status < 0 else "failed", why, values)

    def _clean_up(self) -> None:
        """End what is left of its session, once and as soon as its end is known: the number may be another's later."""
        with self._lock:
            if not self._is_clean and self._process is not None:
                self._is_clean = True
                end_session(self._process.pid)

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stderr is not None
        with process.stderr:
            is_begun = False  # a program that never ends its line is not kept whole
            while piece := process.stderr.readline(LONGEST_LINE):
                if not is_begun:
                    self._lines.append(piece)
                is_begun = not piece.endswith("\n")

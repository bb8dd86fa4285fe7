# SPDX-License-Identifier: Apache-2.0
"""The rows of talk in a run's journal: notes next to its steps, which replay ignores and a reader finds by `talk`.

Rule: nothing of talk is a step. A note is written by the run's own thread while it lasts, and here after its end.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping
from typing import Any, Protocol

from rai_missions.agents.talk.doors import TalkLine
from rai_missions.conversation import TalkNote
from rai_missions.errors import MissionError
from rai_missions.redaction import Redaction, cut, logger
from rai_missions.runtime.runner import Runner

__all__ = ("TALK", "NoteSink", "TalkJournal")

log = logger(__name__)
TALK = "talk"
"""The field of a note's data in which talk is."""
LONGEST = 2_000
"""Characters of one text in a row."""


class NoteSink(Protocol):
    """What takes a note once the run is over: `rai_missions.journal.Journal`."""

    def note(self, text: str, data: Any = None) -> int: ...


class TalkJournal:
    """Where the talk of one run is written down.

    Args:
        runner: The run.
        journal: Its journal, for what follows its end; None where it has none.
    """

    def __init__(self, runner: Runner, journal: NoteSink | None) -> None:
        self._runner, self._journal = runner, journal
        self._lock = threading.Lock()
        self._rows: deque[tuple[str, Any]] = deque()
        self._is_over = False
        self._redaction = Redaction()

    def write(self, note: TalkNote) -> None:
        """Have a note written; the caller waits for no disk while the run lasts."""
        data: Mapping[str, Any] = {"kind": note.kind, "at": round(note.at, 3), **_bounded(note.data)}
        words = cut(str(data.get("text", "")), 200)
        self._put(f"talk, {note.kind}{f': {words}' if words else ''}", {TALK: self._redaction.json(dict(data))})

    def _put(self, text: str, data: Any) -> None:
        with self._lock:
            self._rows.append((self._redaction.text(text), data))
            is_over = self._is_over
        if is_over:
            self._flush_over()
        else:
            self._runner.call_soon(self._flush)

    def line(self, line: TalkLine) -> None:
        """Have a line of the conversation written, for the page of a journal."""
        data = {"line": self._redaction.json(_bounded(line._asdict()))}
        self._put(f"{line.by}: {cut(line.text, 200)}", data)

    def close(self) -> None:
        """The run is over: its journal is still open, and what follows is written to it from here."""
        with self._lock:
            self._is_over = True
        self._flush_over()

    def _flush(self) -> None:
        """On the run's thread."""
        with self._lock:
            rows, self._rows = tuple(self._rows), deque()
        for row in rows:
            self._runner.note(*row)

    def _flush_over(self) -> None:
        with self._lock:
            rows, self._rows = tuple(self._rows), deque()
            for row in rows if self._journal is not None else ():
                try:
                    self._journal.note(*row)  # type: ignore[union-attr]  # the loop is empty without one
                except (MissionError, OSError) as error:
                    log.warning("a row of talk could not be written: %s", cut(error, 200))


def _bounded(value: Any) -> Any:
    """Values as JSON has them, texts cut."""
    if isinstance(value, str):
        return value if len(value) <= LONGEST else cut(value, LONGEST)
    if isinstance(value, Mapping):
        return {str(name): _bounded(item) for name, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_bounded(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float) else cut(str(value), LONGEST)

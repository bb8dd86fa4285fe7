# SPDX-License-Identifier: Apache-2.0
"""The talk of a run in its journal: notes between its steps, which replay leaves out, and a reader finds by field.

Rule: nothing of talk is a step. A note is written by the run's own thread while it lasts, and here after its end. What
has come since the note before is one note, so that much talk costs the run no more writes than little.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from rai_missions.agents.talk.doors import TalkLine
from rai_missions.conversation import TalkNote
from rai_missions.errors import MissionError
from rai_missions.journal.rows import Note
from rai_missions.redaction import Redaction, cut, logger
from rai_missions.runtime.runner import Runner

__all__ = ("NoteSink", "TalkJournal", "earlier_lines", "waiting_requests")

log = logger(__name__)
TALK, LINES = "talk", "lines"
"""The fields of a note's data: what happened in the conversation, and the lines that its page shows."""
LONGEST = 2_000
"""Characters of one text."""
MOST_EARLIER = 100
"""Lines of an earlier process that are shown again."""


class NoteSink(Protocol):
    """What takes a note once the run is over: `rai_missions.journal.Journal`."""

    def note(self, text: str, data: Any = None) -> int: ...


def waiting_requests(notes: Sequence[Note]) -> tuple[str, ...]:
    """The requests that waited when the last word of them was written, each in words, by a journal's notes."""
    talks = (note.data.get(TALK) or () for note in reversed(notes) if isinstance(note.data, Mapping))
    rows = (row for talk in talks for row in reversed(talk) if isinstance(row, Mapping))
    last = next((row for row in rows if row.get("kind") == "waiting"), {})
    return tuple(map(str, last.get("requests") or ()))


def earlier_lines(notes: Sequence[Note]) -> tuple[TalkLine, ...]:
    """The last lines of the conversation in a journal's notes, as they were shown last, oldest first."""
    found = dict[int, TalkLine]()
    for note in notes:
        given = note.data.get(LINES) if isinstance(note.data, Mapping) else None
        for data in given if isinstance(given, list) else ():
            line = _line_of(data)
            if line is not None:
                found[line.number] = line
    return tuple(found[number] for number in sorted(found)[-MOST_EARLIER:])


def _line_of(data: Any) -> TalkLine | None:
    """A line as it was written; None for what is none."""
    if not isinstance(data, Mapping) or type(data.get("number")) is not int or not isinstance(data.get("text"), str):
        return None
    known = {name: value for name, value in data.items() if name in TalkLine._fields}
    return TalkLine(**{"by": "robot", **known})


class TalkRows(NamedTuple):
    """What is to be written with the next note."""

    words: list[str]
    talk: list[Any]
    lines: list[Any]


class TalkJournal:
    """Where the talk of one run is written down.

    Args:
        runner: The run.
        journal: Its journal, for what follows its end; None where it has none.
    """

    def __init__(self, runner: Runner, journal: NoteSink | None) -> None:
        self._runner, self._journal = runner, journal
        self._lock = threading.Lock()
        self._rows = TalkRows([], [], [])
        self._is_over = self._is_asked = False
        self._redaction = Redaction()

    def write(self, note: TalkNote) -> None:
        """Have a note written; the caller waits for no disk while the run lasts."""
        data = self._redaction.json(_bounded({"kind": note.kind, "at": round(note.at, 3), **note.data}))
        with self._lock:
            self._rows.talk.append(data)
        self._ask()

    def line(self, line: TalkLine) -> None:
        """Have a line of the conversation written, for people and for the page of a journal."""
        data = self._redaction.json(_bounded(line._asdict()))
        with self._lock:
            self._rows.lines.append(data)
            self._rows.words.append(f"{data['by']}: {cut(data['text'], 200)}")
        self._ask()

    def close(self) -> None:
        """The run is over: its journal is still open, and what follows is written to it from here."""
        with self._lock:
            self._is_over = True
        self._flush_over()

    def _ask(self) -> None:
        with self._lock:
            is_over, is_asked = self._is_over, self._is_asked
            self._is_asked = True
        if is_over:
            self._flush_over()
        elif not is_asked:
            self._runner.call_soon(self._flush)

    def _taken(self) -> tuple[str, Any] | None:
        """What waits, as one note; under the lock."""
        rows, self._rows, self._is_asked = self._rows, TalkRows([], [], []), False
        if not rows.talk and not rows.lines:
            return None
        return cut(" · ".join(rows.words), 1_000) or "talk", {TALK: rows.talk, LINES: rows.lines}

    def _flush(self) -> None:
        """On the run's thread."""
        with self._lock:
            note = self._taken()
        if note is not None:
            self._runner.note(*note)

    def _flush_over(self) -> None:
        with self._lock:
            note = self._taken()
            if note is None or self._journal is None:
                return
            try:
                self._journal.note(*note)
            except (MissionError, OSError) as error:
                log.warning("the end of the talk could not be written: %s", cut(error, 200))


def _bounded(value: Any) -> Any:
    """Values as JSON has them, texts cut."""
    if isinstance(value, str):
        return value if len(value) <= LONGEST else cut(value, LONGEST)
    if isinstance(value, Mapping):
        return {str(name): _bounded(item) for name, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_bounded(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float) else cut(str(value), LONGEST)

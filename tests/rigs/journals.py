# SPDX-License-Identifier: Apache-2.0
"""The rig for journals: one in memory, what a file holds, and generated steps with every effect and kind of value."""

from __future__ import annotations

import shutil
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, get_args

from hypothesis import strategies as st

from rai_missions.engine.decision import Evidence, Limits, Offer, Question, Verdict, VerdictKind
from rai_missions.engine.modes import MODES
from rai_missions.engine.step import (
    Ask,
    CallService,
    CancelGoal,
    Handover,
    LogLine,
    Move,
    PublishMessage,
    Refusal,
    SayAloud,
    StartGoal,
    Step,
    Withdraw,
)
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Record, read, verify
from rai_missions.journal.rows import JournalRow, Raw, StepRow
from rai_missions.replay.replay import Replay, replay
from rai_missions.states.control import HOLDERS

__all__ = (
    "MemoryJournal", "anomalies", "assert_whole", "blackboard_writes", "cut_after_each", "listing",
    "raw_rows_of", "rows_of", "shown", "steps", "steps_of", "values",
)  # fmt: skip

PATIENCE_S = 30.0


def anomalies(count: int) -> list[Step]:
    """Steps of a run in which the same event comes every half second."""
    return [Step(seq, seq / 2, Event("anomaly", seq / 2, {"n": seq})) for seq in range(1, count + 1)]


def listing(folder: Path) -> dict[str, tuple[bytes, int]]:
    """What is in a folder: name → content, and when it was written."""
    return {item.name: (item.read_bytes(), item.stat().st_mtime_ns) for item in folder.iterdir()}


def steps_of(path: Path) -> list[Step]:
    """The steps of a journal's file."""
    with read(path) as record:
        return list(record.steps())


def rows_of(path: Path) -> list[JournalRow]:
    """The rows of a journal's file behind the first."""
    with read(path) as record:
        return list(record.rows())


def raw_rows_of(path: Path) -> list[Raw]:
    """All rows of a journal's file, as they are stored; no hash is checked."""
    with Record(path) as record:
        return list(record.raw())


def cut_after_each(path: Path, wanted: Callable[[Step], bool] = lambda step: True) -> Iterator[tuple[Step, Path]]:
    """Each step of a journal's file, the last first, with the file of a process that was killed right after its row.

    Args:
        path: The journal.
        wanted: Which steps; all by default.
    """
    cut = path.with_name(f"cut-{path.name}")
    shutil.copy(path, cut)
    for row in reversed([row for row in rows_of(path) if isinstance(row, StepRow) and wanted(row.step)]):
        with closing(sqlite3.connect(cut)) as database, database:
            database.execute("DELETE FROM rows WHERE number > ?", (row.row,))
        yield row.step, cut


def assert_whole(path: Path) -> Replay:
    """A journal's file has nothing wrong, no step and no goal twice, and its run can be repeated; gives the repeat."""
    assert verify(path) == ()
    again = replay(path)
    assert again.holds, again.difference
    steps = steps_of(path)
    assert [step.seq for step in steps] == sorted({step.seq for step in steps})
    numbers = [each.number for step in steps for each in step.effects if isinstance(each, StartGoal)]
    assert len(numbers) == len(set(numbers))
    return again


class MemoryJournal:
    """A journal in memory, whose disk may be full, or hang.

    Args:
        rows: How many rows it holds.
        hangs_at: The event whose step the disk does not take before a test sets `answers`; `hangs` is set then.
    """

    path = Path("memory")

    def __init__(self, rows: int = 10**9, *, hangs_at: str = "") -> None:
        self._room, self._hangs_at = rows, hangs_at
        self.hangs, self.answers = threading.Event(), threading.Event()
        self.steps: list[Step] = []
        self.quiet: list[Any] = []
        self.notes: list[str] = []
        self.on_write: Callable[[Step], None] = lambda step: None

    def write(self, step: Step, *, since: float, quiet: Any = (), performed: Any = ()) -> int:
        self.on_write(step)
        if step.event.name == self._hangs_at:
            self.hangs.set()
            assert self.answers.wait(PATIENCE_S)
        if len(self.steps) >= self._room:
            raise ConnectorError("the disk is full")
        self.steps.append(step)
        self.quiet += quiet
        return len(self.steps)

    def confirm(self, number: int, how: str) -> int:
        return len(self.steps)

    def note(self, text: str, data: Any = None) -> int:
        self.notes.append(text)
        return 0


# -- generated steps --------------------------------------------------------------------------------------------------

names = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
words = st.text(max_size=12)
instants = st.floats(min_value=0, max_value=1e9, allow_nan=False)
numbers = st.integers(0, 10_000)
images = st.builds(
    Image,
    names.map("camera@{}".format),
    st.integers(1, 4),
    st.integers(1, 4),
    st.sampled_from(["rgb8", "png"]),
    st.binary(max_size=48),
)
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    words,
    st.text(alphabet="\ud800a\x00é", max_size=3),
    images,
)


def _nested(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    keys = words | st.sampled_from(["$image", "$tuple", "$object", "$", "number"])
    return st.one_of(
        st.lists(inner, max_size=3), st.lists(inner, max_size=2).map(tuple), st.dictionaries(keys, inner, max_size=3)
    )


values = st.recursive(scalars, _nested, max_leaves=6)
"""Whatever a blackboard or an event can hold."""
objects = st.dictionaries(words, values, max_size=3)
texts = st.lists(words, max_size=3).map(tuple)

kinds = ("event", "tick", "write", "accepted", "feedback", "result", "proposal", "control", "behaviour", "command")
events = st.builds(Event, words, instants, objects, st.sampled_from(kinds), numbers)
moves = st.builds(Move, texts, texts, texts, words)
offers = st.builds(Offer, names, words, st.none() | objects)
evidence = st.builds(Evidence, names, values, st.none() | instants, st.booleans())
limits = st.builds(Limits, numbers, numbers, st.none() | instants)
endings = instants | st.just(float("inf"))
offered, shown = (st.lists(part, max_size=3).map(tuple) for part in (offers, evidence))
questions = st.builds(
    Question, numbers, words, names, words, offered, shown, numbers, instants, endings, texts, texts, limits
)
effects = st.one_of(
    st.builds(StartGoal, numbers, words, names, objects),
    st.builds(CancelGoal, numbers, names),
    st.builds(CallService, numbers, words, names, objects, st.none() | instants),
    st.builds(PublishMessage, names, objects),
    st.builds(SayAloud, words),
    st.builds(LogLine, words),
    st.builds(Ask, questions),
    st.builds(Withdraw, numbers),
    st.builds(Handover, names),
)
verdicts = st.builds(
    Verdict, st.booleans(), words, st.sampled_from(get_args(VerdictKind)), numbers, words, words, st.none() | numbers
)
steps = st.builds(
    Step,
    numbers,
    instants,
    events,
    st.lists(moves, max_size=3).map(tuple),
    st.lists(st.tuples(words, st.sampled_from([True, False, None])), max_size=3).map(tuple),
    st.lists(st.tuples(names, values), max_size=3).map(tuple),
    st.none() | st.sampled_from(["succeeded", "failed", "aborted", "canceled"]),
    st.none() | instants,
    st.lists(effects, max_size=4).map(tuple),
    words,
    texts,
    texts,
    st.sampled_from(MODES),
    st.none() | st.sampled_from(HOLDERS),
    st.lists(verdicts, max_size=2).map(tuple),
    st.sampled_from(get_args(Refusal)),
    st.booleans(),
)
blackboard_writes = st.lists(st.tuples(names, values, instants), max_size=3, unique_by=lambda write: write[0])


def shown(number: int, image: Image) -> Step:
    """A step that asks a question with a picture, which its journal keeps."""
    evidence = (Evidence("camera", image, 0.1, fresh=True),)
    question = Question(number=number, owner="asking", asked="agent", text="?", options=(), evidence=evidence)
    return Step(number, float(number), Event("start", float(number), kind="command"), effects=(Ask(question),))

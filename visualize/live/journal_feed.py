# SPDX-License-Identifier: Apache-2.0
"""A run of another process, or of yesterday, followed by its journal.

Rule: the run is not asked, slowed or locked; the file is looked at here, and only while someone watches.
"""

from __future__ import annotations

import asyncio
import fcntl
import itertools
import json
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from rai_missions.errors import DefinitionError, Fault, MissionError
from rai_missions.journal import Header, Note, StepRow
from rai_missions.journal.lock import Lock
from rai_missions.journal.reader import Record
from rai_missions.journal.rows import GENESIS, Raw, chained
from rai_missions.mission.mission import Mission
from rai_missions.redaction import shown
from visualize.live.scene import RunScene

__all__ = ("JournalFeed",)

LOOKS_EVERY_S = 0.1
ASKS_EVERY = 10
"""Looks after which it is asked whether anybody still writes."""
CUT_SHORT = "no process writes its journal any more, and no end of the mission is in it"
CONTINUES = "it continues in another mission, and its journal is next to this one: {}"
PLAYED = "a person was the robot (rai-missions try): it is no evidence of what a robot does"
BATCH = 2000
"""Rows that are read before what they state is passed on."""


class JournalFeed:
    """Follows a journal file, also while another process writes it.

    Args:
        path: The file.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal, or holds no mission that can be drawn.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        with Record(self.path) as record:
            self.header: Header = record.header
        self.mission = _mission(self.header, self.path)
        """Whose run it is."""
        self._scene = self._beginning()
        self._number, self._hash = -1, GENESIS
        self._size: tuple[object, ...] = ()
        self._cut = PLAYED if self.header.played else CUT_SHORT
        """Why no more comes where no process writes the journal and no end is in it."""
        self._received_at = time.monotonic()
        self._watch: asyncio.Task[None] | None = None

    def _beginning(self) -> RunScene:
        keys = self.mission.blackboard.items()
        initial = {name: (key.initial, 0.0) for name, key in keys if key.initial is not None}
        board = initial | {name: (value, 0.0) for name, value in self.header.arguments.items()}
        return RunScene(board=board, keys=self.mission.blackboard)

    async def begin(self, wake: Callable[[], None]) -> RunScene:
        while not await asyncio.to_thread(self._read):
            pass
        self._scene.change()
        self._watch = asyncio.create_task(self._look(wake))
        return self._scene

    async def take(self, scene: RunScene) -> RunScene:
        await asyncio.to_thread(self._read)
        return scene

    def end(self) -> None:
        if self._watch is not None:
            self._watch.cancel()
            self._watch = None

    def closed(self) -> Mapping[int, Mapping[str, str]]:
        """A journal carries no answers."""
        return {}

    def now(self) -> float:
        scene = self._scene
        return scene.at if scene.outcome or scene.cut else scene.at + time.monotonic() - self._received_at

    async def _look(self, wake: Callable[[], None]) -> None:
        for count in itertools.count(1):
            await asyncio.sleep(LOOKS_EVERY_S)
            asks = count % ASKS_EVERY == 0 and not (self._scene.outcome or self._scene.cut)
            if self._stat() != self._size or (asks and not await asyncio.to_thread(_is_written, self.path)):
                wake()

    def _stat(self) -> tuple[object, ...]:
        found: list[object] = []
        for path in (self.path, self.path.with_name(f"{self.path.name}-wal")):
            try:
                stat = path.stat()
            except OSError:
                found.append(None)
            else:
                found += [stat.st_ino, stat.st_size, stat.st_mtime_ns]
        return tuple(found)

    def _read(self) -> bool:
        """Resume what has been written since; whether that was all."""
        size, continues = self._stat(), _is_written(self.path)  # asked first: what was written before is read below
        try:
            record = Record(self.path)  # closed with the last picture that may be asked of it
            for count, raw in enumerate(record.raw(self._number)):
                if count >= BATCH:
                    return False
                self._follow(record, raw)
        except MissionError as error:
            self._scene.fault(str(error))
        self._size = size
        self._scene.cut_short("" if continues or self._scene.outcome else self._cut)
        return True

    def _follow(self, record: Record, raw: Raw) -> None:
        number, kind, content, digest = raw
        if number != self._number + 1 or not _is_text(raw) or chained(self._hash, number, kind, content) != digest:
            self._scene.fault(f"row {number}: it does not follow from the row before; the journal was altered")
        self._number, self._hash = number, str(digest)
        if number == 0:
            return
        self._received_at = time.monotonic()
        try:
            row = record.row(raw)
        except DefinitionError as error:
            self._scene.fault(str(error))
            return
        if isinstance(row, StepRow):
            self._scene.take(row.step, row.before)
        elif isinstance(row, Note):
            self._follow_note(row)

    def _follow_note(self, note: Note) -> None:
        data = note.data if isinstance(note.data, dict) else {}
        if isinstance(goals := data.get("open_goals"), list):
            self._scene.set_open_goals(goals)
        elif isinstance(lines := data.get("lines"), list):
            for line in lines:
                if isinstance(line, dict):
                    self._scene.add_talk(line)
        elif note.successor is not None:
            self._cut = CONTINUES.format(shown(str(note.successor["journal"])))
        elif "broken_off" in data:
            self._scene.fault(note.text)


def _is_text(raw: Raw) -> bool:
    return all(isinstance(part, str) for part in raw[1:])


def _mission(header: Header, path: Path) -> Mission:
    if not header.mission:
        sentence = "its mission has behaviours in Python and is not in the journal; watch it with run --watch"
        raise DefinitionError([Fault("row 0", sentence)], str(path))
    try:
        return Mission.model_validate(json.loads(header.mission))
    except (ValueError, RecursionError) as error:
        raise DefinitionError([Fault("row 0", f"no mission can be read here: {error!s:.200}")], str(path)) from None


def _is_written(path: Path) -> bool:
    """Whether some process writes a journal now.

    Where the file system knows no locks, the process counts that the run file next to the journal names; without a run
    file there is no one.
    """
    try:
        about = path.stat()
        if (about.st_dev, about.st_ino) in Lock.held:
            return True  # to open it again here would drop this process's own locks
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return _is_named(path)
    finally:
        os.close(descriptor)
    return False


def _is_named(path: Path) -> bool:
    try:
        pid = json.loads(Path(f"{path}.watch").read_text(encoding="utf-8"))["pid"]
        os.kill(pid, 0)
    except PermissionError:
        return True
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return False
    return True

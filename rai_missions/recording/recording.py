# SPDX-License-Identifier: Apache-2.0
"""A recording that is being made: takes what others hand it, from any thread, and writes it on one of its own.

Rule: once it has begun no method raises, and none waits but `close`.
"""

from __future__ import annotations

import atexit
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, Self

from rai_missions.connectors.connector import Message, RawMessage, Reply, Report
from rai_missions.connectors.worker import Worker
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.journal import Blob, Raw, Record
from rai_missions.mission.mission import Mission
from rai_missions.recording.encoder import JOURNAL_TOPIC, TOPIC, MessageEncoder, When
from rai_missions.recording.file import RecordingFile, cannot_write, make_file
from rai_missions.recording.json_messages import call_of, image_in, report_of, status_of, without_bytes, write_of
from rai_missions.recording.queue import QueuedItem, RecordingQueue, Route, packed, unpacked
from rai_missions.recording.schemas import BLACKBOARD, CALL, GOAL, STATUS, Schema
from rai_missions.redaction import logger
from rai_missions.runtime.lifecycle import Status

__all__ = ("FORMAT", "Recording", "Summary")

log = logger(__name__)

FORMAT = "1"
FLUSH_S = 1.0
"""How much a process that is killed may lose of its recording."""
SPELL_S, REST_S = 0.002, 0.02
"""How long the thread writes at once, and how long it rests then."""
LATE_S, LONG_REST_S = 0.002, 0.12
"""Where the thread comes out of its rest so late, others are at work: it rests longer, and takes 1.5 % of the time. So
it does where more comes than it writes: the rest is written afterwards either way."""
GATHER_S = 0.05
"""How long the thread lets items gather before it begins."""
PATIENCE_S = 60.0
"""How long the end waits for what is still to be written."""
MESSAGE, PICTURE, RAW, ROW, CALLED, REPORTED, WRITTEN, STATUS_NOW = range(8)
"""The numbers of the routes."""
CALLS, GOALS, WRITES, STATUSES = (f"{TOPIC}{name}" for name in ("calls", "goals", "blackboard", "status"))


class Summary(NamedTuple):
    """What became of a recording."""

    path: str
    messages: int
    size: int
    """Bytes of the file."""
    dropped: Mapping[str, int]
    """Topic → how many of its messages found no room."""
    why: str = ""
    """Why it stopped before the run did; empty if it did not."""

    def __str__(self) -> str:
        lost = f", {sum(self.dropped.values())} dropped" if self.dropped else ""
        broken = f", broken off: {self.why}" if self.why else ""
        return f"{self.path} ({self.messages} messages, {self.size / 1e6:.1f} MB{lost}{broken})"


class Recording:
    """Takes what happens, and writes it. Made by `create`.

    Args:
        target: Where to write.
        mission: The mission that runs.
        about: Words about the run, for anyone who lists the file's metadata.
        now: Seconds on the run's clock.
        clean: Takes secrets out of what is written as plain data; what came over the wire is kept as it came.
        profile: MCAP's: `ros2` for a robot of ROS 2.
    """

    def __init__(
        self,
        target: RecordingFile,
        *,
        mission: Mission,
        about: Mapping[str, Any],
        now: Callable[[], float],
        clean: Callable[[Any], Any] | None = None,
        profile: str = "",
    ) -> None:
        from rai_missions.recording.mcap_writer import File  # loads mcap

        self._target, self.path, self._mission, self._now = target, target.path, mission, now
        self._clean = clean or (lambda value: value)
        self._began_ns = time.time_ns() - round(now() * 1e9)
        self._worker = Worker("recording", on_error=self._fail)
        self._closing = threading.Event()
        self._why, self._size, self._takes = "", 0, True
        self._cancel_flush: Callable[[], object] | None = None
        self._journal: Path | None = None
        self._file = File(target.stream, profile)
        self._pen = MessageEncoder(self._file, mission)
        self._queue = RecordingQueue(
            (
                Route("message", self._write_received),
                Route("picture", self._write_received),
                Route("raw", lambda given, when: self._pen.raw(given[0], given[1], when)),
                Route("row", self._write_rows),
                self._json(CALLS, CALL, call_of),
                self._json(GOALS, GOAL, lambda action, *report: report_of(action, Report(*report))),
                self._json(WRITES, BLACKBOARD, write_of),
                self._json(STATUSES, STATUS, lambda status: status_of(status, mission)),
            )
        )
        words = {"format": FORMAT, "mission": mission.name, "version": mission.version, "began_ns": str(self._began_ns)}
        self._file.describe("rai_missions", {**words, **about})
        self.summary: Summary | None = None
        """How it ended; None until then."""
        atexit.register(self.close)

    @classmethod
    def create(cls, path: Path | str, **words: Any) -> Self:
        """A new file; an earlier recording of its name is renamed (`moved_aside`).

        Raises:
            UsageError: What has its name is no recording or is being written, it cannot be written, it is called
                something else, or mcap is missing.
        """
        target = make_file(Path(path))
        try:
            return cls(target, **words)
        except BaseException as fault:
            target.give_back()
            if isinstance(fault, OSError):
                raise UsageError(cannot_write(target.path, fault)) from None
            raise

    @property
    def moved_aside(self) -> Path | None:
        """Where a recording is now that had this one's name."""
        return self._target.moved_aside

    def withdraw(self) -> None:
        """End a recording whose run could not be made: its file is removed, an earlier one has its name again."""
        self.close()
        self._target.give_back()

    # -- what is handed over, from any thread --------------------------------------------------------------------------

    def received(self, message: Message, type_name: str) -> None:
        """A message as plain data; a picture in it is shown as one."""
        image = image_in(message.data)
        given = (message, type_name)
        if image is None:
            self._put(MESSAGE, message.topic, 0, message.at, given)
        else:
            self._put(PICTURE, message.topic, image.width * image.height * 3, message.at, given)

    def received_raw(self, message: RawMessage, definition: str) -> None:
        """A message of ROS as it came over the wire."""
        self._put(RAW, message.topic, len(message.data), message.at, (message, definition))

    def called(self, service: str, request: Mapping[str, Any], reply: Reply, seconds: float) -> None:
        """A service has answered, or has not."""
        given = (service, request, seconds, reply.outcome, reply.data, reply.why)
        self._put(CALLED, CALLS, 0, None, packed(given))

    def reported(self, action: str, report: Report) -> None:
        """An action's server has reported something of a goal."""
        self._put(REPORTED, GOALS, 0, None, packed((action, *report)))

    def rows(self, raws: Sequence[Raw], blobs: Sequence[Blob] = ()) -> None:
        """The journal has got rows, written at once, and the pictures that come with the last."""
        size = 0
        for raw in raws:
            size += len(raw[2])
        for blob in blobs:
            size += len(blob[2])
        self._put(ROW, JOURNAL_TOPIC, size, None, (*chain(*raws), blobs))

    def step(self, step: Step) -> None:
        """A step was made: what it wrote on the blackboard, also where the journal waits for the next row."""
        for key, value in step.writes:
            self._put(WRITTEN, WRITES, 0, step.at, packed((key, without_bytes(value), step.at)))

    def status(self, status: Status) -> None:
        """The run's mode, control or states have changed."""
        self._put(STATUS_NOW, STATUSES, 0, None, (status,))

    def close(self, journal: Path | None = None) -> Summary:
        """Write what waits, and the end; doing so twice changes nothing.

        Args:
            journal: The run's, closed: rows for which there was no room are read from it.
        """
        if self.summary is None:
            atexit.unregister(self.close)
            self._journal = journal
            self._worker.post(self._finish)
            self._takes = False
            self._closing.set()
            if not self._worker.close(PATIENCE_S):
                self._give_up(f"its end was not written within {PATIENCE_S:g} s")
            dropped = {topic: count for topic, count in self._queue.dropped.items() if topic != JOURNAL_TOPIC}
            self.summary = Summary(str(self.path), self._file.messages, self._size, dropped, self._why)
            if dropped:
                lost = ", ".join(f"{topic} {count}" for topic, count in sorted(dropped.items()))
                log.warning("%s lacks messages that came faster than they can be written: %s", self.path, lost)
        return self.summary

    def _put(self, route: int, name: str, size: int, at: float | None, given: Any) -> None:
        """Have something written, with its times."""
        if not self._takes:
            return
        run_s = self._now() if at is None else at
        if self._queue.put((route, size, time.time_ns(), run_s, name, given)):
            self._worker.post(self._work)

    # -- on the recording's own thread ---------------------------------------------------------------------------------

    def _work(self) -> None:
        """Write what has gathered, for a short spell at a time.

        Python runs one thread at a time: so this one works in short spells and rests between them, so no robot waits;
        and where nothing waited, it lets some gather, so that one item does not wake it.
        """
        self._closing.wait(GATHER_S)
        self._write_for_a_spell()

    def _write_for_a_spell(self) -> None:
        """Write until the spell is over or nothing waits; a timer of the worker may come before the next spell."""
        if self._cancel_flush is None:
            self._cancel_flush = self._worker.after(FLUSH_S, self._flush)
        until, waiting = time.monotonic() + SPELL_S, self._queue.waiting
        while (item := self._queue.take()) is not None:
            self._do(item)
            if time.monotonic() >= until and self._worker.post(self._write_for_a_spell):
                if not self._queue.is_filling:
                    self._rest(waiting)
                return

    def _rest(self, waiting: int) -> None:
        """Let others work.

        Args:
            waiting: How many items there were to write before the spell.
        """
        begin = time.monotonic()
        self._closing.wait(REST_S)
        if self._queue.waiting > waiting or time.monotonic() - begin > REST_S + LATE_S:
            self._closing.wait(LONG_REST_S)

    def _do(self, item: QueuedItem) -> None:
        """Write an item."""
        route, _, wall, run_s, name, given = item
        if self._why:
            return
        run = self._began_ns + round(run_s * 1e9) if math.isfinite(run_s) else wall
        try:
            self._queue.routes[route].write(given, When(wall, run))
        except OSError:
            raise
        except Exception:
            self._queue.dropped[name] += 1
            log.exception("a message of %s could not be recorded", name)

    def _write_received(self, given: tuple[Message, str], when: When) -> None:
        message, type_name = given
        self._pen.received(message._replace(data=self._clean(message.data)), type_name, when)

    def _write_rows(self, given: tuple[Any, ...], when: When) -> None:
        *fields, blobs = given
        raws = [tuple(fields[at : at + 4]) for at in range(0, len(fields), 4)]
        for raw in raws:
            self._pen.row(raw, blobs if raw is raws[-1] else (), when)

    def _json(self, topic: str, schema: Schema, make: Callable[..., Any]) -> Route:
        """The route of what is written as JSON on a topic of the mission's own."""

        def write(given: Any, when: When) -> None:
            self._pen.json(topic, schema, self._clean(make(*unpacked(given))), when)

        return Route("message", write)

    def _flush(self) -> None:
        self._cancel_flush = None
        if not self._why:
            self._file.flush()

    def _finish(self) -> None:
        if self._cancel_flush is not None:
            self._cancel_flush()
        while (item := self._queue.take()) is not None:
            self._do(item)
        if self._why:
            return
        self._fill_up()
        self._file.flush()
        self._file.describe("rai_missions/end", {"messages": self._file.messages, "dropped": dict(self._queue.dropped)})
        self._size = self._file.finish()

    def _fill_up(self) -> None:
        """The journal's rows that found no room."""
        if self._journal is None or not self._queue.dropped[JOURNAL_TOPIC]:
            return
        with Record(self._journal) as record:
            when = When(time.time_ns(), time.time_ns())
            self._pen.attach(record.pictures(), when)
            for raw in record.raw():
                if self._pen.lacks(raw[0]):
                    self._pen.row(raw, (), when)

    def _fail(self, fault: BaseException) -> None:
        self._give_up(str(fault) or type(fault).__name__)

    def _give_up(self, why: str) -> None:
        """The recording cannot continue: nothing more is taken, and what waits is let go. The run continues."""
        if self._why:
            return
        self._why, self._takes = why, False
        self._queue.clear()
        log.warning("the recording %s stops, the mission continues: %s", self.path, why)
        with suppress(Exception):
            self._file.abandon()

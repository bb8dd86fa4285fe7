# SPDX-License-Identifier: Apache-2.0
"""A pool of processes on this machine: tasks go out, records come back, and a worker that dies loses one cell at most.

Rule: no record is yielded twice, and a task leaves the pool when all its cells have a record or the pool was stopped.
"""

from __future__ import annotations

import base64
import os
import queue
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Protocol

from rai_missions.campaign.records import CellRecord, PictureRecord
from rai_missions.campaign.tasks import SceneTask, TaskRecord, WorkSettings
from rai_missions.campaign.worker import RECORDS, task_words
from rai_missions.connectors.process.life import ProcessLife
from rai_missions.errors import UsageError
from rai_missions.redaction import logger, secrets_held, variables

__all__ = ("LocalPool", "TaskPool", "usable_cores")

log = logger(__name__)

WORK = "rai_missions.campaign.worker:work"
TICK_S = 0.5
"""How often a pool yields nothing, so that its campaign can look at the time."""
MEMORY_BYTES = 8 << 30
"""What a worker may be resident in, with the models that it opens."""
MOST_DEATHS = 5
"""Workers in a row that may die of a task without any record; then its next cell has failed."""
PATIENCE_S = 5.0


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class TaskPool(Protocol):
    """What has tasks done."""

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        """The records of tasks as they come, None now and then, until all are done or the pool was stopped.

        Raises:
            UsageError: A worker cannot begin at all.
        """

    def stop(self) -> None:
        """Begin nothing more; what is under way comes to its end."""

    def close(self) -> None:
        """End every worker."""


class LocalPool:
    """A `TaskPool` of processes on this machine.

    Args:
        settings: What every worker knows; its `workers` is how many there are.
    """

    def __init__(self, settings: WorkSettings) -> None:
        self._settings = settings
        self._messages: queue.SimpleQueue[tuple[PoolWorker, Mapping[str, Any] | None]] = queue.SimpleQueue()
        self._workers: list[PoolWorker] = []
        self._tasks: deque[SceneTask] = deque()
        self._is_stopped = False

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        self._tasks.extend(tasks)
        for _ in range(min(self._settings.workers, len(self._tasks))):
            self._begin()
        while any(each.task is not None for each in self._workers) or (self._tasks and not self._is_stopped):
            try:
                worker, message = self._messages.get(timeout=TICK_S)
            except queue.Empty:
                yield None
                continue
            yield from self._after_death(worker) if message is None else self._taken(worker, message)

    def stop(self) -> None:
        self._is_stopped = True
        for each in self._workers:
            each.life.send({"do": "stop"})

    def close(self) -> None:
        for each in self._workers:
            each.life.end("the campaign is over")
        until = time.monotonic() + PATIENCE_S
        for each in self._workers:
            each.life.join(until - time.monotonic())

    @property
    def pids(self) -> tuple[int, ...]:
        """The processes that work, as far as they have reported themselves."""
        return tuple(each.pid for each in self._workers if each.pid)

    def _begin(self, task: SceneTask | None = None, deaths: int = 0) -> None:
        worker = PoolWorker(self._settings, self._messages)
        worker.task, worker.deaths = task, deaths
        self._workers.append(worker)
        if task is not None:
            worker.give(task)
        else:
            self._give_next(worker)
        if self._is_stopped:
            worker.life.send({"do": "stop"})

    def _give_next(self, worker: PoolWorker) -> None:
        worker.task, worker.deaths = None, 0
        if self._tasks and not self._is_stopped:
            worker.give(self._tasks.popleft())

    def _taken(self, worker: PoolWorker, message: Mapping[str, Any]) -> Iterator[TaskRecord]:
        if "fault" in message:
            raise UsageError(f"a worker of the campaign cannot work: {message['fault']}")
        if "ready" in message:
            worker.pid = message["ready"]
        elif "done" in message:
            self._give_next(worker)
        elif (record := worker.record_in(message)) is not None:
            worker.deaths = 0
            yield record

    def _after_death(self, worker: PoolWorker) -> Iterator[TaskRecord]:
        """Give what a dead worker has left to another worker."""
        self._workers.remove(worker)
        task, deaths = worker.task, worker.deaths + 1
        if task is None or self._is_stopped:
            return
        task = task.without(worker.done)
        log.warning(
            "a worker of the campaign died (%s); %d cells of its scene are left", worker.life.why, len(task.cells)
        )
        if deaths >= MOST_DEATHS and task.cells:
            key, cell = task.cells[0]
            yield CellRecord(key, *cell, status="failed", error=f"{deaths} workers died of it: {worker.life.why}")
            task, deaths = task.without({key}), 0
        if task.cells:
            self._begin(task, deaths)
        elif self._tasks:
            self._begin()


class PoolWorker:
    """One process of a pool, and the task that it has.

    Args:
        settings: What every worker knows.
        messages: Where its messages go, and None when it has ended.
    """

    def __init__(
        self, settings: WorkSettings, messages: queue.SimpleQueue[tuple[PoolWorker, Mapping[str, Any] | None]]
    ) -> None:
        first = {
            "settings": list(settings),
            "environment": variables(secret=True),
            "path": [os.path.abspath(entry) for entry in sys.path],
            "secrets": secrets_held(),
        }
        self.task: SceneTask | None = None
        self.done: set[str] = set()
        """Keys of the cells of its task that have a record."""
        self.deaths = self.pid = 0
        self._number, self._pieces = 0, list[bytes]()
        self.life = ProcessLife(
            "campaign",
            WORK,
            first,
            MEMORY_BYTES,
            on_message=lambda message: messages.put((self, message)),
            on_end=partial(messages.put, (self, None)),
        )
        self.life.start()

    def give(self, task: SceneTask) -> None:
        """Have it do a task."""
        self.task, self.done = task, set()
        self._number += 1
        self.life.send({"do": "work", "number": self._number, "task": task_words(task)})

    def record_in(self, message: Mapping[str, Any]) -> TaskRecord | None:
        """The record in a message; None where it is not whole yet, or there is none.

        Raises:
            UsageError: It is no record.
        """
        kind = RECORDS.get(message.get("record", ""))
        if kind is None:
            return None
        try:
            if kind is PictureRecord:
                return self._picture(*message["of"], is_last=message["is_last"])
            record: TaskRecord = kind(*message["of"])
        except (KeyError, TypeError, ValueError) as error:
            raise UsageError(f"a worker of the campaign sent a record that is none: {error}") from None
        if isinstance(record, CellRecord):
            self.done.add(record.cell)
        return record

    def _picture(self, scene: str, name: str, piece: str, *, is_last: bool) -> PictureRecord | None:
        self._pieces.append(base64.b64decode(piece))
        if not is_last:
            return None
        png = b"".join(self._pieces)
        self._pieces.clear()
        return PictureRecord(scene, name, png)

# SPDX-License-Identifier: Apache-2.0
"""A pool on Ray: the same tasks as a local pool, on a cluster or on this machine.

Rule: what a task yields is the task's affair; here it is decided where it is done, and again after a worker died.
"""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from rai_missions.campaign.pool import MOST_DEATHS
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.tasks import SceneTask, TaskRecord, Workplace, WorkSettings
from rai_missions.errors import UsageError, install_command
from rai_missions.redaction import first_line, logger, variables

__all__ = ("RayPool",)

log = logger(__name__)

TICK_S = 0.5


class RayWorker:
    """One worker on Ray: an actor that keeps its mission and its models open.

    Args:
        settings: What every worker knows; the campaign's file, and all that it names, is there on each machine under
            the same path.
        environment: Variables of the machine on which the campaign was started, keys of providers among them.
    """

    def __init__(self, settings: WorkSettings, environment: dict[str, str]) -> None:
        for name, value in environment.items():
            os.environ.setdefault(name, value)
        os.environ.setdefault("LP_NUM_THREADS", "1")
        self._settings = settings
        self._place: Workplace | None = None

    def begin(self) -> int:
        """Open the mission and its models.

        Returns:
            The process that works, by its number on its machine.
        """
        self._place = Workplace(self._settings)
        return os.getpid()

    def work(self, task: SceneTask) -> list[TaskRecord]:
        """All records of a task."""
        assert self._place is not None, "the pool gives tasks to a worker that has begun"
        return list(self._place.work(task))


class RayTask(NamedTuple):
    """A worker and the task that it has."""

    actor: Any
    pid: int
    """Its process, by its number on its machine."""
    task: SceneTask
    deaths: int
    """How many workers died of this task."""


class RayPool:
    """A `TaskPool` on Ray.

    Args:
        settings: What every worker knows; its `workers` is how many actors there are, of one core each.
        address: Of a cluster, as `ray.init` takes it; empty: Ray is started on this machine, and ended with the pool.

    Raises:
        UsageError: Ray is not installed, or the cluster cannot be reached.
    """

    def __init__(self, settings: WorkSettings, address: str = "") -> None:
        try:
            import ray
        except ImportError:
            raise UsageError(f"--ray needs the package 'ray': {install_command('ray')}") from None
        self._ray: Any = ray
        self._settings, self._is_stopped = settings, False
        self._tasks: deque[tuple[SceneTask, int]] = deque()
        self._beginning: dict[Any, Any] = {}
        self._busy: dict[Any, RayTask] = {}
        self._failed_starts = 0
        words: dict[str, Any] = {"address": address} if address else {"address": "local", "num_cpus": settings.workers}
        try:
            ray.init(
                **words,
                include_dashboard=False,
                log_to_driver=False,
                logging_level="error",
                runtime_env={"env_vars": {"PYTHONPATH": os.pathsep.join(filter(None, map(os.path.abspath, sys.path)))}},
            )
        except Exception as error:  # whatever Ray raises, the caller named the cluster
            raise UsageError(f"Ray cannot be reached at '{address or 'this machine'}': {first_line(error)}") from error

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        self._tasks.extend((task, 0) for task in tasks)
        for _ in range(min(self._settings.workers, len(self._tasks))):
            self._begin()
        while self._busy or (self._tasks and not self._is_stopped):
            ready, _ = self._ray.wait([*self._beginning, *self._busy], timeout=TICK_S)
            if not ready:
                yield None
            for reference in ready:
                if reference in self._busy:
                    yield from self._worked(reference)
                else:
                    self._begun(reference)

    def stop(self) -> None:
        self._is_stopped = True

    def close(self) -> None:
        self._ray.shutdown()

    @property
    def pids(self) -> tuple[int, ...]:
        """The processes that work on a scene, by their numbers on their machines."""
        return tuple(each.pid for each in self._busy.values())

    def _begin(self) -> None:
        """Have Ray find a place for one more worker; it has a task once it is there, however long that takes."""
        remote = self._ray.remote(num_cpus=1)(RayWorker)
        actor = remote.remote(self._settings, dict(variables(secret=True)))
        self._beginning[actor.begin.remote()] = actor

    def _begun(self, reference: Any) -> None:
        """A worker is ready for a task, or it died before."""
        actor = self._beginning.pop(reference)
        try:
            pid = self._answer(reference)
        except self._ray.exceptions.RayError as error:
            self._failed_starts += 1
            if self._failed_starts >= MOST_DEATHS:
                raise UsageError(f"no worker of the campaign can begin: {first_line(error)}") from error
            self._begin()
            return
        self._failed_starts = 0
        self._give_next(actor, pid)

    def _worked(self, reference: Any) -> Iterator[TaskRecord]:
        """A worker has done its task, or it was lost with what it did."""
        actor, pid, task, deaths = self._busy.pop(reference)
        try:
            records = self._answer(reference)
        except self._ray.exceptions.RayError as error:
            yield from self._again(task, deaths + 1, first_line(error))
            if self._tasks and not self._is_stopped:
                self._begin()
            return
        self._give_next(actor, pid)
        yield from records

    def _answer(self, reference: Any) -> Any:
        """What a worker gave back.

        Raises:
            UsageError: The worker's own code raised; another worker would do no better.
            ray.exceptions.RayError: It is lost: the process, its machine, or what it stored there.
        """
        try:
            return self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            raise UsageError(f"a worker of the campaign cannot work: {first_line(error.cause)}") from error

    def _give_next(self, actor: Any, pid: int) -> None:
        """A task for a worker; without one the worker ends, and its core is free for others."""
        if self._tasks and not self._is_stopped:
            task, deaths = self._tasks.popleft()
            self._busy[actor.work.remote(task)] = RayTask(actor, pid, task, deaths)

    def _again(self, task: SceneTask, deaths: int, why: str) -> Iterator[CellRecord]:
        """Have a task done by another worker; after too many deaths its cells have failed."""
        log.warning("a worker died (%s); the scene %s is asked again", why, task.scene.scene)
        if deaths < MOST_DEATHS:
            self._tasks.append((task, deaths))
            return
        for key, cell in task.cells:
            yield CellRecord(key, *cell, status="failed", error=f"{deaths} workers died of it: {why}")

# SPDX-License-Identifier: Apache-2.0
"""A pool on Ray: the same tasks as a local pool, on a cluster or on this machine.

Rule: what a task yields is the task's affair; here it is decided where it is done, and again after a worker died.
"""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any

from rai_missions.campaign.pool import MOST_DEATHS
from rai_missions.campaign.store import CellRecord
from rai_missions.campaign.tasks import SceneTask, TaskRecord, Workplace, WorkSettings
from rai_missions.errors import UsageError
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
        self._place = Workplace(settings)

    def work(self, task: SceneTask) -> list[TaskRecord]:
        """All records of a task."""
        return list(self._place.work(task))


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
            raise UsageError("--ray needs the package 'ray': pip install '.[ray]'") from None
        self._ray: Any = ray
        self._settings, self._is_stopped = settings, False
        self._tasks: deque[tuple[SceneTask, int]] = deque()
        words: dict[str, Any] = {"address": address} if address else {"num_cpus": settings.workers}
        try:
            ray.init(
                **words, include_dashboard=False, log_to_driver=False, logging_level="error",
                runtime_env={"env_vars": {"PYTHONPATH": os.pathsep.join(filter(None, map(os.path.abspath, sys.path)))}},
            )  # fmt: skip
        except Exception as error:  # whatever Ray raises, the caller named the cluster
            raise UsageError(f"Ray cannot be reached at '{address or 'this machine'}': {first_line(error)}") from error

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        self._tasks.extend((task, 0) for task in tasks)
        idle = [self._actor() for _ in range(min(self._settings.workers, len(self._tasks)))]
        busy: dict[Any, tuple[Any, SceneTask, int]] = {}
        while True:
            while idle and self._tasks and not self._is_stopped:
                actor, (task, deaths) = idle.pop(), self._tasks.popleft()
                busy[actor.work.remote(task)] = (actor, task, deaths)
            if not busy:
                return
            ready, _ = self._ray.wait(list(busy), timeout=TICK_S)
            if not ready:
                yield None
            for reference in ready:
                actor, task, deaths = busy.pop(reference)
                try:
                    records = self._ray.get(reference)
                except self._ray.exceptions.RayActorError as error:
                    idle.append(self._actor())
                    yield from self._again(task, deaths + 1, first_line(error))
                    continue
                idle.append(actor)
                yield from records

    def stop(self) -> None:
        self._is_stopped = True

    def close(self) -> None:
        self._ray.shutdown()

    def _actor(self) -> Any:
        return self._ray.remote(num_cpus=1)(RayWorker).remote(self._settings, dict(variables(secret=True)))

    def _again(self, task: SceneTask, deaths: int, why: str) -> Iterator[CellRecord]:
        """Have a task done by another worker; after too many deaths its cells have failed."""
        log.warning("a worker died (%s); the scene %s is asked again", why, task.scene.scene)
        if deaths < MOST_DEATHS:
            self._tasks.append((task, deaths))
            return
        for key, cell in task.cells:
            yield CellRecord(key, *cell, status="failed", error=f"{deaths} workers died of it: {why}")

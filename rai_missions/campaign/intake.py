# SPDX-License-Identifier: Apache-2.0
"""What comes from a pool of workers, on its way into the store, and how far a campaign is by it."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import timedelta
from typing import NamedTuple

from rai_missions.campaign.budget import Spending, with_use_of
from rai_missions.campaign.records import CellRecord, LabelRecord, UnlabelledScene
from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import TaskRecord

__all__ = ("Intake", "Progress")

COMMIT_S, COMMIT_RECORDS = 0.5, 200
"""What came is committed after so long, or when there is so much of it; a cell that cost calls at once."""


class Progress(NamedTuple):
    """How far a campaign is."""

    done: int
    """Cells with a record, earlier runs included; where labels alone are made, scenes with labels."""
    total: int
    rate: float
    """Cells or scenes a second, in this run."""
    left_s: float | None
    """Seconds until all are done, at this rate; None before the first."""
    money: float
    unit: str = "cells"

    def words(self, currency: str) -> str:
        """In a line."""
        left = "" if self.left_s is None else f", {timedelta(seconds=round(self.left_s))} left"
        cost = f", {self.money:.2f} {currency}" if self.money else ""
        return f"{self.done} of {self.total} {self.unit}, {self.rate:.1f} {self.unit}/s{left}{cost}"


class Intake:
    """What comes from a pool, on its way into the store.

    Args:
        store: Where it goes.
        spending: Counts what it cost.
        on_progress: Receives how far it is.
        done: How many are done already.
        total: How many there are.
        counts: What is counted: cells, or scenes that have labels.
    """

    def __init__(
        self,
        store: ResultStore,
        spending: Spending,
        on_progress: Callable[[Progress], None],
        done: int,
        total: int,
        *,
        counts: type[CellRecord | LabelRecord] = CellRecord,
    ) -> None:
        self._store, self._spending, self._on_progress = store, spending, on_progress
        self._before, self._total, self._counts = done, total, counts
        self._new = set[str]()
        self.labelled = set[str]()
        """Scenes whose labels came."""
        self.unlabelled = dict[str, str]()
        """Scene → why it could not be labelled."""
        self._began = self._committed = time.monotonic()
        self._failed = {each.cell: each._replace(raw="") for each in store.cells() if each.status == "failed"}
        self._held: list[TaskRecord] = []

    def take(self, record: TaskRecord | None) -> None:
        """A record, or None where only time has passed."""
        if isinstance(record, self._counts):
            self._new.add(record[0])
        if isinstance(record, LabelRecord):
            self.labelled.add(record.scene)
        if isinstance(record, UnlabelledScene):
            self.unlabelled[record.scene], record = record.why, None
        if isinstance(record, CellRecord):
            self._spending.add(record)
            earlier = self._failed.get(record.cell)
            record = record if earlier is None else with_use_of(record, earlier)
        if record is not None:
            self._held.append(record)
        if isinstance(record, CellRecord) and record.calls:
            self._keep()  # what it cost is not forgotten by a kill
        if len(self._held) >= COMMIT_RECORDS or time.monotonic() - self._committed > COMMIT_S:
            self.commit()

    def commit(self) -> None:
        """Have the store hold what came until now, and report how far it is."""
        self._keep()
        self._committed = time.monotonic()
        self._on_progress(self.progress)

    def _keep(self) -> None:
        if self._held:
            self._store.add(self._held)
            self._held.clear()

    @property
    def progress(self) -> Progress:
        """How far it is."""
        new, seconds = len(self._new), time.monotonic() - self._began
        done, rate = self._before + new, new / seconds if seconds > 0 else 0.0
        left_s, unit = (
            (self._total - done) / rate if rate else None,
            "cells" if self._counts is CellRecord else "scenes",
        )
        return Progress(done, self._total, rate, left_s, self._spending.money, unit)

# SPDX-License-Identifier: Apache-2.0
"""A campaign from its file to its store: what is missing is asked, as far as the budget goes.

Rule: one process writes. A record counts once it is committed; whatever ends a campaign, the next run asks the rest.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from datetime import timedelta
from typing import Any, NamedTuple

from rai_missions.campaign.budget import Spending, with_use_of
from rai_missions.campaign.cells import Cell, cells_of, code_digest, digest
from rai_missions.campaign.embodiments import embodiment_digest
from rai_missions.campaign.load import LoadedCampaign
from rai_missions.campaign.models import is_chat, model_digest
from rai_missions.campaign.pool import LocalPool, TaskPool
from rai_missions.campaign.records import (
    CellRecord,
    LabelRecord,
    SceneRecord,
    UnlabelledScene,
    graded,
    is_tried,
    parameters_in,
)
from rai_missions.campaign.store import LostParts, ResultStore
from rai_missions.campaign.tasks import SceneTask, TaskRecord, WorkSettings
from rai_missions.errors import UsageError
from rai_missions.redaction import Redaction

__all__ = ("CampaignPlan", "CampaignResult", "Progress", "plan_of", "run_campaign")

UNLABELLED = "none"
"""The word of a campaign's file for labels from nowhere but the store."""
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


class CampaignResult(NamedTuple):
    """How a campaign's run ended."""

    counts: Mapping[str, int]
    """Status → cells of the plan; those of models that are not asked now are left out."""
    missing: int
    """Cells without a record; where labels alone are made, scenes without labels."""
    stopped: str
    """Which part of the budget is spent; empty where it was not."""
    seconds: float
    failures: Mapping[str, int]
    """Why cells failed → how many did, the most first."""
    unlabelled: Mapping[str, int] = {}
    """Why scenes could not be labelled → how many, the most first."""


class CampaignPlan(NamedTuple):
    """What a campaign consists of."""

    scenes: tuple[SceneRecord, ...]
    cells: Mapping[str, Cell]
    """Key → cell, in the order in which they are asked."""
    labels: Mapping[str, Mapping[str, str]]
    """Scene → option → verdict of physics."""
    code: str
    """Digest of the code by which it is asked."""
    embodiments: Mapping[str, str]
    """Name → digest of the files that it shows."""

    def tasks(self, done: set[str], shown: set[tuple[str, str]], *, rates: bool = False) -> Iterator[SceneTask]:
        """What is left to do, a scene at a time.

        Args:
            done: Keys of cells that have their record.
            shown: Scene and embodiment of the questions that are stored.
            rates: Labels are wanted, where there are none.
        """
        left: dict[str, list[tuple[str, Cell]]] = {}
        for key, cell in self.cells.items():
            if key not in done:
                left.setdefault(cell.scene, []).append((key, cell))
        for scene in self.scenes:
            cells, labels = left.get(scene.scene, []), self.labels.get(scene.scene, {})
            shows = any((scene.scene, cell.embodiment) not in shown for _, cell in cells)
            if cells or (rates and not labels):
                yield SceneTask(scene, tuple(cells), labels, shows, rates and not labels)

    def label_tasks(self) -> Iterator[SceneTask]:
        """The scenes that have no labels yet, without their cells."""
        for scene in self.scenes:
            if not self.labels.get(scene.scene):
                yield SceneTask(scene, (), {}, shows=False, rates=True)


def plan_of(loaded: LoadedCampaign) -> CampaignPlan:
    """Every cell of a campaign under its key; no scene has labels yet."""
    file, robot = loaded.file, loaded.subject.robot
    scenes = tuple(file.scenes.scenes())
    digests = {each.scene: digest([each.world, each.spec, each.seed]) for each in scenes}
    kinds = {each.scene: each.kind for each in scenes}
    code = code_digest()
    common = {"mission": loaded.digest, "code": code}
    models = {model: model_digest(model, file, robot) for model in file.models}
    bodies = {name: embodiment_digest(name, loaded.subject.identity) for name in file.embodiments}
    cells: dict[str, Cell] = {}
    names = [(each.scene, each.seed) for each in scenes]
    for cell in cells_of(loaded.subject.mission.name, names, file.models, file.embodiments, file.orders):
        inputs = {**common, "scene": digests[cell.scene], "model": models[cell.model]}
        inputs["embodiment"] = bodies[cell.embodiment]
        if cell.model in file.scripts:
            inputs["kind"] = kinds[cell.scene]  # by which a script answers
        cells[cell.key(inputs)] = cell
    return CampaignPlan(scenes, cells, {}, code, bodies)


def run_campaign(
    loaded: LoadedCampaign,
    store: ResultStore,
    settings: WorkSettings,
    *,
    open_pool: Callable[[WorkSettings], TaskPool] = LocalPool,
    labels_alone: bool = False,
    on_progress: Callable[[Progress], None] = lambda progress: None,
) -> CampaignResult:
    """Ask what is missing in a store, until all is asked or the budget is spent.

    Args:
        loaded: The campaign.
        store: Open to write.
        settings: What the workers know.
        open_pool: Who does it.
        labels_alone: Label the scenes that have no labels, and ask nothing.
        on_progress: Receives how far it is, about twice a second.

    Raises:
        UsageError: The store is of another campaign or version, a model cannot be opened, a worker cannot begin, or
            labels alone are wanted and the campaign has no source of them.
    """
    began = time.monotonic()
    _check_sources(loaded, settings, labels_alone=labels_alone)
    plan = _labelled_plan(loaded, store)
    budget = loaded.file.budget
    if labels_alone or settings.recorded:
        budget = budget.model_copy(update=dict.fromkeys(("calls", "tokens", "money")))  # no one is asked
    spending = Spending(budget, store.cells(), store.dropped)
    if labels_alone:
        labelled = sum(each.scene in plan.labels for each in plan.scenes)
        intake = Intake(store, spending, on_progress, labelled, len(plan.scenes), counts=LabelRecord)
        wanted = plan.label_tasks()
    else:
        done = store.done() & plan.cells.keys()
        intake = Intake(store, spending, on_progress, len(done), len(plan.cells))
        wanted = plan.tasks(done, store.shown(), rates=loaded.file.labels != UNLABELLED)
    with closing(open_pool(settings)) as pool:
        try:
            stopped = _work(pool, wanted, intake, spending, began)
        finally:
            intake.commit()
            _grade(store, intake.labelled, loaded.file.rollouts.parameters)
    if labels_alone:
        missing = len({each.scene for each in plan.scenes} - _whole(store.labels(), loaded.subject.options).keys())
    else:
        missing = len(plan.cells.keys() - store.keys().keys())
    seconds = time.monotonic() - began
    ends = [end for key, end in store.ends().items() if key in plan.cells]
    counts = Counter(status for status, _ in ends)
    failures = Counter(error for status, error in sorted(ends) if status == "failed")
    unlabelled = Counter(intake.unlabelled.values())
    return CampaignResult(
        counts,
        missing,
        stopped if missing else "",
        seconds,
        dict(failures.most_common()),
        dict(unlabelled.most_common()),
    )


def _labelled_plan(loaded: LoadedCampaign, store: ResultStore) -> CampaignPlan:
    """The plan with the labels that a store has, which holds nothing but what is of the plan from now on.

    Raises:
        UsageError: It holds another campaign's cells, or those of another version of this code.
    """
    plan = plan_of(loaded)
    _note_campaign(loaded, plan, store)
    options = loaded.subject.options if loaded.file.labels != UNLABELLED else ()
    plan = plan._replace(labels=_whole(store.labels(), options))
    _drop_outdated(plan, store)
    return plan


def _work(pool: TaskPool, tasks: Iterable[SceneTask], intake: Intake, spending: Spending, began: float) -> str:
    """Take in what a pool makes of tasks; the limit of the budget that ended it, or empty."""
    stopped = spending.spent(0.0)
    for record in pool.results([] if stopped else list(tasks)):
        intake.take(record)
        if not stopped and (stopped := spending.spent(time.monotonic() - began)):
            pool.stop()
    return stopped


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


def _check_sources(loaded: LoadedCampaign, settings: WorkSettings, *, labels_alone: bool) -> None:
    """See whether there is what answers or labels: stored answers, models, a source of labels.

    Raises:
        UsageError: There is none.
    """
    if labels_alone and loaded.file.labels == UNLABELLED:
        raise UsageError('the campaign has no source of labels: write "labels": "trials" or "rollouts" in its file')
    if settings.recorded:
        ResultStore(settings.recorded).close()  # it is there, before a worker begins
    elif not labels_alone:
        _check_models(loaded)


def _check_models(loaded: LoadedCampaign) -> None:
    """See whether the models that are named can be opened, as far as that is known without opening them."""
    chats = [model for model in loaded.file.models if is_chat(model, loaded.file)]
    if chats:
        from rai_missions.answerers.model.providers import check_model
        from rai_missions.campaign.models import MEMORY_GIB

        for model in chats:
            check_model(model, memory_gib=MEMORY_GIB)


def _note_campaign(loaded: LoadedCampaign, plan: CampaignPlan, store: ResultStore) -> None:
    """Note what the store is of; one that holds another campaign is left as it is.

    Raises:
        UsageError: It holds another campaign's cells, or those of another version of this code.
    """
    now = {"name": loaded.file.name, "campaign": loaded.file.name, "mission": loaded.digest, "code": plan.code}
    before = store.meta
    for word, what in (
        ("campaign", "campaign"),
        ("mission", "mission or profile"),
        ("code", "version of this program"),
    ):
        if word in before and before[word] != now[word]:
            raise UsageError(
                f"{store.path} holds the answers of another {what}; name another store, and reuse the answers with"
                f" --replay-answers {store.path}"
            )
    known = before.get("embodiments", {})
    source = before.get("file", {}).get("labels", UNLABELLED)
    outdated = LostParts(
        UNLABELLED not in (source, loaded.file.labels) and source != loaded.file.labels,
        tuple(name for name, each in plan.embodiments.items() if known.get(name, each) != each),
    )
    values = {
        **now,
        "file": Redaction().json(loaded.file.written()),
        "currency": loaded.file.currency,
        "embodiments": {**known, **plan.embodiments},
    }
    store.begin(plan.scenes, values, outdated=outdated)


def _drop_outdated(plan: CampaignPlan, store: ResultStore) -> None:
    """Take out cells that have the names of one of the plan and another key: their scene, script or label changed."""
    names = {(each[0], each[1], *each[3:]) for each in plan.cells.values()}
    store.drop(key for key, each in store.keys().items() if key not in plan.cells and tuple(each) in names)


def _grade(store: ResultStore, scenes: set[str], tried: Mapping[str, Mapping[str, Any]]) -> None:
    """Grade the answers that were there before the labels of their scenes."""
    labels = store.labels() if scenes else {}
    changed = list[CellRecord]()
    for each in store.cells():
        if each.scene in scenes:
            is_labelled = is_tried(each.option, parameters_in(each), tried)
            again = graded(each, labels.get(each.scene, {}) if is_labelled else {})
            changed += [again] if again != each else []
    store.add(changed)


def _whole(labels: Mapping[str, Mapping[str, str]], options: Sequence[str]) -> dict[str, Mapping[str, str]]:
    """The labels of scenes in which each of these options has one; a kill may have come in between."""
    return {scene: each for scene, each in labels.items() if each.keys() >= set(options)}

# SPDX-License-Identifier: Apache-2.0
"""A campaign from its file to its store: what is missing is asked, as far as the budget goes.

Rule: one process writes. A record counts once it is committed; whatever ends a campaign, the next run asks the rest.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from typing import Any, NamedTuple

from rai_missions.campaign.budget import Spending
from rai_missions.campaign.intake import Intake, Progress
from rai_missions.campaign.load import LoadedCampaign
from rai_missions.campaign.models import is_chat
from rai_missions.campaign.plan import CampaignPlan, plan_of
from rai_missions.campaign.pool import LocalPool, TaskPool
from rai_missions.campaign.records import (
    CellRecord,
    LabelRecord,
    graded,
    is_tried,
    parameters_in,
)
from rai_missions.campaign.store import LostParts, ResultStore
from rai_missions.campaign.tasks import SceneTask, WorkSettings
from rai_missions.errors import UsageError
from rai_missions.redaction import Redaction

__all__ = ("CampaignResult", "run_campaign")

UNLABELLED = "none"
"""The word of a campaign's file for labels from nowhere but the store."""


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
    ends = [end for key, end in store.ends().items() if key in plan.cells]
    return CampaignResult(
        Counter(status for status, _ in ends),
        missing,
        stopped if missing else "",
        time.monotonic() - began,
        _most_first(error for status, error in ends if status == "failed"),
        _most_first(intake.unlabelled.values()),
    )


def _most_first(reasons: Iterable[str]) -> dict[str, int]:
    """Reason → how often it is there, the most first; of those as frequent, in the order of their words."""
    return dict(Counter(sorted(reasons)).most_common())


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

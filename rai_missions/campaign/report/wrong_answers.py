# SPDX-License-Identifier: Apache-2.0
"""The wrong answers of a campaign, each with what it takes to judge it; a sample by kind where there are very many.

Rule: what is left out is counted, and is in the CSV.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.campaign.records import CellRecord, QuestionRecord, best_options
from rai_missions.campaign.report.figures import CampaignFigures, is_unlabelled
from rai_missions.campaign.store import ResultStore
from rai_missions.plain_data import json_value

__all__ = ("MOST", "WrongAnswer", "WrongAnswers", "is_wrong", "wrong_answers")

MOST = 2_000
"""Wrong answers in a report."""


class WrongAnswer(NamedTuple):
    """An answer that was not the best one, or none."""

    cell: CellRecord
    kind: str
    best: tuple[str, ...]
    """The options that were best."""


class WrongAnswers(NamedTuple):
    """What a report shows of a store."""

    shown: tuple[WrongAnswer, ...]
    """Harm that the rules permitted first, then harm, then by kind and scene."""
    total: int
    """How many there are."""
    by_kind: Mapping[str, tuple[int, int]]
    """Kind → how many are shown, and how many there are."""
    questions: Mapping[tuple[str, str], QuestionRecord]
    """Scene and embodiment → what was asked, for those that are shown."""
    details: Mapping[tuple[str, str], Any]
    """Scene and option → what the rollout found, for the scenes that are shown."""


def is_wrong(cell: CellRecord, figures: CampaignFigures) -> bool:
    """Whether a cell counts as a wrong answer: of the split, labelled, and not the best; a failed one is none."""
    if cell.status == "failed" or cell.scene not in figures.scenes or not figures.labels.get(cell.scene):
        return False
    return cell.best != 1 and not is_unlabelled(cell)


def wrong_answers(store: ResultStore, figures: CampaignFigures, most: int = MOST) -> WrongAnswers:
    """The wrong answers of a store.

    Args:
        store: Where they are.
        figures: The figures of the same store.
        most: How many are shown; of more, the same share of every kind as far as it has that many. Cells are drawn by
            their key, a hash, so that the sample is the same every time and prefers no model.
    """
    keys = defaultdict[str, list[str]](list)
    for cell in store.cells():
        if is_wrong(cell, figures):
            keys[figures.scenes[cell.scene].kind].append(cell.cell)
    counts = {kind: len(found) for kind, found in sorted(keys.items())}
    quota = _quota(counts, most)
    chosen = {key for kind, found in keys.items() for key in sorted(found)[: quota[kind]]}
    found = [_answer(cell, figures) for cell in store.cells() if cell.cell in chosen]
    shown = tuple(sorted(found, key=_what_matters_first))
    asked = {(each.cell.scene, each.cell.embodiment) for each in shown}
    scenes = {scene for scene, _ in asked}
    return WrongAnswers(
        shown,
        sum(counts.values()),
        {kind: (quota[kind], count) for kind, count in counts.items()},
        {key: each for each in store.questions() if (key := (each.scene, each.embodiment)) in asked},
        {
            (each.scene, each.option): json_value(each.details, each.details)
            for each in store.label_records()
            if each.scene in scenes
        },
    )


def _quota(counts: Mapping[str, int], most: int) -> dict[str, int]:
    """How many of each kind are shown: as evenly as the kinds have them."""
    quota, left = Counter[str](), most
    open_kinds = [kind for kind, count in counts.items() if count]
    while left and open_kinds:
        each = max(1, left // len(open_kinds))
        for kind in open_kinds[:left]:
            more = min(each, counts[kind] - quota[kind], left)
            quota[kind] += more
            left -= more
        open_kinds = [kind for kind in open_kinds if quota[kind] < counts[kind]]
    return {kind: quota[kind] for kind in counts}


def _answer(cell: CellRecord, figures: CampaignFigures) -> WrongAnswer:
    best = tuple(sorted(best_options(figures.labels[cell.scene])))
    return WrongAnswer(cell, figures.scenes[cell.scene].kind, best)


def _what_matters_first(answer: WrongAnswer) -> tuple[Any, ...]:
    harms = answer.cell.verdict == "harms"
    return not (harms and answer.cell.permitted == 1), not harms, answer.kind, answer.cell.scene, answer.cell.cell

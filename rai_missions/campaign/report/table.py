# SPDX-License-Identifier: Apache-2.0
"""Every cell of a campaign as CSV, for programs and spreadsheets.

Rule: a text that a spreadsheet would take for a formula begins with an apostrophe, as OWASP's page on CSV injection
advises: a model's words are never computed.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

from rai_missions.campaign.records import CellRecord, best_options
from rai_missions.campaign.report.figures import CampaignFigures
from rai_missions.campaign.report.wrong_answers import is_wrong
from rai_missions.campaign.store import ResultStore

__all__ = ("COLUMNS", "write_table")

OWN = tuple(name for name in CellRecord._fields if name != "raw")
"""`raw` stays in the store."""
COLUMNS = (*OWN, "world", "kind", "split", "best_options", "wrong")
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")


def write_table(store: ResultStore, figures: CampaignFigures, path: Path) -> int:
    """Write the file.

    Returns:
        Cells in it.
    """
    count = 0
    with path.open("w", encoding="utf-8", errors="replace", newline="") as opened:
        writer = csv.writer(opened)
        writer.writerow(COLUMNS)
        for line in _lines(store, figures):
            writer.writerow(line)
            count += 1
    return count


def _lines(store: ResultStore, figures: CampaignFigures) -> Iterator[list[object]]:
    scenes = {scene.scene: scene for scene in store.scenes()}
    best = {scene: " ".join(sorted(best_options(labels))) for scene, labels in figures.labels.items() if labels}
    numbers = [CellRecord._fields.index(name) for name in OWN]
    for cell in store.cells():
        scene = scenes.get(cell.scene)
        facts = (scene.world, scene.kind, scene.split) if scene is not None else ("", "", "")
        values = (*(cell[number] for number in numbers), *facts, best.get(cell.scene, ""), int(is_wrong(cell, figures)))
        yield [_inert(value) for value in values]


def _inert(value: object) -> object:
    """A text that no spreadsheet computes."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value

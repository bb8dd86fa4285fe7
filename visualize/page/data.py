# SPDX-License-Identifier: Apache-2.0
"""A mission and its journals as the data of the review page.

Rule: a fault that a reviewer must know is on the page: what the check found, and what is wrong with a journal.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Protocol

from rai_missions.errors import DefinitionError, Fault
from rai_missions.mission.mission import Mission
from visualize.build import picture
from visualize.page.as_json import Json, named
from visualize.page.chart_data import chart_data
from visualize.page.html import document
from visualize.page.images import Gallery
from visualize.page.lenses import lenses
from visualize.page.runs import Run, read_run, run_data
from visualize.page.summary import summary

__all__ = ("Journal", "PageFinding", "review", "review_data")

Journal = Path | str | tuple[str, Path | str]
"""A file, or a name and the file."""


class PageFinding(Protocol):
    """What a check found."""

    @property
    def place(self) -> str:
        """JSON pointer."""

    @property
    def sentence(self) -> str: ...

    @property
    def severity(self) -> str:
        """`error` or `warning`."""


def review(
    mission: Mission,
    journals: Iterable[Journal] = (),
    findings: Iterable[PageFinding] = (),
    runs: Iterable[Run] = (),
) -> bytes:
    """The review page of a mission.

    Args:
        mission: The graph.
        journals: Files of its runs; a damaged one is reported on the page and shown as far as it can be read.
            One that is called otherwise than its file is a pair of name and file.
        findings: What a check found, for the places where it found it.
        runs: Runs that no journal holds.

    Raises:
        UsageError: A journal is not there, or may not be read.
        DefinitionError: A journal is of a mission of another name, or is none.
    """
    gallery = Gallery()
    files = [each if isinstance(each, tuple) else (Path(each).name, each) for each in journals]
    read = [_fitting(read_run(path, gallery, name=name), mission, name) for name, path in files]
    return document(review_data(mission, [*read, *runs], findings, gallery), title=mission.name)


def review_data(
    mission: Mission, runs: Sequence[Run] = (), findings: Iterable[PageFinding] = (), gallery: Gallery | None = None
) -> Json:
    """All that the review page shows."""
    gallery = gallery or Gallery()
    drawn = picture(mission)
    played = [run_data(run, gallery, None if run.faults else mission) for run in runs]
    return {
        "chart": chart_data(drawn, mission),
        "summary": named(summary(mission)),
        "lenses": lenses(mission, drawn),
        "findings": [{"place": each.place, "sentence": each.sentence, "severity": each.severity} for each in findings],
        "runs": played,
        "coverage": coverage(runs),
        "images": gallery.shown,
    }


def coverage(runs: Sequence[Run]) -> Json:
    """How often each transition was taken and each state entered, a number a run; only what was at all."""
    moves = [[move for step in run.steps for move in step.moves] for run in runs]
    return {
        "transitions": _counts([Counter(name for move in each for name in move.taken) for each in moves]),
        "states": _counts([Counter(name for move in each for name in move.entered) for each in moves]),
    }


def _counts(counted: Sequence[Counter[str]]) -> dict[str, list[int]]:
    """Name → how often it was counted in each run."""
    return {name: [each[name] for each in counted] for name in dict.fromkeys(chain.from_iterable(counted))}


def _fitting(run: Run, mission: Mission, path: str) -> Run:
    """A run with what keeps it from fitting the mission."""
    if not run.mission:
        return run
    try:
        ran: Any = json.loads(run.mission)
        name, version = str(ran["name"]), str(ran.get("version", "0.0.0"))
    except (ValueError, TypeError, KeyError, RecursionError):
        return _faulty(run, "row 0 holds no mission that can be read")
    if name != mission.name:
        sentence = f"this is the journal of another mission, '{name}' {version}, not of '{mission.name}'"
        raise DefinitionError([Fault("", f"{sentence}; give the mission that ran")], path)
    try:
        same = Mission.model_validate(ran) == mission
    except ValueError:
        same = False
    if same:
        return run
    which = f"version {version}" if version != mission.version else f"another mission called version {version} too"
    return _faulty(
        run,
        f"this is the journal of {which}, drawn on {mission.version}: transitions with other numbers are misplaced",
    )


def _faulty(run: Run, sentence: str) -> Run:
    return Run(run.name, run.mission, run.head, run.entries, run.notes, (sentence, *run.faults))

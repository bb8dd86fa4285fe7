# SPDX-License-Identifier: Apache-2.0
"""Killed after any row of a shipped mission, and resumed while its robot lives: it ends as it does without a death."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.replay.shipped import AfterRow, KilledRun, ShippedLand
from tests.rigs.journals import rows_of

pytestmark = pytest.mark.sim
MISSIONS = Path(__file__).parents[2] / "missions"
ALLEY = {"alleys": 1, "length_m": 12}
LONGEST_DEATH_S = 8.0
DEAF_S = 6.0
"""A middleware on a busy machine; longer than a handover may take, shorter than `ready_s`."""


class Job(NamedTuple):
    """A shipped mission in surroundings of its own."""

    folder: str
    options: Mapping[str, Any]
    arguments: Mapping[str, Any]
    why: str
    """Why it succeeds."""


ALLEYS = "'done' was reached, and alleys_driven ≥ alleys"
JOBS = {
    "branch": Job("tractor", {**ALLEY, "obstacles": ["branch"]}, {"alleys": 1}, ALLEYS),
    "animal": Job("tractor", {**ALLEY, "obstacles": ["animal"]}, {"alleys": 1}, ALLEYS),
    "patrol": Job("rosbot", {"camera": False}, {}, "'done' was reached, and supply is one of 1, 4"),
}


def driven(job: Job, path: Path, row: int | None, dead_s: float = 0.0) -> KilledRun:
    """Do a job, killed once or not at all."""
    there = ShippedLand(MISSIONS / job.folder, job.options, job.arguments)
    try:
        return there.drive(path, [] if row is None else [AfterRow(row)], dead_s, DEAF_S)
    finally:
        there.close()


def is_as_without(job: Job, outing: KilledRun) -> bool:
    return (outing.outcome, outing.why) == ("succeeded", job.why)


@pytest.mark.parametrize(
    ("name", "row"), [("branch", 9), pytest.param("branch", 10, marks=pytest.mark.long), ("patrol", 20)]
)
def test_killed_after_a_row_a_shipped_mission_ends_as_it_does_without(tmp_path: Path, name: str, row: int) -> None:
    """The tractor's: as it asks for control, and as it waits for it."""
    assert is_as_without(JOBS[name], driven(JOBS[name], tmp_path / "run.journal", row))


@pytest.mark.drill
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("dead_s", [0.0, LONGEST_DEATH_S])
@pytest.mark.parametrize("name", JOBS)
def test_killed_after_every_row(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, dead_s: float) -> None:
    logging.disable(logging.CRITICAL)
    began, job, ends = time.monotonic(), JOBS[name], Counter[str]()
    undisturbed = driven(job, tmp_path / "whole.journal", None)
    rows = len(rows_of(tmp_path / "whole.journal"))
    try:
        for row in range(1, rows):
            outing = driven(job, tmp_path / f"{row}.journal", row, dead_s)
            same = outing[:2] == undisturbed[:2]
            assert same or outing.is_led_by_doubt, (row, outing)
            ends["same" if same else f"in doubt: {outing.outcome}, {outing.why}"] += 1
    finally:
        logging.disable(logging.NOTSET)
        with capsys.disabled():
            print(f"\n{name}, alone for {dead_s:g} s: {rows} rows, {time.monotonic() - began:.0f} s: {dict(ends)}")  # noqa: T201 - the figure

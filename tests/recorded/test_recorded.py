# SPDX-License-Identifier: Apache-2.0
"""Runs that were recorded once are done again, step by step: what the engine made of their events, it makes today."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.engine.step import Step
from rai_missions.journal import Journal, StepRow, read

RUNS = Path(__file__).parents[1] / "data/runs"
FILES = sorted(path for path in RUNS.rglob("*") if path.is_file())
ABOUT = ("corners", "generated", "held", "included", "killed", "kinds", "patrol", "tractor", "trees")
"""The folders of the runs, of which none may be empty."""


def verdicts(folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, dict[str, Any]]:
    """What the command exits with, and its verdicts."""
    status = main(["replay", str(folder), "--json"])
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return status, found


def test_every_recorded_run_is_the_same_when_it_is_done_again(capsys: pytest.CaptureFixture[str]) -> None:
    status, found = verdicts(RUNS, capsys)
    assert [run for run in found["runs"] if not run["holds"]] == []
    assert status == 0 and found["holds"] is True
    assert [run["run"] for run in found["runs"]] == [path.relative_to(RUNS).as_posix() for path in FILES]
    assert {run["run"].split("/")[0] for run in found["runs"]} == set(ABOUT)
    assert {run["outcome"] for run in found["runs"]} == {"succeeded", "failed", "aborted", "canceled", None}


def test_the_recorded_runs_are_one_file_each_and_few_bytes() -> None:
    assert {path.suffix for path in FILES} == {".journal"}, "the log of a journal that was not closed is in the folder"
    assert sum(path.stat().st_size for path in FILES) <= 3 * 2**20


def alter(path: Path) -> None:
    """Change a row, as a hand would."""
    with closing(sqlite3.connect(path)) as database:
        row = "(SELECT min(number) FROM rows WHERE kind = 'step')"
        database.execute(f"UPDATE rows SET content = replace(content, '\"seq\":', '\"seq\": ') WHERE number = {row}")
        database.commit()


def forge(path: Path) -> None:
    """Write the run as another engine would have written it, every hash as it should be: it ended in another way."""
    with read(path) as record:
        header, rows = record.header, list(record.rows())
    path.unlink()
    with Journal.create(path, header) as journal:
        for row in rows:
            if isinstance(row, StepRow):
                journal.write(other(row.step, row is rows[-1]), since=row.since, quiet=row.before)


def other(step: Step, is_last: bool) -> Step:
    return step._replace(outcome="aborted") if is_last else step


@pytest.mark.parametrize(("change", "states"), [(alter, "row 1"), (forge, "outcome")])
def test_a_recorded_run_that_is_another_is_noticed_by_its_name(
    change: Callable[[Path], None], states: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("included/succeeded.journal", "trees/03.journal"):
        (tmp_path / name).parent.mkdir()
        shutil.copyfile(RUNS / name, tmp_path / name)
    change(tmp_path / "included/succeeded.journal")
    status, found = verdicts(tmp_path, capsys)
    assert status == 1 and found["holds"] is False
    first, second = found["runs"]
    assert (first["run"], first["holds"], second["holds"]) == ("included/succeeded.journal", False, True)
    assert states in first.get("fault", "") + first.get("difference", "")

# SPDX-License-Identifier: Apache-2.0
"""What is promised of a process that dies: no row that was written is lost, and no one else writes meanwhile."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rai_missions.errors import UsageError
from rai_missions.journal import Journal, read, verify

WRITER = """
import sys
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.engine.step import Step
journal = Journal.create(sys.argv[1], Header("{}"))
print("ready", flush=True)
for seq in range(1, 1_000_000):
    journal.write(Step(seq, float(seq), Event("anomaly", float(seq), {"text": "x" * 300})), since=0.0)
    print(seq, flush=True)
"""


def writer(path: Path, limit_bytes: int | None = None) -> subprocess.Popen[str]:
    def limited() -> None:
        if limit_bytes is not None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))

    return subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=limited,  # noqa: PLW1509 - there are no threads here
    )


def wait_for_rows(process: subprocess.Popen[str], last: int) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        if line == f"{last}\n":
            return


@pytest.mark.parametrize("rows", [1, 7, 2500])
def test_no_row_is_lost_when_the_process_is_killed(tmp_path: Path, rows: int) -> None:
    path = tmp_path / "j"
    with writer(path) as process:
        wait_for_rows(process, rows)
        process.kill()
        rest, _ = process.communicate()
    last = int(rest.split()[-1]) if rest.split() else rows
    left = sorted(item.name for item in tmp_path.iterdir())
    with read(path) as record:
        assert [step.seq for step in record.steps()][:last] == list(range(1, last + 1))
    assert verify(path) == ()
    assert sorted(item.name for item in tmp_path.iterdir()) == left
    with Journal.open(path) as journal:
        journal.note("resumed")
    assert verify(path) == ()


def test_no_one_writes_a_journal_that_another_process_writes(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with writer(path) as process:
        wait_for_rows(process, 1)
        try:
            with pytest.raises(UsageError, match="is being written by another process; wait for its end"):
                Journal.open(path)
            with read(path) as record:
                assert next(record.steps()).seq == 1
        finally:
            process.kill()
            process.communicate()
    Journal.open(path).close()


def test_a_full_disk_is_reported_and_costs_no_row_that_was_written(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with writer(path, limit_bytes=300_000) as process:
        reported, error = process.communicate()
    assert "ConnectorError: the journal " in error
    assert "is lost" in error.splitlines()[-1]
    with read(path) as record:
        assert [step.seq for step in record.steps()] == [int(line) for line in reported.split()[1:]]

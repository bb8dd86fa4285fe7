# SPDX-License-Identifier: Apache-2.0
"""What a machine does to a journal: torn, altered, on a disk that is full. The run continues, or it is reported why
not."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import ConnectorError, DefinitionError, UsageError
from rai_missions.journal import Journal, read, verify
from rai_missions.replay.open_run import open_run
from tests.replay.mortal import Fate, live
from tests.replay.test_kills import MISSION, ROBOT, holds, land, lived
from tests.rigs.runs import ReplyingAnswerer

WAL = "run.journal-wal"


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the journal of a run that died in its middle, and with its log, as a dead process leaves them."""
    folder = tmp_path_factory.mktemp("killed")

    def die() -> bool:
        Journal.close = lambda _: None  # type: ignore[method-assign]
        return (
            live(folder / "run.journal", land(), MISSION, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate(60)) is None
        )

    assert in_another_process(die)
    assert (folder / WAL).exists()
    return folder


def in_another_process(do: Callable[[], bool], most_bytes: int = resource.RLIM_INFINITY) -> bool:
    """Whether something is so in a process that then ends without tidying up, and whose files grow no further."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, resource.RLIM_INFINITY))
            status = 0 if do() else 1
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1] == 0


def torn(killed: Path, folder: Path, part: str, share: float) -> Path:
    """The journal with one of its files cut short."""
    for file in killed.iterdir():
        shutil.copyfile(file, folder / file.name)
    os.truncate(folder / part, int((folder / part).stat().st_size * share))
    return folder / "run.journal"


@given(st.floats(0, 1))
def test_a_log_that_is_torn_at_any_byte_is_continued_with_from_its_last_whole_row(
    killed: Path, tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    with read(killed / "run.journal") as record:
        whole = [raw[3] for raw in record.raw()]
        assert record.cut == 0
    path = torn(killed, tmp_path_factory.mktemp("torn"), WAL, share)
    size = path.with_name(WAL).stat().st_size
    try:
        taken = open_run(path)
    except (DefinitionError, UsageError) as error:
        is_reported = "no journal" in str(error) or "empty" in str(error)
        assert is_reported, "so little is left that there is no run"
        return
    with taken.record as record:
        left = [raw[3] for raw in record.raw()]
        assert left == whole[: len(left)]
        page = 4096 + 24
        assert record.cut < 4 * page
        assert (record.cut > 0) or (size - 32) % page == 0
    there = land()
    assert lived(path, there, []).outcome is not None
    holds(path, there)


@given(st.floats(0, 0.999))
def test_a_file_that_is_torn_is_refused_and_reported_to_be(
    killed: Path, tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    folder = tmp_path_factory.mktemp("torn")
    path = torn(killed, folder, WAL, 1.0)
    Journal.open(path).close()  # the log is folded in
    assert not path.with_name(WAL).exists()
    os.truncate(path, int(path.stat().st_size * share))
    with pytest.raises((DefinitionError, UsageError)) as refused:
        open_run(path)
    assert str(path) in str(refused.value)


def test_a_row_that_was_altered_is_named(killed: Path, tmp_path: Path) -> None:
    path = torn(killed, tmp_path, WAL, 1.0)
    with sqlite3.connect(path) as database:
        database.execute("UPDATE rows SET content = replace(content, '\"at\":', '\"at\": ') WHERE number = 7")
    database.close()
    with pytest.raises(DefinitionError, match=r"row 7: its hash .* the journal was altered after the run"):
        open_run(path)


def test_a_disk_that_is_full_when_the_run_continues_ends_it_before_anything_is_done(
    killed: Path, tmp_path: Path
) -> None:
    path = torn(killed, tmp_path, WAL, 1.0)

    def continues() -> bool:
        there = land()
        try:
            live(path, there, MISSION, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate())
        except ConnectorError as error:
            return "cannot be written" in str(error) and there.started == []
        return False

    assert in_another_process(continues, path.with_name(WAL).stat().st_size + 1)  # a copy of the log has room
    assert lived(path, land(), []).outcome is not None, "once there is room again, it continues"
    holds(path, land())


def test_a_disk_that_fills_up_kills_the_run_and_leaves_a_journal_that_can_be_continued_with(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"

    def is_killed() -> bool:
        there = land()
        result = live(path, there, MISSION, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate())
        return result is not None and result.outcome == "aborted" and "journal" in result.why and not there.running

    assert in_another_process(is_killed, 80_000)  # a larger disk has the end of the goals as well
    assert verify(path) == ()
    assert lived(path, land(), []).outcome == "failed", "the goals are gone, and the mission learns it"
    holds(path, land())


def test_a_journal_that_may_only_be_read_is_not_continued_with(killed: Path, tmp_path: Path) -> None:
    path = torn(killed, tmp_path, WAL, 1.0)
    with open_run(path).record as record:
        seal = record.seal
    if os.geteuid():
        path.chmod(0o444)
        with pytest.raises(UsageError, match="cannot be written"):
            Journal.open(path, seal=seal)
        path.chmod(0o644)
    with Journal.open(path, seal=seal) as journal:
        journal.note("another process continued")
    with pytest.raises(UsageError, match="another process has continued with the run"):
        Journal.open(path, seal=seal)

# SPDX-License-Identifier: Apache-2.0
"""Anyone who dies while a run is migrated has migrated it or has not, and no run continues twice."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.journal import Journal, verify
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.open_run import open_run
from rai_missions.replay.replay import replay
from tests.replay.mortal import Fate, live
from tests.replay.test_kills import ROBOT
from tests.replay.test_migration import ERRAND, continued, died, land
from tests.rigs.runs import ReplyingAnswerer

INSTANTS = frozenset({"execute", "rename", "unlink", "open", "flock", "close", "mkdir", "connect", "replace"})


def killed_at(number: int, do: Callable[[], object]) -> bool:
    """Do something in a process that kills itself at its so manyth call to the system or to SQLite; whether it did."""
    pid = os.fork()
    if not pid:
        left = [number]

        def count(frame: Any, event: str, what: Any) -> None:
            if event == "c_call" and getattr(what, "__name__", "") in INSTANTS:
                left[0] -= 1
                if left[0] < 0:
                    os.kill(os.getpid(), 9)

        sys.setprofile(count)
        try:
            do()
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(pid, 0)[1])


@pytest.mark.parametrize("every", [pytest.param(16, marks=pytest.mark.long), pytest.param(1, marks=pytest.mark.drill)])
def test_anyone_who_dies_while_migrating_has_migrated_or_has_not(tmp_path: Path, every: int) -> None:
    path = died(tmp_path / "run.journal", land())
    found, number, is_dead = set(), 0, True
    while is_dead:
        folder = tmp_path / str(number)
        folder.mkdir()
        was, new = folder / "run.journal", folder / "new.journal"
        shutil.copy(path, was)
        is_dead = killed_at(number, lambda was=was, new=new: migrate(was, ERRAND, Map(), to=new))  # type: ignore[misc]
        found.add(new.exists())
        if new.exists():
            open_run(new).record.close()
            assert verify(new) == () and replay(new).holds
            with pytest.raises(UsageError, match="continues in another mission"):
                open_run(was)
        else:
            open_run(was).record.close()
            migrate(was, ERRAND, Map(), to=new)
            open_run(new).record.close()
        number += every
    assert found == {True, False} and number > 20


def test_one_run_never_continues_in_two_journals(tmp_path: Path) -> None:
    """As if anyone who migrated had died before the old journal was notified of it."""
    there = land()
    path = died(tmp_path / "run.journal", there)
    unreported = Path(shutil.copy(path, tmp_path / "untold.journal"))
    new = migrate(path, ERRAND, Map(), to=tmp_path / "new.journal").journal
    shutil.copy(unreported, path)
    continued_run(path)
    with pytest.raises(UsageError, match=r"continued otherwise after .* was made of it; this journal counts no more"):
        open_run(new)
    shutil.copy(unreported, path)
    open_run(new).record.close()
    with pytest.raises(UsageError, match=r"continues in another mission: --resume .*new\.journal"):
        open_run(path)
    with pytest.raises(UsageError, match="continues in another mission"):
        migrate(path, ERRAND, Map(), to=tmp_path / "third.journal")


def test_no_journal_is_begun_where_no_one_would_look_whether_its_run_continued_otherwise(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", land())
    with pytest.raises(UsageError, match=r"in another folder than .*run\.journal.*: name a file next to it"):
        migrate(path, ERRAND, Map(), to=tmp_path / "elsewhere" / "new.journal")
    assert [each.name for each in tmp_path.iterdir()] == ["run.journal"]
    link = tmp_path / "linked"
    link.symlink_to(tmp_path)
    open_run(migrate(link / "run.journal", ERRAND, Map(), to=tmp_path / "new.journal").journal).record.close()


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Callable[[int], Path]]:
    """Makes disks of so many KiB."""
    made: list[Path] = []

    def make(kib: int) -> Path:
        disk = tmp_path / f"disk{kib}"
        disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={kib}k", "tmpfs", str(disk)]
        if shutil.which("mount") is None or subprocess.run(mount, check=False, capture_output=True).returncode:
            pytest.skip("only root may make a small disk")
        made.append(disk)
        return disk

    yield make
    for disk in made:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_disk_that_is_full_leaves_the_run_where_it_was(tmp_path: Path, small: Callable[[int], Path]) -> None:
    """At some sizes the log fits next to the journals, and what is in it does not fit into the new one."""
    path, found = died(tmp_path / "run.journal", land()), set()
    for kib in range(52, 96, 8):
        disk = small(kib)
        shutil.copy(path, disk / "run.journal")
        with suppress(UsageError, ConnectorError):
            migrate(disk / "run.journal", ERRAND, Map(), to=disk / "new.journal")
        continues = "new.journal" if (disk / "new.journal").exists() else "run.journal"
        open_run(disk / continues).record.close()
        assert {each.name for each in disk.iterdir()} == {"run.journal", continues}
        found.add(continues)
    assert found == {"new.journal", "run.journal"}


def continued_run(path: Path) -> None:
    """A process has continued with a run, and died."""
    live(path, land(), ERRAND, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate(1, what="write"))


def test_a_journal_is_never_overwritten_and_a_folder_may_be_moved(tmp_path: Path) -> None:
    there = land()
    (tmp_path / "here").mkdir()
    path = died(tmp_path / "here" / "run.journal", there)
    with pytest.raises(UsageError, match="is there already"):
        migrate(path, ERRAND, Map(), to=path)
    migrate(path, ERRAND, Map(), to=tmp_path / "here" / "new.journal")
    (tmp_path / "here").rename(tmp_path / "there")
    assert continued(tmp_path / "there" / "new.journal", there, ERRAND).outcome == "canceled"
    with pytest.raises(UsageError, match=r"there/new\.journal"):
        open_run(tmp_path / "there" / "run.journal")


def test_a_log_whose_journal_was_taken_away_is_not_read_into_the_one_that_is_made(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", land())
    shutil.copy(path, tmp_path / "new.journal")
    with Journal.open(tmp_path / "new.journal") as other:
        other.note("of another run")
        log = (tmp_path / "new.journal-wal").read_bytes()
    (tmp_path / "new.journal").unlink()
    (tmp_path / "new.journal-wal").write_bytes(log)
    migrate(path, ERRAND, Map(), to=tmp_path / "new.journal")
    assert verify(tmp_path / "new.journal") == ()
    open_run(tmp_path / "new.journal").record.close()


def test_a_place_where_no_journal_can_be_made_is_reported_in_a_sentence(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", land())
    with pytest.raises(UsageError, match=r"a journal cannot be written at .*: File name too long; name another file"):
        migrate(path, ERRAND, Map(), to=tmp_path / ("n" * 250))
    open_run(path).record.close()

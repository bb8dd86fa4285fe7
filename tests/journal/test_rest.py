# SPDX-License-Identifier: Apache-2.0
"""Journals at rest: their files are closed, their lock is held, and nothing else is different."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Header, Journal, read, set_aside, verify
from rai_missions.journal.open_files import OPEN, OpenFiles
from rai_missions.journal.sqlite import log_of
from tests.rigs.journals import listing, shown

HEADER = Header("{}", run="r")
PATIENCE_S = 30.0
BIG = "x" * 5_000
ROOT = Path(__file__).parents[2]


def rows_of(path: Path) -> list[object]:
    with read(path) as record:
        return [(raw[0], raw[1], raw[2]) for raw in record.raw() if raw[0]]


def wait_for(journals: OpenFiles, count: int) -> None:
    """Until so few have their files open."""
    is_done = threading.Event()
    for _ in range(int(PATIENCE_S * 1e3)):
        if journals.count <= count:
            return
        is_done.wait(1e-3)
    raise AssertionError(f"{journals.count} have their files open")


what = st.sampled_from(["note", "step", "confirm", "picture", "rest", "rest", "read"])


@settings(max_examples=settings.default.max_examples // 2)
@given(st.lists(st.tuples(st.integers(0, 2), what), max_size=30))
def test_journals_that_rest_have_the_rows_of_those_that_do_not(
    tmp_path_factory: pytest.TempPathFactory, done: list[tuple[int, str]]
) -> None:
    folder = tmp_path_factory.mktemp("rest")
    journals = [Journal.create(folder / str(number), HEADER) for number in range(3)]
    twins = [Journal.create(folder / f"twin {number}", HEADER) for number in range(3)]
    for place, (number, how) in enumerate(done):
        for each in (journals[number], twins[number]):
            if how == "note":
                each.note(BIG, place)
            elif how == "step":
                each.write(Step(place + 1, 0.0, Event("go")), since=0.0)
            elif how == "confirm":
                each.confirm(place, "performed")
            elif how == "picture":
                image = Image("camera@1", 100, 30, "rgb8", lambda filled=place: bytes([filled]) * 9_000)  # type: ignore[misc]
                each.write(shown(place + 1, image), since=0.0)
        if how == "rest":
            journals[number].rest()
        elif how == "read":
            before = listing(folder)
            assert rows_of(journals[number].path) == rows_of(twins[number].path)
            assert listing(folder) == before, "reading changes nothing"
    for each, twin in zip(journals, twins, strict=True):
        each.close()
        twin.close()
        assert verify(each.path) == ()
        assert rows_of(each.path) == rows_of(twin.path)
        with read(each.path) as record, read(twin.path) as other:
            assert list(record.pictures()) == list(other.pictures())
    assert sorted(os.listdir(folder)) == sorted(Path(each.path).name for each in [*journals, *twins]), "no log is left"
    shutil.rmtree(folder)


def test_a_journal_at_rest_has_a_writer(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        journal.rest()
        with pytest.raises(UsageError, match="is being written by this process already"):
            Journal.open(path)
        with pytest.raises(UsageError, match="is being written by this process already"):
            set_aside(path)
        program = "import sys; from rai_missions.journal import Journal; Journal.open(sys.argv[1])"
        ran = subprocess.run([sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=False)
        assert "is being written by another process; wait for its end" in ran.stderr
        assert journal.note("still its writer") == 1
    Journal.open(path).close()


def test_what_was_opened_to_be_read_stays_as_it_was_whatever_is_written_then(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        for number in range(1_000):
            journal.note(BIG, number)
        journal.rest()
        with read(path) as record:
            rows = record.raw()
            first = [next(rows) for _ in range(10)]
            for number in range(1_000):
                journal.note(BIG, number)
            journal.rest()
            assert len(first) + len(list(rows)) == 1_001
            assert next(iter(record.damage()), None) is None
    assert verify(path) == ()


def test_a_journal_at_rest_is_opened_again_without_a_look_along_its_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> str:
        raise AssertionError("where it is was found out when it was made")

    with Journal.create(tmp_path / "folder with #, % and ?" / "a", HEADER) as journal:
        journal.rest()
        with monkeypatch.context() as patch:
            patch.setattr(os.path, "realpath", refused)
            journal.note("written")
    assert [kind for _, kind, _ in rows_of(journal.path)] == ["note"]


@pytest.mark.parametrize("how", ["gone", "another", "altered"])
def test_no_row_is_written_into_what_took_the_place_of_a_journal_at_rest(tmp_path: Path, how: str) -> None:
    path, other = tmp_path / "j", tmp_path / "other"
    with Journal.create(other, HEADER) as journal:
        journal.note("of another run")
    with Journal.create(path, HEADER) as journal:
        journal.note("one")
        journal.rest()
        if how == "gone":
            path.rename(tmp_path / "moved")
        elif how == "another":
            other.rename(path)
        else:
            path.write_bytes(other.read_bytes())
        before = listing(tmp_path)
        reason = "its rows were altered meanwhile" if how == "altered" else "another file has its name, or none"
        with pytest.raises(ConnectorError, match=f"j cannot be written: {reason}"):
            journal.note("two")
        found = listing(tmp_path)
        assert {name: found[name][0] for name in before if name != "j-wal"} == {
            name: before[name][0] for name in before if name != "j-wal"
        }


def test_a_process_that_dies_while_journals_rest_leaves_them_whole(tmp_path: Path) -> None:
    program = """
        import os, signal, sys
        from rai_missions.journal import Header, Journal

        journals = [Journal.create(f"{sys.argv[1]}/{number}", Header("{}")) for number in range(6)]
        for number, journal in enumerate(journals):
            for row in range(20):
                journal.note("x" * 300)
                if number < 4:
                    journal.rest()
            if number == 3:
                journal.note("the last")
        os.kill(os.getpid(), signal.SIGKILL)
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program), str(tmp_path)], cwd=ROOT, check=False)
    for number in range(6):
        path = tmp_path / str(number)
        assert len(rows_of(path)) == 20 + (number == 3)
        assert log_of(path).exists()
        if number % 2:
            with Journal.open(path) as journal:
                journal.note("resumed")
        else:
            path = set_aside(path)
        assert verify(path) == () and not log_of(path).exists()


def test_those_that_were_written_last_stay_open(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journals = OpenFiles(kept=2, rest_s=0.01)
    monkeypatch.setattr("rai_missions.journal.writer.OPEN", journals)
    made = [Journal.create(tmp_path / str(number), HEADER) for number in range(6)]
    wait_for(journals, 2)
    assert [each.is_at_rest for each in made] == [True] * 4 + [False] * 2
    made[0].note("again")
    wait_for(journals, 2)
    assert [each.is_at_rest for each in made] == [False, *[True] * 4, False]
    for each in made:
        each.close()
    assert journals.count == 0
    assert [len(rows_of(tmp_path / str(number))) for number in range(6)] == [1, 0, 0, 0, 0, 0]


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries have no malloc_trim")
def test_what_journals_at_rest_have_freed_is_given_back(tmp_path: Path) -> None:
    program = """
        import os, sys, threading
        from pathlib import Path
        from rai_missions.journal import Header, Journal, open_files, writer

        def resident_kb():
            return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024

        open_files.PACE_S = 1e-3
        journals = writer.OPEN = open_files.OpenFiles(kept=100, rest_s=0.0)
        made = [Journal.create(f"{sys.argv[1]}/{number}", Header("{}")) for number in range(100)]
        before, moment = resident_kb(), threading.Event()
        journals.kept = 0
        made.append(Journal.create(f"{sys.argv[1]}/last", Header("{}")))
        for _ in range(30_000):
            if not journals.count and before - resident_kb() > 100 * 30:
                break
            moment.wait(1e-3)
        else:
            print(f"{journals.count} are open; {before} kB before, {resident_kb()} now")
    """
    arguments = [sys.executable, "-c", textwrap.dedent(program), str(tmp_path)]
    ran = subprocess.run(arguments, capture_output=True, text=True, cwd=ROOT, check=False)
    assert (ran.stdout, ran.returncode) == ("", 0), ran.stderr


def test_few_journals_stay_open_and_one_that_is_forgotten_is_not_counted(tmp_path: Path) -> None:
    before = OPEN.count
    with Journal.create(tmp_path / "one", HEADER) as journal:
        assert OPEN.count == before + 1 and not journal.is_at_rest
    assert OPEN.count == before


def test_more_journals_are_written_than_files_may_be_open_for_all(tmp_path: Path) -> None:
    program = """
        import random, resource, sys
        from rai_missions.journal import Header, Journal, verify

        resource.setrlimit(resource.RLIMIT_NOFILE, (80, 80))
        journals = [Journal.create(f"{sys.argv[1]}/{number}", Header("{}")) for number in range(45)]
        chance = random.Random(1)
        for _ in range(90):
            chance.choice(journals).note("x")
        for journal in journals:
            journal.close()
        print(sum(len(verify(f"{sys.argv[1]}/{number}")) for number in range(45)))
    """
    arguments = [sys.executable, "-c", textwrap.dedent(program), str(tmp_path)]
    ran = subprocess.run(arguments, capture_output=True, text=True, cwd=ROOT, check=False)
    assert (ran.stdout, ran.returncode) == ("0\n", 0), ran.stderr
    assert sorted(os.listdir(tmp_path)) == sorted(str(number) for number in range(45))

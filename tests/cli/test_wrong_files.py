# SPDX-License-Identifier: Apache-2.0
"""A file of another kind than a command takes is refused as unusable: exit status 2, a sentence, nothing written."""

from __future__ import annotations

import io
import json
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import counted
from tests.rigs.signals import in_terminal

MISSION = {
    "format": 1,
    "name": "short",
    "initial": "a",
    "states": {"a": {"transitions": [{"after_s": 0.01, "to": "b"}]}, "b": {"final": "canceled"}},
}
JOURNALS, MISSIONS, OTHERS = {"run.journal"}, {"m.json"}, {"picture.png", "empty", "other.db", "folder", "/dev/null"}
TAKES = {
    "verify FILE": JOURNALS,
    "replay FILE": {*JOURNALS, "folder"},
    "run --resume FILE": set(),
    "draw m.json --journal FILE -o out.dot": JOURNALS,
    "check FILE": MISSIONS,
    "diff m.json FILE": MISSIONS,
    "prove FILE": MISSIONS,
    "draw FILE -o out.dot": MISSIONS,
    "try FILE --terminal": MISSIONS,
    "run m.json --robot FILE": set(),
    "run m.json --guards FILE": set(),
    "run --resume run.journal m.json --migrate FILE": set(),
    "campaign check FILE": set(),
    "campaign report FILE": set(),
}
"""Command → what it has use for."""
WRITES = (
    "run m.json --journal FOLDER/a.journal",
    "run m.json --record FOLDER/a.mcap",
    "run m.json --picture FOLDER/a.dot",
    "draw m.json -o FOLDER/a.md",
    "draw m.json -o FOLDER/a.html",
    "diff m.json m.json -o FOLDER/a.json",
    "try m.json --terminal --journal FOLDER/a.journal",
    "try m.json --terminal --as-test FOLDER/test_a.py",
)
"""Commands that write a file into a folder."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("m.json").write_text(json.dumps(MISSION))
    main(["run", "m.json", "--journal", "run.journal"])
    Path("picture.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    Path("empty").touch()
    Path("folder").mkdir()
    with closing(sqlite3.connect("other.db")) as database:
        database.execute("CREATE TABLE notes (text)")
        database.commit()
    return tmp_path


@pytest.mark.parametrize("command", TAKES)
def test_a_file_of_another_kind_is_refused_as_unusable(
    command: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.is_file() and path.read_bytes() for path in folder.iterdir()}
    for file in sorted((JOURNALS | MISSIONS | OTHERS) - TAKES[command]):
        capsys.readouterr()
        try:
            status = main(command.replace("FILE", file).split())
        except SystemExit as refused:  # by argparse
            status = refused.code
        reported = capsys.readouterr().err
        assert status == 2 and reported and "Traceback" not in reported, (file, status, reported)
        assert {path: path.is_file() and path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("command", WRITES)
def test_what_a_command_writes_has_its_folder_made(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("start\n"))
    main([word.replace("FOLDER", "new/und Größe") for word in command.split()])
    (written,) = (path for path in Path("new/und Größe").iterdir() if "a." in path.name)
    assert written.stat().st_size


@pytest.mark.parametrize("command", WRITES)
def test_a_file_where_a_folder_is_wanted_is_named_as_one(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("start\nq\n"))
    capsys.readouterr()
    main([word.replace("FOLDER", "empty") for word in command.split()])
    assert capsys.readouterr().err.endswith(": Not a directory; name another file\n")
    assert not Path("empty").stat().st_size


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_a_command_is_imported_is_its_exit_status_and_no_traceback(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_: str) -> None:
        signal.raise_signal(number)

    monkeypatch.setattr("rai_missions.cli.main.load_command", interrupted)
    with in_terminal():
        before = [signal.getsignal(each) for each in signal.valid_signals()]
        assert main(["check", "m.json"]) == 128 + number
        assert [signal.getsignal(each) for each in signal.valid_signals()] == before
    assert capsys.readouterr().err == "interrupted\n"


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 1', "3"])
def test_of_a_file_of_which_nothing_is_read_no_rest_is_promised(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "m.json"
    path.write_text(text)
    assert main(["check", str(path)]) == 2
    *faults, summary = capsys.readouterr().err.splitlines()
    assert summary == f"{path}: mission: {counted(len(faults), 'error')}, 0 warnings"

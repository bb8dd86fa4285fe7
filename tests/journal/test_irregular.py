# SPDX-License-Identifier: Apache-2.0
"""What is no regular file is reported as what it is, wherever one is read, and never waited for."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import irregular

INNER = {"name": "inner", "initial": "a", "states": {"a": {"final": "failed"}}}
OUTER = {"name": "outer", "initial": "a", "states": {
    "a": {"mission": "f.json", "transitions": [{"on": "*", "to": "b"}]}, "b": {"final": "failed"}}}  # fmt: skip


def _socket(path: Path) -> None:
    socket.socket(socket.AF_UNIX).bind(os.path.relpath(path))  # an address holds about 100 characters


SORTS: dict[str, Callable[[Path], object]] = {
    "a named pipe (FIFO)": os.mkfifo,
    "a socket": _socket,
    "a folder": Path.mkdir,
    "a device": lambda path: path.symlink_to("/dev/zero"),
}
READERS = {
    "a mission": ["check", "f.json"], "a Python mission": ["check", "f.py"], "a replay": ["replay", "f.journal"],
    "a resume": ["run", "--resume", "f.journal"], "a new journal": ["run", "inner.json", "--journal", "f.journal"],
    "a profile": ["run", "inner.json", "--robot", "f.json"], "guards": ["run", "inner.json", "--guards", "f.py"],
    "an included mission": ["check", "outer.json"], "as text": ["textconv", "f.json"],
    "a map": ["run", "--resume", "run.journal", "inner.json", "--migrate", "f.json"],
}  # fmt: skip
OTHERWISE = {("an included mission", "a device"), ("a replay", "a folder")}
"""A link that leads out of the mission's folder; a folder of runs."""


@pytest.mark.parametrize("reader", sorted(READERS.keys() - {"a new journal"}))
def test_a_file_that_is_not_there_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], reader: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("inner.json").write_text(json.dumps(INNER))
    Path("outer.json").write_text(json.dumps(OUTER))
    if reader == "a map":
        main(["run", "inner.json", "--journal", "run.journal"])
        capsys.readouterr()
    assert main(READERS[reader]) == 2
    line = capsys.readouterr().err.splitlines()[0]
    name = "f.json" if reader == "an included mission" else next(each for each in READERS[reader] if each[:2] == "f.")
    assert name in line and "Errno" not in line


@pytest.mark.timeout(60)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("sort", SORTS)
@pytest.mark.parametrize("reader", READERS)
def test_it_is_reported_as_what_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], reader: str, sort: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("inner.json").write_text(json.dumps(INNER))
    Path("outer.json").write_text(json.dumps(OUTER))
    if reader == "a map":
        main(["run", "inner.json", "--journal", "run.journal"])
    for name in ("f.json", "f.py", "f.journal"):
        if name in READERS[reader] or (reader == "an included mission" and name == "f.json"):
            SORTS[sort](Path(name))
    assert main(READERS[reader]) == 2
    printed = capsys.readouterr().err
    if (reader, sort) not in OTHERWISE:
        assert sort in printed, printed


def test_what_is_regular_or_absent_is_not_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("file")
    (tmp_path / "circle").symlink_to("circle")
    for name in ("file", "link", "circle", "nothing", "n\0", "n" * 5000):
        assert irregular(tmp_path / name) == ""

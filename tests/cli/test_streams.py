# SPDX-License-Identifier: Apache-2.0
"""Whatever the standard streams are, a command does its work and reports its status."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.journal import read, verify
from rai_missions.mission.schema import mission_schema
from tests.rigs.lamp import lamp_folder

LAMP = {
    "format": 1, "name": "lamp", "initial": "off", "states": {
        "off": {"about": "dünkel …", "entry": [{"say": "hällo → ☃"}], "transitions": [{"after_s": 0.01, "to": "on"}]},
        "on": {"final": "aborted"},
    },
}  # fmt: skip
RUN = ("run", "lamp.json", "--journal", "a.journal")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return lamp_folder(tmp_path, monkeypatch, LAMP)


def shell(command: str, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """A command line of a shell, in which `$@` is the program with these words."""
    program = [sys.executable, "-m", "rai_missions", *words]
    return subprocess.run(
        ["sh", "-c", command, "sh", *program],
        capture_output=True,
        text=True,
        check=False,
        errors="replace",
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONUNBUFFERED": "", **variables},
    )


def test_what_a_terminal_cannot_show_is_printed_as_its_escape(folder: Path) -> None:
    done = shell('"$@"', *RUN, PYTHONIOENCODING="latin-1")
    assert (done.returncode, done.stderr) == (1, "")
    assert r"off \u2192 on" in done.stdout and "aborted: 'on' was reached" in done.stdout
    assert json.loads(shell('"$@"', "schema", PYTHONIOENCODING="ascii").stdout) == mission_schema()


@pytest.mark.parametrize("closed", ["<&-", "<&- >&- 2>&-"])
def test_a_stream_that_is_closed_ends_no_run(folder: Path, closed: str) -> None:
    done = shell(f'"$@" {closed}', *RUN)
    assert (done.returncode, done.stderr) == (1, "")
    assert verify("a.journal") == ()


def test_a_run_whose_reader_has_gone_ends_as_it_would_and_without_a_traceback(folder: Path) -> None:
    done = shell('{ "$@"; echo "status $?" >&2; } | true', *RUN)
    assert done.stderr == "status 1\n"
    with read("a.journal") as record:
        assert list(record.steps())[-1].outcome == "aborted"


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (("textconv", "lamp.json"), 0),
        (("draw", "lamp.json", "-o", "lamp.svg"), 0),
        (("diff", "lamp.json", "lit.json"), 1),
        (("schema", "mission"), 128 + signal.SIGPIPE),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_a_command_whose_reader_has_gone_exits_as_it_would_unless_it_has_more_to_print(
    folder: Path, words: tuple[str, ...], status: int
) -> None:
    final = {"on": {"final": "succeeded"}}
    Path("lit.json").write_text(json.dumps({**LAMP, "states": {**LAMP["states"], **final}}), encoding="utf-8")
    done = shell('{ "$@"; echo "status $?" >&2; } | true', *words)
    assert done.stderr == f"status {status}\n"


def test_a_full_disk_behind_the_output_is_reported(folder: Path) -> None:
    done = shell('"$@" > /dev/full', "check", "lamp.json")
    assert done.returncode == 2 and done.stderr == "rai-missions check: [Errno 28] No space left on device\n"


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("9" * 5000, "does not fit in 64 bits; give a smaller number"),
        ("[NaN]", "/0: 'NaN' is not a number that JSON has; give a finite one"),
        ("[" * 50_000, "more than 100 objects and lists inside each other; nest less"),
        ("[" * 200 + "]" * 200, "more than 100 objects and lists inside each other; nest less"),
        (r'["\ud800"]', "holds half a character (a lone surrogate); write it whole"),
    ],
    ids=["digits", "NaN", "open", "deep", "half"],
)
def test_an_argument_has_the_limits_of_a_file(
    folder: Path, capsys: pytest.CaptureFixture[str], value: str, sentence: str
) -> None:
    assert main([*RUN, "--set", f"stops={value}"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("--set stops: /") and sentence in error
    assert not os.path.exists("a.journal")


def test_a_name_that_is_no_text_is_a_file_as_any_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "made", "--template", "python"]) == 0
    folder, mission, robot, journal, page = (
        os.fsdecode(name) for name in (b"m\xfc", b"m\xfc.py", b"r\xfc.py", b"j\xfc.journal", b"p\xfc.html")
    )
    Path("made").rename(folder)
    monkeypatch.chdir(folder)
    Path("mission.py").rename(mission)
    Path("robot.py").rename(robot)
    assert main(["run", mission, "--robot", robot, "--speed", "max", "--no-operator", "--journal", journal]) == 0
    for command in (["check", mission], ["replay", journal], ["draw", mission, "--journal", journal, "-o", page]):
        assert main(command) == 0, command
    assert "all the same; succeeded" in capsys.readouterr().out
    with read(journal) as record:
        assert json.loads(record.header.profile)["connector"]["file"] == r"r\xfc.py"

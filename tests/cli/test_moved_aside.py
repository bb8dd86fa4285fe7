# SPDX-License-Identifier: Apache-2.0
"""A journal whose name another run takes is moved aside, whole, and every output reports where it is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rai_missions.agents.mission import run
from rai_missions.cli.main import main
from rai_missions.errors import MissionError
from rai_missions.journal import read

MISSION = {
    "name": "short",
    "initial": "a",
    "states": {"a": {"transitions": [{"after_s": 0.05, "to": "b"}]}, "b": {"final": "canceled"}},
}
SENTENCE = "the journal of an earlier run, which had this name, is now out.1.journal"


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.json").write_text(json.dumps(MISSION))


def seal(path: str) -> str:
    with read(path) as record:
        return record.seal


def test_the_terminal_states_it_once_at_the_start(capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "m.json", "--journal", "out.journal"])
    first = seal("out.journal")
    assert "earlier run" not in capsys.readouterr().out
    main(["run", "m.json", "--journal", "out.journal"])
    head, _, tail = capsys.readouterr().out.partition("canceled: ")
    assert head.count(SENTENCE) == 1 and SENTENCE not in tail
    assert seal("out.1.journal") == first != seal("out.journal")


def test_json_and_the_result_have_a_field_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for _ in range(3):
        main(["run", "m.json", "--journal", "out.journal", "--json"])
        found.append(json.loads(capsys.readouterr().out)["moved_aside"])
    assert found == [None, "out.1.journal", "out.2.journal"]
    assert run("m.json", journal="out.journal").moved_aside == "out.3.journal"
    assert run("m.json", journal="other.journal").moved_aside is None


@pytest.mark.parametrize(
    "words",
    [
        ["--set", "speed=1"], ["--robot", "absent.json"], ["--model", "nobody"], ["--picture", "path.gif"],
        ["--picture", "out.journal"], ["--journal", "m.json"], ["--journal", "m.json/out.journal"],
        ["--resume", "out.journal"],
    ],
    ids=" ".join,
)  # fmt: skip
def test_a_run_that_is_refused_leaves_the_journal_and_the_recording_of_an_earlier_one(words: list[str]) -> None:
    pytest.importorskip("mcap")
    main(["run", "m.json", "--journal", "out.journal", "--record", "out.mcap"])
    before = {path: path.read_bytes() for path in Path().iterdir()}
    given = [] if "--resume" in words else ["m.json", *([] if "--journal" in words else ["--journal", "out.journal"])]
    assert main(["run", *given, "--record", "out.mcap", *words]) == 2
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


def test_a_run_whose_journal_cannot_be_made_leaves_what_had_the_names_of_its_files(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("mcap")
    run("m.json", journal="out.journal", record="out.mcap")
    before = {path: path.read_bytes() for path in Path().iterdir()}
    monkeypatch.setattr("rai_missions.journal.writer.ROW", "INSERT INTO nothing VALUES (?, ?, ?, ?)")
    with pytest.raises(MissionError):
        run("m.json", journal="out.journal", record="out.mcap")
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("run m.json --journal a.svg --picture ./a.svg", "--journal and --picture name one file, './a.svg'"),
        ("diff m.json other.json -o m.json", "OLD and --output name one file, 'm.json'"),
        ("diff m.json other.json -o other.json", "NEW and --output name one file, 'other.json'"),
        ("try m.json --terminal --as-test m.json", "MISSION and --as-test name one file, 'm.json'"),
        ("prove m.json -o m.json", "MISSION and --output name one file, 'm.json'"),
    ],
)
def test_what_is_written_takes_the_place_of_nothing_else_on_the_command_line(
    words: str, named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("other.json").write_text(json.dumps(MISSION))
    assert main(words.split()) == 2
    assert f"{named}; name two" in capsys.readouterr().err
    assert json.loads(Path("m.json").read_text()) == json.loads(Path("other.json").read_text()) == MISSION


def test_a_run_that_cannot_be_drawn_reports_its_outcome(capsys: pytest.CaptureFixture[str]) -> None:
    Path("path.svg").mkdir()
    assert main(["run", "m.json", "--journal", "out.journal", "--picture", "path.svg", "--json"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["outcome"] == "canceled"
    assert "the run was not drawn: " in printed.err and "path.svg" in printed.err

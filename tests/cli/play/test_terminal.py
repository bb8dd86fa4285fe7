# SPDX-License-Identifier: Apache-2.0
"""`rai-missions try` at the terminal, and what `verify` makes of a play."""

from __future__ import annotations

import importlib.util
import io
import json
import sqlite3
import stat
import webbrowser
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.cli.play.page import opened
from rai_missions.cli.play.session import PlayFiles, PlaySession
from rai_missions.cli.play.terminal import TerminalPlay
from rai_missions.errors import DefinitionError
from rai_missions.mission.files import load
from rai_missions.replay.play import PlaySource

DOOR: dict[str, Any] = {
    "format": 1, "name": "door", "initial": "shut", "events": {"knock": {"about": "someone knocks"}},
    "blackboard": {
        "battery": {"type": "number", "source": "robot", "max_age_s": 2},
        "visitor": {"type": "object", "source": "robot", "optional": True,
                    "fields": {"name": "string", "known": "boolean"}},
    },
    "states": {
        "shut": {"transitions": [{"on": "knock", "to": "asking"}]},
        "asking": {
            "decision": {"question": "Open?", "ask": ["operator"], "fallback": "no", "deadline_s": 20,
                         "evidence": ["visitor"],
                         "options": {"yes": {"when": {"key": "visitor.known", "==": True}}, "no": {}}},
            "transitions": [{"on": "yes", "to": "open"}, {"on": "no", "to": "shut"}],
        },
        "open": {"final": "aborted"}, "flat": {"final": "failed"},
    },
    "transitions": [{"when": {"not": {"fresh": "battery"}}, "to": "flat"}],
}  # fmt: skip


@pytest.fixture
def door(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "door.json"
    path.write_text(json.dumps(DOOR), encoding="utf-8")
    return path


def test_without_the_page_s_packages_the_terminal_is_named(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert main(["try", str(door), "--no-browser"]) == 2
    assert capsys.readouterr().err.rstrip().endswith("; or play at the terminal: --terminal")


def typed(monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in lines)))


def test_a_text_without_letters_is_shown_as_one(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tag = {"tag": {"type": "string", "source": "robot"}}
    door.write_text(json.dumps(DOOR | {"blackboard": DOOR["blackboard"] | tag}), encoding="utf-8")
    typed(monkeypatch, "readings tag=", "q")
    assert main(["try", "door.json"]) == 0
    assert 'tag ("", 0 s old)' in capsys.readouterr().out


def test_what_is_piped_is_played_saved_and_written_as_a_test(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(
        monkeypatch,
        "?",
        "1",
        "start",
        "event knock",
        "u",
        "key visitor name=Ada known=true",
        "event knock",
        "t 5",
        "m",
        "answer 1 no",
        "event knock",
        "n",
        "u 2",
        "event knock",
        "s p.journal",
        "answer 2 yes",
        "q",
    )
    assert main(["try", "door.json", "--as-test", "test_door.py"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    for words in (
        "You are the robot, and everyone else",
        "the mission waits for:",
        "event knock; someone knocks",
        "the operator is asked: Open?, 15 s left",
        "    visitor: ",
        "shut → asking",
        "the mission ended aborted: 'open' was reached",
        "saved p.journal",
        "wrote test_door.py",
    ):
        assert words in printed.out, words
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert main(["replay", "p.journal"]) == 0
    assert main(["draw", "door.json", "--journal", "p.journal", "-o", "p.dot"]) == 0
    assert 'assert chart.outcome == "aborted"' in Path("test_door.py").read_text(encoding="utf-8")


def test_an_order_is_taken_by_its_whole_word_too(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(monkeypatch, "help", "1", "start", "event knock", "undo", "wait 5", "save p.journal", "exit", "event no")
    assert main(["try", "door.json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "saved p.journal" in printed.out
    assert printed.out.count("NUMBER") > 1, "the list of what can be typed"


def test_verify_takes_no_play_for_evidence(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(monkeypatch, "1", "start", "event knock")
    assert main(["try", "door.json", "--journal", "p.journal"]) == 0
    capsys.readouterr()
    assert main(["verify", "p.journal"]) == 1
    assert capsys.readouterr().out == "intact, played: no evidence\n"
    assert main(["run", "--resume", "p.journal"]) == 2
    assert "was played by a person" in capsys.readouterr().err
    with closing(sqlite3.connect("p.journal")) as database, database:
        database.execute("UPDATE rows SET content = replace(content, '\"played\":true', '\"played\":false')")
    assert main(["verify", "p.journal"]) == 1
    assert "row 0: its hash" in capsys.readouterr().out


def test_verify_finds_a_run_intact(door: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lamp = {"name": "lamp", "initial": "on", "states": {"on": {"final": "aborted"}}}
    Path("lamp.json").write_text(json.dumps(lamp), encoding="utf-8")
    main(["run", "lamp.json", "--journal", "a.journal"])
    capsys.readouterr()
    assert main(["verify", "a.journal"]) == 0
    assert capsys.readouterr().out.startswith("intact; its last row has the hash ")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("event knok", "did you mean 'event knock'"), ("99", "there is no choice 99"), ("t soon", "give seconds"),
        ("key battery full", "'battery' is of type number"), ("key battery 1 2", "takes 1 values"), ("u x", "u 2"),
        ("key visitor 'x", "No closing quotation"), ("test", "name the file"), ("t 0", "above 0"),
    ],
)  # fmt: skip
def test_a_piped_line_at_fault_ends_the_play(
    door: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], line: str, why: str
) -> None:
    typed(monkeypatch, "1", "start", line)
    assert main(["try", "door.json"]) == 2
    assert why in capsys.readouterr().err


def test_each_choice_can_be_typed_by_the_name_that_is_listed(door: Path) -> None:
    session = PlaySession(load(door), PlayFiles(PlaySource(door)))
    for name in ("readings", "start", "event knock"):
        out, lines = io.StringIO(), io.StringIO(f"?\n{name}\nq\n")
        names = [choice.name for choice in session.play.choices()]
        TerminalPlay(session, lines, out, is_person=False).run()
        listed = out.getvalue().partition("names now: ")[2].partition("> ")[0]
        assert name in names and sorted(" ".join(listed.split()).split(", ")) == sorted(names)


def test_a_play_that_was_saved_elsewhere_is_saved_at_its_end_too(door: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    typed(monkeypatch, "1", "start", "s aside.journal", "q")
    assert main(["try", "door.json", "--journal", "asked.journal"]) == 0
    assert door.with_name("aside.journal").is_file() and door.with_name("asked.journal").is_file()


def test_a_person_is_asked_for_values_and_asked_again_after_a_fault(door: Path) -> None:
    out = io.StringIO()
    session = PlaySession(load(door), PlayFiles(PlaySource(door)))
    lines = io.StringIO("readings\nstart\nnonsense\nkey visitor\nAda\n\nu\nq\n")
    TerminalPlay(session, lines, out, is_person=True).run()
    assert "! 'nonsense' cannot happen now" in out.getvalue()
    assert "  visitor.known (true, false) [false]: " in out.getvalue()
    assert len(session.play.path) == 2


@pytest.mark.parametrize(
    ("order", "refusal"),
    [
        ("test taken/door.py", "a test cannot be written at taken/door.py: Not a directory; name another file"),
        ("test folder", "a test cannot be written at folder: Is a directory; name another file"),
        ("s folder", "a journal cannot be written at folder: Is a directory; name another file"),
    ],
)
def test_a_file_that_cannot_be_written_ends_no_play(door: Path, order: str, refusal: str) -> None:
    Path("taken").touch()
    Path("folder").mkdir()
    out = io.StringIO()
    session = PlaySession(load(door), PlayFiles(PlaySource(door)))
    lines = io.StringIO(f"readings\n{order}\ns kept.journal\nq\n")
    TerminalPlay(session, lines, out, is_person=True).run()
    assert f"! {refusal}" in out.getvalue() and "saved kept.journal" in out.getvalue()
    assert sorted(path.name for path in Path().iterdir()) == ["door.json", "folder", "kept.journal", "taken"]


def test_a_mission_in_python_is_not_played_where_python_is_refused(
    door: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.py").write_text("raise SystemExit('it ran')", encoding="utf-8")
    assert main(["try", "m.py", "--terminal", "--no-python"]) == 2
    assert main(["try", "door.json", "--terminal", "--no-python", "--guards", "m.py"]) == 2
    assert "it ran" not in capsys.readouterr().err


def test_a_mission_with_faults_is_not_played(door: Path) -> None:
    mission = load(door)
    broken = mission.model_copy(update={"initial": ("nowhere",)})
    with pytest.raises(DefinitionError, match="nowhere"):
        PlaySession(broken)


def test_the_browser_is_given_a_file_of_ones_own_and_no_token(door: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command line can be read by every user of the machine."""
    given: list[str] = []
    monkeypatch.setattr(webbrowser, "open", given.append)
    with opened("http://127.0.0.1:1/#token=abc&x"):
        (address,) = given
        assert "abc" not in address
        file = Path(address.removeprefix("file://"))
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert 'content="0;url=http://127.0.0.1:1/#token=abc&amp;x"' in file.read_text(encoding="utf-8")
    assert not file.exists()

# SPDX-License-Identifier: Apache-2.0
"""A mission, profile, journal or recording from elsewhere is data: it runs nothing and reads nothing but itself."""

from __future__ import annotations

import json
import os
import shutil
import socket
import sqlite3
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.cli.commands import load_command, names
from rai_missions.cli.main import main
from rai_missions.cli.run.find_page import running_page
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from tests.fuzz.seeds import LAMP, written_run

ROOT = Path(__file__).parents[2]
OWN = tuple(
    os.path.realpath(str(each))
    for each in (
        sys.prefix,
        sys.base_prefix,
        *sysconfig.get_paths().values(),
        ROOT / "rai_missions",
        ROOT / "visualize",
        "/usr/lib",
        "/usr/share",
        "/lib",
        "/proc",
        "/sys",
        "/dev/null",
        "/dev/urandom",
        "/etc/ld.so.cache",
    )
)
"""Where the program itself, its libraries and the system are."""
SECRET = "a secret of another user"


class Done(NamedTuple):
    """What commands did."""

    ended: list[int]
    received: list[tuple[str, str]]

    def of(self, kind: str) -> set[str]:
        return {what for each, what in self.received if each == kind}


class Place:
    """A folder that came from elsewhere, one that it has no business in, and one to write into."""

    def __init__(self, folder: Path) -> None:
        self.given, self.outside, self.out = folder / "given", folder / "outside", folder / "out"
        for each in (self.given, self.outside, self.out):
            each.mkdir()
        dump(LAMP, self.outside / "secret.json")
        (self.outside / "description.md").write_text(SECRET)
        dump(LAMP, self.given / "lamp.json")

    def put(self, name: str, value: Any) -> str:
        (self.given / name).write_text(json.dumps(value))
        return str(self.given / name)

    def watch(self, *commands: Sequence[str]) -> Done:
        """Run commands in the given folder, which is where an unwary program would import from."""
        own = {"PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1", "TMPDIR": str(self.out)}
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-P", str(ROOT / "tests/security/watched.py")],
            input=json.dumps(commands),
            capture_output=True,
            text=True,
            cwd=self.given,
            env=os.environ | own,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        assert "Traceback" not in done.stderr, done.stderr
        assert SECRET not in done.stdout + done.stderr
        printed = json.loads(done.stdout.splitlines()[-1])
        return Done(printed["ended"], [(kind, what) for kind, what in printed["received"]])

    def assert_harmless(self, done: Done) -> None:
        roots = (*OWN, os.path.realpath(self.given), os.path.realpath(self.out))
        assert not done.of("reach") and not done.of("start")
        assert {each for each in done.of("read") if not each.startswith(roots)} <= {str(ROOT)}  # where imports look
        assert {
            each for each in done.of("write") if not each.startswith((os.path.realpath(self.out), "/dev/"))
        } == set()
        assert {each for each in done.of("execute") if not each.startswith((*OWN, "<"))} == set()


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path)


def reviews(place: Place, mission: str) -> list[list[str]]:
    """What someone does with a mission before it runs."""
    return [
        ["check", mission],
        *(["draw", mission, "-o", str(place.out / f"picture.{form}")] for form in ("dot", "mmd", "md", "html")),
        ["diff", mission, str(place.given / "lamp.json")],
    ]


def test_a_file_outside_that_is_read_would_be_noticed(place: Place) -> None:
    (place.given / "evil.py").write_text(f"open({str(place.outside / 'secret.json')!r}).read()")
    done = place.watch(["check", str(place.given / "evil.py")])
    assert str(place.outside / "secret.json") in done.of("read")
    assert str(place.given / "evil.py") in done.of("execute")
    with pytest.raises(AssertionError):
        place.assert_harmless(done)


def test_good_data_is_reviewed_without_running_or_reaching_anything(place: Place) -> None:
    journal = str(written_run(place.given, record=True))
    mission, recording = str(place.given / "lamp.json"), str(place.given / "run.mcap")
    for module in ("yaml", "jsonschema", "pydantic_core", "sitecustomize", "visualize"):  # what a program might import
        (place.given / f"{module}.py").write_text("raise SystemExit(9)")
    page = ["draw", mission, "-o", str(place.out / "run.html")]
    done = place.watch(
        *reviews(place, mission),
        ["replay", journal],
        ["replay", recording],
        [*page, "--journal", journal],
        [*page, "--journal", recording],
    )
    place.assert_harmless(done)
    assert done.ended == [0] * len(done.ended)


def test_an_inclusion_reads_nothing_outside_of_the_folder(place: Place) -> None:
    (place.given / "link.json").symlink_to(place.outside / "secret.json")
    (place.given / "folder").symlink_to(place.outside)
    (place.given / "code.py").write_text("raise SystemExit(9)")
    named = ["../outside/secret.json", str(place.outside / "secret.json"), "link.json", "folder/secret.json", "code.py"]
    files = [
        place.put(f"m{number}.json", {**LAMP.written(), "initial": "x", "states": {"x": {"mission": each}}})
        for number, each in enumerate(named)
    ]
    done = place.watch(*(command for file in files for command in reviews(place, file)))
    place.assert_harmless(done)
    assert set(done.ended) == {2}


def test_a_profile_reads_nothing_outside_of_its_folder_and_imports_nothing(place: Place) -> None:
    (place.given / "link").symlink_to(place.outside)
    (place.given / "evil").mkdir()
    (place.given / "evil/__init__.py").write_text("raise SystemExit(9)")
    battery = {"topic": "/battery", "type": "evil/msg/Float64"}
    base = {"format": 1, "name": "r", "connector": {"kind": "ros2", "arguments": ["--params-file", "/etc/passwd"]}}
    base["events"] = {"tap": {"topic": "/tap", "type": "this/msg/Zen"}}
    profiles = [
        place.put(f"r{number}.json", {**base, "blackboard": {"battery": battery}, "identity": identity})
        for number, identity in enumerate(["", "../outside", str(place.outside), "link"])
    ]
    done = place.watch(*(["check", str(place.given / "lamp.json"), "--robot", each] for each in profiles))
    place.assert_harmless(done)
    assert done.ended == [0, 2, 2, 2]


def test_a_journal_s_own_code_is_refused_unrun_and_its_neighbours_are_left_alone(place: Place) -> None:
    hostile = {
        "trigger": "CREATE TRIGGER t AFTER INSERT ON rows BEGIN DELETE FROM rows; END",
        "view": "DROP TABLE rows; CREATE VIEW rows AS SELECT 0 number, load_extension('/tmp/x') content",
        "table": "CREATE TABLE more (x)",
        "virtual": "CREATE VIRTUAL TABLE v USING fts4(x)",
    }
    good, commands = written_run(place.out), []
    for name, statement in hostile.items():
        file = place.given / f"{name}.journal"
        shutil.copy(good, file)
        with sqlite3.connect(file) as database:
            database.executescript(statement)
        database.close()
        commands += [
            ["replay", str(file)],
            ["draw", str(place.given / "lamp.json"), "-o", str(place.out / "p.html"), "--journal", str(file)],
        ]
    linked = place.given / "linked.journal"
    shutil.copy(good, linked)
    (place.given / "linked.journal-wal").symlink_to(place.outside / "secret.json")
    done = place.watch(*commands, ["replay", str(linked)])
    place.assert_harmless(done)
    assert done.ended == [*[2] * len(commands), 0]


def test_a_mission_s_schemas_are_never_fetched(place: Place) -> None:
    written = LAMP.written() | {"$schema": "http://127.0.0.1:9/mission.schema.json"}
    for way in ("http://127.0.0.1:9/", f"file://{place.outside}/secret.json"):
        parameters = {"type": "object", "properties": {"a": {"$ref": way}}}
        written["states"]["asking"]["decision"]["options"]["stay"] = {"parameters": parameters}
        mission = place.put("fetching.json", written)
        place.assert_harmless(place.watch(*reviews(place, mission)))


def test_a_journal_s_mission_is_bounded_as_its_file_is(place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    states: dict[str, Any] = {"s0": {"final": "aborted"}}
    for number in range(200):
        states = {f"s{number + 1}": {"initial": f"s{number}", "states": states}}
    mission = {"format": 1, "name": "deep", "initial": "s200", "states": states}
    file = place.given / "deep.journal"
    Journal.create(file, Header(json.dumps(mission))).close()
    for command in ("replay", "watch"):
        assert main([command, str(file)]) == 2
        assert "more than 100 objects and lists inside each other" in capsys.readouterr().err


@pytest.mark.parametrize("host", ["192.0.2.1", "evil.example", "[2001:db8::1]", "", "127.0.0.1.evil.example"])
def test_a_page_that_a_file_next_to_a_journal_names_elsewhere_is_not_asked(
    place: Place, monkeypatch: pytest.MonkeyPatch, host: str
) -> None:
    journal = written_run(place.given)
    neighbours = Path(f"{journal}.watch")
    neighbours.write_text(json.dumps({"url": f"http://{host}:8765/#token=x", "pid": os.getpid()}))
    neighbours.chmod(0o600)
    asked: list[Any] = []
    monkeypatch.setattr(socket, "create_connection", lambda *given, **_: asked.append(given))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *given, **_: asked.append(given))
    assert running_page(journal) is None and asked == []


@pytest.mark.parametrize("name", ["mission.json", "robot.json", "run.journal", "run.mcap", "mission.py"])
@pytest.mark.parametrize("kind", ["pipe", "zeros", "folder", "circle"])
def test_what_is_no_file_is_refused_at_once(place: Place, name: str, kind: str) -> None:
    file = place.given / name
    if kind == "pipe":
        os.mkfifo(file)
    elif kind == "zeros":
        file.symlink_to("/dev/zero")
    elif kind == "circle":
        file.symlink_to(file)
    else:
        file.mkdir()
    lamp = str(place.given / "lamp.json")
    words = {
        "mission.json": ["check", str(file)],
        "mission.py": ["check", str(file)],
        "robot.json": ["check", lamp, "--robot", str(file)],
    }
    assert main(words.get(name, ["replay", str(file)])) == 2


def test_every_command_that_takes_a_mission_can_refuse_python(place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    evil = place.given / "evil.py"
    evil.write_text(f"open({str(place.out / 'ran')!r}, 'w')")
    journal, lamp = str(written_run(place.given)), str(place.given / "lamp.json")
    words = {
        "run": ["run", str(evil), "--no-operator"], "check": ["check", str(evil)],
        "draw": ["draw", str(evil), "-o", str(place.out / "p.dot")], "diff": ["diff", str(evil), lamp],
        "prove": ["prove", str(evil)], "replay": ["replay", journal, "--mission", str(evil)],
        "try": ["try", str(evil), "--terminal"], "doctor": ["doctor", "--mission", str(evil)],
    }  # fmt: skip
    assert {name for name, dests in taken().items() if dests & {"mission", "old"}} == set(words)
    for command in (*words.values(), ["diff", lamp, str(evil)], ["run", "--resume", journal, str(evil)]):
        assert main([*command, "--no-python"]) == 2, command
        assert "is Python, which is not to be executed here" in capsys.readouterr().err
    guarded = ("run", "check", "prove", "try")
    for command in guarded:
        assert main([command, lamp, "--guards", str(evil), "--no-python"]) == 2
        assert "is Python, which --no-python refuses" in capsys.readouterr().err
    assert {name for name, dests in taken().items() if "guards" in dests} == {*guarded}
    assert main(["run", lamp, "--no-python", "--managed", "--guards", str(evil)]) == 2
    capsys.readouterr()
    for words_of in (["run", lamp], ["run", lamp, "--managed"], ["run", lamp, "--node"], ["run", "--resume", journal]):
        assert main([*words_of, "--robot", str(evil), "--no-python"]) == 2
        assert "is Python, which --no-python refuses" in capsys.readouterr().err
    for words_of, ended in ((["check", lamp], 0), (["prove", lamp], 2)):
        assert main([*words_of, "--robot", str(evil)]) == ended
        assert "execute" in capsys.readouterr().err
    assert not (place.out / "ran").exists()


def taken() -> dict[str, set[str]]:
    """Command → what it takes."""
    found = {name: {each.name for each in load_command(name).parameters()} for name in names()}
    assert all("no_python" in dests for dests in found.values() if dests & {"mission", "old"})
    return found


def test_nothing_is_left_in_the_folder_for_temporary_files(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(place.out))
    written_run(place.given, record=True)
    assert main(["replay", str(place.given / "run.mcap")]) == 0
    assert list(place.out.iterdir()) == []

# SPDX-License-Identifier: Apache-2.0
"""The command line as a user meets it: what is printed where, and with which exit status."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.commands.run import run
from rai_missions.cli.inputs import read_pairs
from rai_missions.cli.main import main
from rai_missions.errors import UsageError
from rai_missions.mission.files import load
from tests.rigs.lamp import LAMP, lamp_folder
from tests.ros2 import on_ros


@pytest.mark.parametrize(
    ("pairs", "why"),
    [
        (["speed"], "--set speed: write KEY=VALUE"),
        (["=3"], "--set =3: write KEY=VALUE"),
        (["speed=1", "place=a", "speed=2"], "--set speed is given twice; give one value"),
    ],
)
def test_a_pair_of_which_no_one_value_of_a_key_follows_is_refused(pairs: list[str], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        read_pairs("--set", pairs)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return lamp_folder(tmp_path, monkeypatch)


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    assert all(word in printed for word in ("run", "check", "draw", "diff", "replay", "schema", "new", "doctor"))


def test_a_run_that_does_not_succeed_exits_with_1_and_reports_why(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "lamp.json", "--journal", "a.journal"]) == 1
    printed = capsys.readouterr().out
    assert "aborted: 'off' was reached" in printed
    assert "model" not in printed and "questions" not in printed.partition("aborted:")[0]
    assert "journal: a.journal" in printed


def test_a_run_in_json_prints_one_object_and_nothing_else(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "lamp.json", "--journal", "a.journal", "--json"])
    reported = json.loads(capsys.readouterr().out)
    assert {**reported, "run": "", "duration_s": 0} == {
        "mission": "lamp",
        "run": "",
        "outcome": "aborted",
        "why": "'off' was reached",
        "state": "off",
        "steps": 2,
        "decisions": 0,
        "duration_s": 0,
        "journal": "a.journal",
        "moved_aside": None,
        "open_goals": [],
    }


def test_a_journal_is_never_written_over(folder: Path) -> None:
    main(["run", "lamp.json", "--journal", "a.journal"])
    main(["run", "lamp.json", "--journal", "a.journal"])
    assert main(["replay", "a.journal"]) == main(["replay", "a.1.journal"]) == 0


def test_a_file_that_is_no_journal_is_left_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.journal").write_text("my notes")
    assert main(["run", "lamp.json", "--journal", "a.journal"]) == 2
    assert (folder / "a.journal").read_text() == "my notes"
    assert "a.journal" in capsys.readouterr().err


def test_runs_that_begin_in_one_second_have_a_journal_each(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "strftime", lambda _: "20260101-090000")
    for process in (11, 12):
        monkeypatch.setattr(os, "getpid", partial(int, process))
        assert main(["run", "lamp.json"]) == 1
    assert len([*folder.glob("journals/*.journal")]) == 2
    assert not [*folder.glob("journals/*.1.journal")]


def test_a_mission_with_a_long_name_is_run_and_its_journal_has_the_start_of_the_name(folder: Path) -> None:
    (folder / "long.json").write_text(json.dumps({**LAMP, "name": "l" * 300}))
    assert main(["run", "long.json"]) == 1
    (journal,) = folder.glob("journals/*.journal")
    assert journal.name.startswith("l" * 100 + "-")


def test_every_fault_is_reported_on_stderr_with_its_place(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = {**LAMP, "states": {**LAMP["states"], "x": {"transitions": [{"on": "go", "to": "of"}]}}}
    (folder / "bad.json").write_text(json.dumps(bad))
    for command in (["check", "bad.json"], ["run", "bad.json"]):
        assert main(command) == 2
        printed = capsys.readouterr().err
        assert "bad.json: /states/x/transitions/0/on: no event or outcome 'go'" in printed
        assert "/states/x/transitions/0/to: no state 'of'; did you mean 'off'?" in printed
    assert not list(folder.glob("journals/*"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"{", "line 1"),
        (b"\xff\xfe", "UTF-8"),
        (b"[]", "object"),
        (b'{"name": "x", "name": "y"}', "name"),
        (b"[" * 100_000, "nest"),
    ],
)
@pytest.mark.parametrize("command", ["check", "run", "draw"])
def test_a_file_that_is_no_mission_is_refused_and_not_changed(
    folder: Path, capsys: pytest.CaptureFixture[str], command: str, content: bytes, message: str
) -> None:
    (folder / "m.json").write_bytes(content)
    assert main([command, "m.json"]) == 2
    assert message in capsys.readouterr().err
    assert (folder / "m.json").read_bytes() == content
    assert sorted(path.name for path in folder.iterdir()) == ["lamp.json", "m.json"]


def test_a_profile_that_lacks_a_name_is_refused_before_the_start(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "mine"]) == 0
    profile = json.loads((folder / "mine/robot.ros.json").read_text())
    del profile["actions"]
    (folder / "mine/robot.ros.json").write_text(json.dumps(profile))
    capsys.readouterr()
    assert main(["run", "mine/mission.json", "--robot", "mine/robot.ros.json"]) == 2
    assert "/actions/drive: missing" in capsys.readouterr().err


def test_an_argument_that_the_mission_does_not_take_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "lamp.json", "--set", "speed=3"]) == 2
    assert not list(folder.glob("journals/*"))
    assert "takes no argument 'speed'" in capsys.readouterr().err


def test_a_mission_that_must_receive_a_robot_is_not_begun_without_one(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["new", "mine"])
    assert main(["run", "mine/mission.json"]) == 2
    assert "must receive position_m, delivered, battery from a robot; give its profile" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["--managed"]])
def test_a_profile_without_a_world_is_refused_before_its_facts_are_waited_for(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    main(["new", "mine"])
    profile = json.loads(Path("mine/robot.ros.json").read_text())
    Path("mine/robot.json").write_text(json.dumps({**profile, "connector": {"kind": "local"}}))
    assert main(["run", "mine/mission.json", "--robot", "mine/robot.json", *words]) == 2
    error = capsys.readouterr().err
    assert "mine/robot.json" in error
    assert "/connector: names no world, so the key 'position_m' has no other side" in error
    assert not list(folder.glob("journals/*"))


def test_python_is_executed_only_where_it_may_be(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "m.py").write_text("raise SystemExit('executed')")
    assert main(["check", "m.py", "--no-python"]) == 2
    assert "executed" not in capsys.readouterr().err.replace("to be executed", "")


def ran_and_altered(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run the lamp, and write something else into a row of its journal."""
    main(["run", "lamp.json", "--journal", journal.name])
    with closing(sqlite3.connect(journal)) as connection:
        connection.execute("UPDATE rows SET content = replace(content, 'off', 'oof') WHERE number = 2")
        connection.commit()
    capsys.readouterr()


def test_a_journal_that_was_altered_is_not_replayed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ran_and_altered(folder / "a.journal", capsys)
    assert main(["replay", "a.journal"]) == 2
    assert "row 2" in capsys.readouterr().err


def test_the_steps_of_a_replay_are_in_its_object(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "lamp.json", "--journal", "a.journal"])
    capsys.readouterr()
    assert main(["replay", "a.journal", "--json"]) == 0
    plain = json.loads(capsys.readouterr().out)
    assert main(["replay", "a.journal", "--json", "--verbose"]) == 0
    found = json.loads(capsys.readouterr().out)
    trace = found.pop("trace")
    assert (found, len(trace) > 1) == (plain, True)
    assert trace[0]["event"]["name"] == "start" and trace[-1]["outcome"] == found["outcome"]


def test_every_run_of_a_folder_gets_a_verdict(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "runs/older").mkdir(parents=True)
    main(["run", "lamp.json", "--journal", "runs/a.journal"])
    ran_and_altered(folder / "z.journal", capsys)
    (folder / "z.journal").rename(folder / "runs/older/z.journal")
    (folder / "runs/notes.txt").write_text("no run")
    assert main(["replay", "runs"]) == 1
    first, second, last = capsys.readouterr().out.splitlines()
    assert first.startswith("a.journal: ") and "all the same" in first
    assert second.startswith("older/z.journal: cannot be read: ") and "row 2" in second
    assert last == "1 of 2 runs are the same"
    assert main(["replay", "runs", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [(each["run"], each["holds"]) for each in found["runs"]] == [("a.journal", True), ("older/z.journal", False)]


def test_a_folder_without_a_run_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "empty").mkdir()
    assert main(["replay", "empty"]) == 2
    assert "no run in 'empty'" in capsys.readouterr().err


def test_a_picture_of_an_altered_journal_is_refused_and_the_page_is_named_that_shows_it(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ran_and_altered(folder / "a.journal", capsys)
    assert main(["draw", "lamp.json", "--journal", "a.journal", "-o", "x.dot"]) == 2
    reported = capsys.readouterr().err
    assert "row 2" in reported and "a page (-o review.html) shows what can be read of it" in reported
    assert not (folder / "x.dot").exists()
    assert main(["draw", "lamp.json", "--journal", "a.journal", "-o", "x.html"]) == 0
    assert "a.journal: drawn with this error: row 2" in capsys.readouterr().err


def test_a_diagram_that_mermaid_will_not_draw_is_notified_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    states: dict[str, Any] = {f"s{n}": {"transitions": [{"after_s": 1, "to": f"s{n + 1}"}]} for n in range(900)}
    for version in ("1.0.0", "1.0.1"):
        big = {**LAMP, "version": version, "initial": "s0", "states": states | {"s900": {"final": "aborted"}}}
        (folder / f"{version}.json").write_text(json.dumps(big))
    main(["draw", "lamp.json", "-o", "small.mmd"])
    assert capsys.readouterr().err == ""
    for words in (["draw", "1.0.0.json"], ["diff", "--fail-on", "none", "1.0.0.json", "1.0.1.json"]):
        assert main([*words, "-o", "big.mmd", *(["-o", "big.dot"] if words[0] == "diff" else [])]) == 0
        (reported,) = capsys.readouterr().err.splitlines()
        assert reported.startswith("big.mmd: ") and "Mermaid draws 50000 unless `maxTextSize` is raised" in reported
        assert ".svg and .html have no such limit" in reported


def test_the_picture_of_another_mission_s_journal_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "lamp.json", "--journal", "a.journal"])
    (folder / "other.json").write_text(json.dumps({**LAMP, "version": "9.9.9"}))
    assert main(["draw", "other.json", "--journal", "a.journal", "-o", "x.svg"]) == 2
    assert "another mission" in capsys.readouterr().err
    assert main(["draw", "lamp.json", "--journal", "a.journal", "-o", "x.svg"]) == 0


def test_guards_of_a_file_can_be_named_and_are_replayed_without_it(folder: Path) -> None:
    named = {"on": "tick", "when": {"named": "is_late", "with": {"than": 3}}, "to": "off"}
    states = {"on": {"entry": [{"raise": "tick"}], "transitions": [named]}, "off": {"final": "aborted"}}
    (folder / "m.json").write_text(json.dumps({"name": "m", "events": {"tick": {}}, "initial": "on", "states": states}))
    (folder / "guards.py").write_text("def is_late(board, than):\n    return than == 3\n")
    assert main(["run", "m.json", "--guards", "guards.py", "--journal", "a.journal"]) == 1
    assert main(["replay", "a.journal"]) == 0


LIVING = """
import gc


def is_late(board):
    gc.callbacks.append(lambda *_: print("searched", len(gc.get_objects()), "and left", gc.get_freeze_count()))
    gc.collect()
    del gc.callbacks[:]
    return True
"""


def test_no_search_of_a_run_visits_what_was_loaded_for_it(folder: Path) -> None:
    """A search of all that is alive takes 75 ms where ROS is loaded; so long, a stop waited for its turn."""
    states = {"on": {"transitions": [{"when": {"named": "is_late"}, "to": "off"}]}, "off": {"final": "aborted"}}
    (folder / "m.json").write_text(json.dumps({"name": "m", "initial": "on", "states": states}))
    (folder / "guards.py").write_text(LIVING)
    run = ["run", "m.json", "--guards", "guards.py"]
    program = f"import gc; from rai_missions.cli.main import main; main({run}); print('frozen', gc.get_freeze_count())"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    searched, left = next(line.split()[1::3] for line in ran.stdout.splitlines() if line.startswith("searched"))
    assert int(searched) < int(left) / 10
    assert ran.stdout.splitlines()[-1] == "frozen 0"


def test_a_run_resumes_with_the_files_in_python_that_it_began_with(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    named = {"when": {"named": "is_late", "with": {"than": 3}}, "to": "off"}
    states = {"on": {"transitions": [named]}, "off": {"final": "aborted"}}
    (folder / "m.json").write_text(json.dumps({"name": "m", "initial": "on", "states": states}))
    (folder / "guards.py").write_text("def is_late(board, than):\n    return than == 3\n")
    (folder / "counting.py").write_text(COUNTING)
    began = {"guards": ["m.json", "--guards", "guards.py"], "mission": ["counting.py"]}
    for name, words in began.items():
        assert main(["run", *words, "--journal", f"{name}.journal"]) == 1
        resume, changed = ["run", "--resume", f"{name}.journal", *words], f"the file of the {name} has changed since"
        capsys.readouterr()
        assert main(resume) == 2
        assert "has ended, aborted" in capsys.readouterr().err, "the files are those with which it began"
        with open(words[-1], "a") as file:
            file.write("# another\n")
        assert main(resume) == 2
        assert changed in capsys.readouterr().err
    (folder / "lamp.py").write_text(LAMP_IN_PYTHON)
    assert main(["run", "lamp.py", "--journal", "lamp.journal"]) == 1
    with open("lamp.py", "a") as file:
        file.write("# the same mission\n")
    assert main(["run", "--resume", "lamp.journal", "lamp.py"]) == 2
    assert "has ended, aborted" in capsys.readouterr().err


LAMP_IN_PYTHON = """
from rai_missions import After, Mission
from rai_missions.states import Final, State


def mission():
    states = {"on": State(transitions=[After(0.01, to="off")]), "off": Final("aborted")}
    return Mission("lamp", initial="on", states=states)
"""
COUNTING = """
import py_trees

from rai_missions import Mission, On
from rai_missions.states import Final, Tree


def count():
    return py_trees.behaviours.TickCounter("count", 3, py_trees.common.Status.SUCCESS)


def mission():
    tree = Tree(count, tick_s=0.01, transitions=[On("succeeded", to="off")])
    return Mission("counting", initial="on", states={"on": tree, "off": Final("aborted")})
"""


def test_a_mission_with_a_behaviour_in_python_is_run_and_replayed_from_its_file(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "m.py").write_text(COUNTING)
    assert main(["run", "m.py", "--journal", "a.journal"]) == 1
    assert main(["replay", "a.journal"]) == 2
    assert "--mission FILE.py" in capsys.readouterr().err
    assert main(["replay", "a.journal", "--mission", "m.py"]) == 0


def test_a_differing_mission_exits_with_1_and_an_equal_one_with_0(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "again.json").write_text(json.dumps(dict(reversed(LAMP.items())), indent=8))
    assert main(["diff", "lamp.json", "again.json"]) == 0
    (folder / "new.json").write_text(json.dumps({**LAMP, "settle_s": 2.0}))
    capsys.readouterr()
    assert main(["diff", "lamp.json", "new.json", "-o", "d.svg"]) == 1
    assert "settle_s" in capsys.readouterr().out and (folder / "d.svg").exists()


def test_schemas_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    for of in ("mission", "robot"):
        assert main(["schema", of]) == 0
        assert json.loads(capsys.readouterr().out)["$schema"].startswith("https://json-schema.org/")


@pytest.mark.parametrize("template", ["rosbot", "tractor"])
def test_a_copied_example_passes_its_check(folder: Path, template: str) -> None:
    assert main(["new", "mine", "--template", template]) == 0
    assert main(["check", "mine/mission.json"]) == 0
    assert main(["new", "mine"]) == 2


def test_a_reader_that_disappears_is_no_traceback(folder: Path) -> None:
    program = [sys.executable, "-m", "rai_missions", "schema"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ}) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert b"Traceback" not in process.stderr.read()


def test_a_file_of_guards_that_exits_is_no_run_that_succeeded(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "guards.py").write_text("raise SystemExit(0)\n")
    assert main(["run", "lamp.json", "--guards", "guards.py"]) == 2
    assert "guards.py: /: SystemExit: 0" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_reported_in_a_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "lamp.json/mine"]) == 2
    assert "rai-missions new: 'lamp.json/mine' cannot be made" in capsys.readouterr().err


def test_a_file_that_cannot_be_written_is_reported_in_a_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "lamp.json", "--journal", "a.journal", "--picture", "lamp.json/x.svg"]) == 1
    assert "the run was not drawn: " in capsys.readouterr().err


def test_a_picture_that_this_machine_cannot_draw_is_refused_before_the_run(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr(sys, "executable", str(folder / "python"))
    assert main(["run", "lamp.json", "--journal", "a.journal", "--picture", "x.svg"]) == 2
    assert "neither `dot` nor `graphviz-pure` is here" in capsys.readouterr().err
    assert not Path("a.journal").exists()


def test_a_journal_without_a_step_proves_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from rai_missions.journal import Header, Journal
    from rai_missions.mission.files import dump

    Journal.create(folder / "empty.journal", Header(mission=dump(load("lamp.json")))).close()
    assert main(["replay", "empty.journal"]) == 1
    assert "empty.journal holds no step of a run: there is nothing to compare" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("connector", "message"),
    [
        ({"kind": "local"}, "--speed and --seed have no effect: the run simulates no world, its robot is reached by"),
        ({"kind": "local", "world": "orchard", "camera": False}, ""),
    ],
)
def test_words_of_a_simulated_world_warn_where_there_is_none(
    folder: Path, capsys: pytest.CaptureFixture[str], connector: dict[str, object], message: str
) -> None:
    if "world" in connector:
        pytest.importorskip("mujoco")
    (folder / "r.json").write_text(json.dumps({"format": 1, "name": "r", "connector": connector}))
    given = ["run", "lamp.json", "--robot", "r.json", "--no-operator", "--journal", "a.journal"]
    assert main([*given, "--speed", "max", "--seed", "3"]) == 1
    err = capsys.readouterr().err
    assert message in err and (message or "no effect" not in err)
    main(given)
    assert "no effect" not in capsys.readouterr().err, "an option that was not given causes no warning"


@pytest.mark.parametrize("speed", ["0", "-1", "nan", "inf", "fast", ""])
def test_a_speed_is_a_positive_number_or_max(folder: Path, capsys: pytest.CaptureFixture[str], speed: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["run", "lamp.json", f"--speed={speed}"])
    assert ended.value.code == 2
    assert f"'{speed}' is no speed; give a positive number such as 5, or max" in capsys.readouterr().err


@pytest.mark.parametrize(("speed", "means"), [("5", 5.0), ("0.5", 0.5), ("1", 1.0), ("max", float("inf"))])
def test_a_simulated_world_has_the_speed_that_was_given(speed: str, means: float) -> None:
    options = run.read(["lamp.json", "--speed", speed])["options"]
    assert options.speed == means


def test_check_reports_what_it_checked_and_each_fault_in_its_own_file(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "mine"]) == 0
    given = ["check", "mine/mission.json", "--robot", "mine/robot.ros.json"]
    capsys.readouterr()
    assert main(given) == 0
    printed = capsys.readouterr()
    assert "mine/mission.json: mission and profile: " in printed.out + printed.err
    profile = json.loads((folder / "mine/robot.ros.json").read_text())
    del profile["actions"]
    (folder / "mine/robot.ros.json").write_text(json.dumps(profile))
    assert main(given) == 2
    assert "mine/robot.ros.json: /actions/drive: missing" in capsys.readouterr().err
    (folder / "mine/robot.ros.json").write_text(json.dumps({**profile, "name": 5}))
    (folder / "mine/mission.json").write_text(json.dumps({**LAMP, "ready_s": "soon"}))
    assert main([*given, "--json"]) == 2
    rows = json.loads(capsys.readouterr().out)
    assert {("mine/mission.json", "/ready_s"), ("mine/robot.ros.json", "/name")} <= {
        (r["file"], r["place"]) for r in rows
    }


@pytest.mark.parametrize(
    ("connector", "sentence"),
    [
        ({"kind": "ros"}, "/connector/kind: no connector of kind 'ros'; did you mean 'ros2'?"),
        ({"kind": "local", "world": "orchad"}, "/connector: there is no world 'orchad'; did you mean 'orchard'?"),
        ({"kind": "local", "wrold": "orchard"}, "/connector: connector: no option 'wrold'; did you mean 'world'?"),
        ({"kind": "local", "world": "orchard", "aleys": 2}, "/connector: the world 'orchard' has no option 'aleys'"),
        ({"kind": "local", "world": "orchard", "seed": "x"}, "/connector: the world 'orchard' cannot be opened with"),
        ({"kind": "local", "world": "orchard", "detector": {"mis": 1}}, "/connector: detector: no option 'mis'"),
        ({"kind": "local", "world": "house", "blocked": 2}, "/connector: the world 'house' cannot be opened with blo"),
        ({"kind": "local", "world": "orchard", "seed": 7}, ""),
        ({"kind": "local", "world": "orchard"}, ""),
        ({"kind": "mqtt"}, "/actions/drive: MQTT carries no actions, and so not /drive; compose it of services"),
        ({"kind": "mqtt", "prot": 1883}, "no option 'prot'; there is: host, port"),
        ({"kind": "mqtt", "port": "1883"}, "connector/port: '1883' is no port; give a whole number from 1 to 65535"),
        ({"kind": "mqtt", "port": None}, "connector/port: null is no port"),
        ({"kind": "mqtt", "port": 70_000}, "connector/port: 70000 is no port"),
        ({"kind": "mqtt", "host": 5}, "connector/host: 5 is no host; give a name or an address"),
        ({"kind": "ros2", "noed": "beacon"}, "no option 'noed'; did you mean 'node'?"),
        ({"kind": "ros2", "parameters": {"a": {"b": 1}}}, 'connector/parameters/a: {"b": 1} is no parameter of ROS'),
        ({"kind": "ros2", "parameters": {"a": [1, 2.5]}}, "connector/parameters/a: [1, 2.5] is no parameter of ROS"),
        ({"kind": "ros2", "parameters": {"use_sim_time": True}}, 'it, too; give "sim_time" next to "kind"'),
        ({"kind": "ros2", "parameters": {"a": ["x"], "b": 1.5, "c": False}}, ""),
        ({"kind": "ros2", "domain_id": 300}, "connector/domain_id: 300 is no ROS domain; one goes from 0 to 232"),
    ],
)
def test_check_reports_a_connector_a_world_or_an_option_that_there_is_not(
    connector: dict[str, Any], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "mine"]) == 0
    path = folder / "mine/robot.ros.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"connector": connector}))
    assert main(["check", "mine/mission.json", "--robot", str(path)]) == (2 if sentence else 0)
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "battery", "alive", "faults"),
    [
        pytest.param(
            "ros2", "/Fahrwerk/Füllstand", "alive/",
            {
                "/blackboard/battery": "no name in ROS from 'üllstand' on: topic name must not contain characters",
                "/services/horn": "no name in ROS from '/' on: topic name must not end with a forward slash",
                "/control/operator": "no name in ROS from '2nd/agent' on: topic name token must not start with",
                "/alive": "no name in ROS from '/' on: topic name must not end with a forward slash",
            },
            marks=on_ros,
        ),
        (
            "mqtt", "/+/battery", "#/",
            {
                "/blackboard/battery": "'/+/battery' is no name in MQTT: '+' and '#' mean many topics",
                "/actions/drive": "MQTT carries no actions, and so not /drive; compose it of services",
                "/alive": "'#/' is no name in MQTT: '+' and '#' mean many topics",
            },
        ),
    ],
)  # fmt: skip
def test_check_and_run_report_all_names_that_the_middleware_does_not_take(
    kind: str, battery: str, alive: str, faults: dict[str, str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = {
        "format": 1, "name": "robot", "connector": {"kind": kind},
        "blackboard": {"battery": {"topic": battery, "type": "std_msgs/msg/Float64"}},
        "actions": {"drive": {"action": "/drive", "type": "test_msgs/action/Fibonacci"}},
        "services": {"horn": {"service": "horn/"}},
        "control": {"operator": "/2nd/{by}"}, "alive": {"topic": alive},
    }  # fmt: skip
    mission = {**LAMP, "blackboard": {"battery": {"type": "number", "source": "robot"}}, "events": {}}
    for name, content in (("robot.json", profile), ("lamp.json", mission)):
        (folder / name).write_text(json.dumps(content))
    for command in ("check", "run"):
        assert main([command, "lamp.json", "--robot", "robot.json"]) == 2
        printed = [line for line in capsys.readouterr().err.splitlines() if line.startswith("robot.json: /")]
        found = dict(line.removeprefix("robot.json: ").split(": ", 1) for line in printed)
        assert found.keys() == faults.keys()
        assert all(faults[place] in found[place] for place in faults), found
    assert not list(folder.rglob("*.journal"))

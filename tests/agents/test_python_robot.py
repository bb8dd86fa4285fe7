# SPDX-License-Identifier: Apache-2.0
"""A robot in Python runs missions as any other: its time, its journal, its end, and how another process continues."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from rai_missions import DefinitionError, Mission, PythonRobot, UsageError
from rai_missions.agents import run
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.connectors.python_robot import connector as connector_module
from rai_missions.connectors.python_robot import robot_time
from rai_missions.engine.step import Step
from rai_missions.journal import Note, read
from rai_missions.replay.replay import replay

X = {"type": "number", "source": "robot", "max_age_s": 3}


def mission(states: dict[str, Any], **words: Any) -> Mission:
    """A mission that begins in the first of its states; `done` and, where something leads there, `lost` end it."""
    finals: dict[str, Any] = {"done": {"final": "succeeded", "requires": {"key": "x", ">=": 0}}}
    if '"lost"' in json.dumps([states, words]):
        finals["lost"] = {"final": "aborted"}
    made = {"format": 1, "name": "trip", "version": "1", "initial": next(iter(states)), "blackboard": {"x": X}}
    return Mission.model_validate(made | {"states": states | finals} | words)


def doing(action: str, *transitions: dict[str, Any], **words: Any) -> dict[str, Any]:
    return {"action": action, "timeout_s": 60, "transitions": [*transitions, {"on": "succeeded", "to": "done"}]} | words


@pytest.fixture
def robot() -> PythonRobot:
    """A robot that drives two metres in four seconds, and knows where it is."""
    made, place = PythonRobot("turtle"), {"x": 0.0}
    made.fact("x", every_s=0.5)(lambda: place["x"])

    @made.action("drive", uses=["base"])
    def drive(goal: Any, run: Any) -> Any:
        while place["x"] < 2:
            if run.canceled:
                return run.cancel()
            place["x"] += 0.5
            run.sleep(1)
        return {"x": place["x"]}

    return made


DRIVING = mission({"driving": doing("drive", achieved={"key": "x", ">=": 2})}, blackboard={"x": X})


# -- time --------------------------------------------------------------------------------------------------------------


def test_a_mission_runs_on_functions_in_no_time_and_its_journal_is_replayed(robot: PythonRobot, tmp_path: Path) -> None:
    steps: list[Step] = []
    result = run(DRIVING, robot, speed=math.inf, journal=tmp_path / "run.journal", on_step=steps.append)
    assert (result.outcome, result.open_goals) == ("succeeded", ())
    assert result.duration_s == pytest.approx(4.0)
    again = replay(tmp_path / "run.journal")
    assert again.holds
    with read(tmp_path / "run.journal") as record:
        assert json.loads(record.header.profile)["connector"] == {"kind": "python"}


def test_without_a_speed_it_has_the_time_of_the_wall(robot: PythonRobot) -> None:
    before = time.monotonic()
    result = run(mission({"driving": doing("drive", {"after_s": 0.2, "to": "lost"})}), robot)
    assert result.outcome == "aborted" and time.monotonic() - before >= 0.2


def test_time_stops_while_a_function_executes(robot: PythonRobot) -> None:
    robot.action("think")(lambda goal, run: time.sleep(0.3))  # not on the run's clock
    result = run(mission({"thinking": doing("think", timeout_s=0.2)}), robot, speed=math.inf)
    assert (result.outcome, result.duration_s) == ("succeeded", 0.0)


def test_a_function_that_does_not_wait_is_named_and_its_time_out_comes_all_the_same(
    robot: PythonRobot, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(robot_time, "PATIENCE_S", 0.1)
    hangs = threading.Event()
    robot.action("think")(lambda goal, run: hangs.wait(30))
    states = {"thinking": doing("think", {"on": "timed_out", "to": "lost"}, timeout_s=0.2, cancel_s=0.1)}
    entered: dict[str, float] = {}

    def on_step(step: Step) -> None:
        entered.update(dict.fromkeys(step.entered, time.monotonic()))

    began = time.monotonic()
    result = run(mission(states), robot, speed=math.inf, on_step=on_step)
    hangs.set()
    assert entered["lost"] - began >= 0.1 + 0.2, "from then on time passes as on the wall"
    assert result.outcome == "aborted"
    assert [each.reason for each in result.open_goals] == ["orphaned"]
    named = [each.getMessage() for each in caplog.records if "without waiting in run.sleep" in each.getMessage()]
    of_it = [each for each in named if each.startswith("action 'think' has executed for 0.1 s")]
    assert len(of_it) == 1, "once; on a busy machine a fact may take as long"


def test_a_fact_that_hangs_goes_stale(robot: PythonRobot) -> None:
    hangs, reads = threading.Event(), []

    @robot.fact("battery", every_s=0.01)
    def battery() -> float:
        reads.append(1)
        if len(reads) > 1:
            hangs.wait(30)
        return 0.9

    keys = {"x": X, "battery": {"type": "number", "source": "robot", "max_age_s": 0.1}}
    stale = {"when": {"not": {"fresh": "battery"}}, "to": "lost"}
    result = run(mission({"driving": doing("drive")}, blackboard=keys, transitions=[stale]), robot)
    hangs.set()
    assert result.outcome == "aborted" and result.duration_s < 5


def test_a_value_is_held_to_the_type_of_its_key(robot: PythonRobot) -> None:
    robot.fact("battery")(lambda: "full")
    keys = {"x": X, "battery": {"type": "number", "source": "robot"}}
    with pytest.raises(UsageError, match="battery was received and not understood: 'full' is not of type 'number'"):
        run(mission({"driving": doing("drive")}, blackboard=keys, ready_s=0.2), robot)


@pytest.mark.parametrize(("every_s", "is_slow"), [(2.9, False), (3.0, True), (7.0, True)])
def test_a_fact_that_is_read_more_seldom_than_it_goes_stale_is_named(
    robot: PythonRobot, caplog: pytest.LogCaptureFixture, every_s: float, is_slow: bool
) -> None:
    del robot.fact_functions["x"]
    robot.fact("x", every_s=every_s)(lambda: 2.0)
    assert run(DRIVING, robot, speed=math.inf).outcome == "succeeded"
    sentence = f"fact 'x' is read every {every_s:g} s, and is stale after 3 s: in between it is unknown; read it more"
    assert any(each.getMessage().startswith(sentence) for each in caplog.records) is is_slow


def test_an_event_before_the_start_is_dropped_and_noted_and_one_after_it_is_taken(
    robot: PythonRobot, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    reads: list[int] = []

    @robot.fact("ready", every_s=0.1)
    def ready() -> bool | None:
        reads.append(1)
        if len(reads) != 2:  # by the first reading no one listens yet
            return len(reads) > 2 or None
        robot.raise_event("branch")
        return None

    @robot.action("look")
    def look(goal: Any, run: Any) -> None:
        robot.raise_event("branch", {"height_m": 0.5})
        run.sleep(100)

    key = {"type": "boolean", "source": "robot"}
    there = {"on": "branch", "when": {"key": "event.height_m", ">": 0.4}, "to": "done"}
    made = mission(
        {"looking": doing("look", there)},
        blackboard={"x": X, "ready": key},
        events={"branch": {"fields": {"height_m": "number"}}},
    )
    result = run(made, robot, speed=math.inf, journal=tmp_path / "run.journal")
    assert result.outcome == "succeeded" and result.duration_s < 1
    sentence = "the event 'branch' is dropped: it came before the start"
    assert [each.getMessage() for each in caplog.records if each.levelname == "WARNING"] == [sentence]
    with read(tmp_path / "run.journal") as record:
        assert sentence in [each.text for each in record.rows() if isinstance(each, Note)]


# -- the end -----------------------------------------------------------------------------------------------------------


def spinning(robot: PythonRobot) -> threading.Event:
    """An action that ends by nothing but this event."""
    over = threading.Event()

    @robot.action("spin")
    def spin(goal: Any, run: Any) -> None:
        while not over.is_set():
            run.sleep(0.5)

    return over


def test_an_action_that_ignores_its_cancel_is_orphaned_in_the_mission(robot: PythonRobot) -> None:
    over = spinning(robot)
    states = {
        "spinning": doing("spin", {"after_s": 1, "to": "waiting"}, cancel_s=2),
        "waiting": {"transitions": [{"on": "orphaned", "to": "done"}, {"after_s": 10, "to": "lost"}]},
    }
    steps: list[Step] = []
    made = mission(states)

    def on_step(step: Step) -> None:
        steps.append(step)
        if step.outcome is not None:
            over.set()

    result = run(made, robot, speed=math.inf, on_step=on_step)
    assert (result.outcome, result.duration_s) == ("succeeded", pytest.approx(3.0, abs=0.6))
    assert result.open_goals == (), "it has ended while the end of the run waited for it"


def test_an_orphan_of_a_process_that_was_killed_has_ended_with_it(robot: PythonRobot, tmp_path: Path) -> None:
    over = spinning(robot)
    states = {
        "spinning": doing("spin", {"after_s": 1, "to": "waiting"}, cancel_s=2),
        "waiting": {"transitions": [{"on": "orphaned", "to": "driving"}]},
        "driving": doing("drive", over_orphan=True),
    }
    made, path, killed = mission(states), tmp_path / "run.journal", tmp_path / "killed"
    killed.mkdir()

    def on_step(step: Step) -> None:
        if "driving" in step.entered:  # what is on the disk now is what a kill would leave
            for file in tmp_path.glob("run.journal*"):
                shutil.copy(file, killed)
        elif step.outcome is not None:
            over.set()

    assert run(made, robot, speed=math.inf, journal=path, on_step=on_step).outcome == "succeeded"
    with prepare(RunConfig(None, robot, resume=killed / path.name, speed=math.inf)) as again:
        assert [each.reason for each in again.runner.view.loose_goals] == ["orphaned"]
        assert again.runner.run().open_goals == ()
    with read(killed / path.name) as record:
        doubts = [step.event.data["name"] for step in record.steps() if step.event.kind == "doubt"]
    assert doubts == ["spin", "drive"]


@pytest.mark.parametrize("speed", [None, math.inf])
def test_at_the_end_it_is_waited_for_two_seconds_at_most_and_is_then_an_open_goal(
    speed: float | None, robot: PythonRobot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert connector_module.EXIT_S == 2.0
    monkeypatch.setattr(connector_module, "EXIT_S", 0.3)
    monkeypatch.setattr(robot_time, "PATIENCE_S", 0.1)
    over = threading.Event()
    robot.action("spin")(lambda goal, run: over.wait(30))
    before = time.monotonic()
    states = {"spinning": doing("spin", {"after_s": 0.1, "to": "done"}, cancel_s=60)}
    result = run(mission(states), robot, speed=speed, journal=tmp_path / "run.journal")
    waited_s = time.monotonic() - before
    over.set()
    assert (result.outcome, [each.reason for each in result.open_goals]) == ("succeeded", ["orphaned"])
    assert "the robot may still move: goal 1 of 'spin'" in result.warning
    assert 0.3 <= waited_s < 2.0
    assert replay(tmp_path / "run.journal").holds


# -- what a mission lacks ----------------------------------------------------------------------------------------------


def test_all_that_a_robot_lacks_is_named_before_anything_is_called(robot: PythonRobot) -> None:
    robot.fact("batery")(lambda: pytest.fail("nothing is read"))
    hooting = {"call": "horn", "transitions": [{"on": "succeeded", "to": "driving"}]}
    states = {"hooting": hooting, "driving": doing("drive")}
    keys = {"x": X, "battery": X, "pose": {"type": "pose", "source": "robot", "optional": True}}
    made = mission(states, blackboard=keys)
    with pytest.raises(DefinitionError) as caught:
        run(made, robot)
    assert [str(each) for each in caught.value.faults] == [
        '/blackboard/battery: missing; the mission uses it at /blackboard/battery; write `@robot.fact("battery")`, or '
        "`robot.fact(\"battery\")` where robot.write brings it; did you mean 'batery'?",
        '/services/horn: missing; the mission uses it at /states/hooting/call; write `@robot.service("horn")`',
    ]


def test_a_key_that_is_declared_or_was_written_is_no_lack(robot: PythonRobot) -> None:
    robot.fact("battery")
    robot.write("battery", 0.5)
    robot.write("load", 0.1)
    result = run(
        mission({"driving": doing("drive")}, blackboard={"x": X, "battery": X | {"max_age_s": 60}, "load": X}),
        robot,
        speed=math.inf,
    )
    assert result.outcome == "succeeded"


def test_rules_of_the_robot_answer() -> None:
    robot = PythonRobot("turtle", rules={"asking": [{"answer": "go"}]})
    robot.fact("x")(lambda: 0.0)
    options = {"go": {"about": "drive"}, "stop": {"about": "stop"}}
    asking = {"question": "What now?", "options": options, "ask": ["rules"], "deadline_s": 5, "fallback": "stop"}
    went = [{"on": "go", "to": "done"}, {"on": "stop", "to": "lost"}]
    result = run(mission({"asking": {"decision": asking, "transitions": went}}), robot, speed=math.inf)
    assert result.outcome == "succeeded"


# -- files -------------------------------------------------------------------------------------------------------------

FILE = """
import os
import re
from rai_missions import PythonRobot

robot = PythonRobot("turtle")
robot.fact("x", every_s=0.2)(lambda: 0.0)

@robot.action("drive", repeat={repeat})
def drive(goal, run):
    if not os.path.exists("crashed"):
        open("crashed", "w").close()
        run.sleep(0.1)
        os._exit(9)
    return {{}}
"""


def written(folder: Path, text: str, name: str = "my_robot.py") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("x = 1", "the file offers no 'robot'; write `robot = PythonRobot(\"name\")`"),
        ("robot = 7", "its 'robot' is '7'; write `robot = PythonRobot"),
        (
            "from rai_missions import PythonRobot\nrobot = PythonRobot('t')\nrobot.facts('x')",
            "line 3: AttributeError: 'PythonRobot' object has no attribute 'facts'; did you mean 'fact'?",
        ),
        (
            "from rai_missions import PythonRobot\ndef robot():\n    made = PythonRobot('t')\n    return maed",
            "line 4: NameError: name 'maed' is not defined; did you mean 'made'?",
        ),
        ("def robot():\n    return 7", "robot() returned '7'; return a PythonRobot"),
        ("def robot():\n    raise OSError('no bus')", "line 2: OSError: no bus"),
        ("import no_such_driver", "line 1: ModuleNotFoundError: No module named 'no_such_driver'"),
        ("def (", "line 1: not Python"),
        (
            "from rai_missions import PythonRobot\nPythonRobot('t').fact('X')",
            "line 2: UsageError: fact: 'X' is no name",
        ),
    ],
)
def test_what_is_wrong_in_a_file_comes_with_its_line(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(DefinitionError) as caught:
        run(DRIVING, written(tmp_path, text))
    assert sentence in str(caught.value)


def test_a_fault_in_the_rules_of_a_file_comes_with_the_file(tmp_path: Path) -> None:
    text = FILE.format(repeat=True).replace('("turtle")', '("turtle", rules={"a": [{"answer": "go", "wen": 1}]})')
    with pytest.raises(DefinitionError) as caught:
        run(DRIVING, written(tmp_path, text))
    assert caught.value.source == str(tmp_path / "my_robot.py")
    assert "/rules/a/0/wen: a rule has no 'wen'; did you mean 'when'?" in str(caught.value)


def test_a_file_may_make_one_robot_a_run_and_is_not_needed_by_a_replay(tmp_path: Path) -> None:
    text = (
        FILE.format(repeat=False)
        .replace("not os.path.exists('crashed')", "False")
        .replace('not os.path.exists("crashed")', "False")
    )
    made = (
        "from rai_missions import PythonRobot\ndef robot():\n"
        + "\n".join(f"    {line}" for line in text.splitlines() if not line.startswith(("from rai",)))
        + "\n    return robot\n"
    )
    file = written(tmp_path, made)
    result = run(mission({"driving": doing("drive")}), file, journal=tmp_path / "run.journal")
    assert result.outcome == "succeeded"
    file.write_text("raise SystemExit('executed')", encoding="utf-8")
    assert replay(tmp_path / "run.journal").holds


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    script = Path(sys.executable).with_name("rai-missions")
    return subprocess.run(
        [script, *words],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        stdin=subprocess.DEVNULL,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )


@pytest.mark.parametrize("repeat", [False, True])
def test_after_a_kill_an_action_is_doubtful_or_starts_again_and_the_same_file_is_demanded(
    repeat: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = written(tmp_path, FILE.format(repeat=repeat))
    made = mission(
        {"driving": doing("drive", {"on": "uncertain", "to": "lost"})}, blackboard={"x": X | {"max_age_s": 60}}
    )
    path = tmp_path / "mission.json"
    path.write_text(json.dumps(made.written()), encoding="utf-8")
    killed = command(tmp_path, "run", "mission.json", "--robot", "my_robot.py", "--journal", "run.journal")
    assert killed.returncode == 9, killed.stderr
    shutil.copy(file, tmp_path / "as_it_was.py")
    file.write_text("open('executed', 'w')", encoding="utf-8")
    same = PythonRobot("turtle")
    for robot, sentence in (
        (same, "the run's robot was another file, or has changed since"),
        (None, "the run's robot is in Python; resume with the same file: --robot 'my_robot.py'"),
        (str(file), "the run's robot was another file, or has changed since"),
    ):
        with pytest.raises((DefinitionError, UsageError)) as caught:
            prepare(RunConfig(None, robot, resume=tmp_path / "run.journal"))
        assert sentence in str(caught.value)
    assert not Path("executed").exists() and not (tmp_path / "executed").exists()
    with prepare(RunConfig(None, tmp_path / "as_it_was.py", resume=tmp_path / "run.journal")) as again:
        assert again.runner.run().outcome == ("succeeded" if repeat else "aborted")


def test_the_robot_of_the_guide_has_thirty_lines_and_runs_from_its_file(tmp_path: Path) -> None:
    guide = (Path(__file__).parents[2] / "docs/guide/python_robot.md").read_text(encoding="utf-8")
    robot, made = re.findall(r"^```python\n(.*?)^```$", guide, re.DOTALL | re.MULTILINE)
    assert len([line for line in robot.splitlines() if line.strip()]) <= 30
    assert [robot.count(each) for each in ("robot.action(", "robot.fact(", "raise_event(")] == [2, 3, 1]
    written(tmp_path, robot)
    written(tmp_path, made.partition("\nresult = ")[0], "mission.py")
    words = ["run", "mission.py", "--robot", "my_robot.py", "--speed", "max", "--json", "--journal", "run.journal"]
    ran = command(tmp_path, *words)
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["outcome"] == "succeeded"
    with read(tmp_path / "run.journal") as record:
        digest = hashlib.sha256((tmp_path / "my_robot.py").read_bytes()).hexdigest()
        assert json.loads(record.header.profile)["connector"] == {
            "kind": "python",
            "file": "my_robot.py",
            "sha256": digest,
        }
    written(tmp_path, "raise SystemExit('executed')")
    assert replay(tmp_path / "run.journal").holds


def test_a_module_next_to_the_file_is_imported_while_it_is_executed_and_no_longer(tmp_path: Path) -> None:
    written(tmp_path, "VALUE = 0.5", "driver_of_the_turtle.py")
    text = FILE.format(repeat=False).replace('not os.path.exists("crashed")', "False")
    file = written(tmp_path, "import driver_of_the_turtle\n" + text)
    before = list(sys.path)
    assert run(mission({"driving": doing("drive")}), file, speed=math.inf).outcome == "succeeded"
    assert sys.path == before

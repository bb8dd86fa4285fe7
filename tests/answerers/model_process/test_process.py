# SPDX-License-Identifier: Apache-2.0
"""Whatever a named model does to its process costs its question an attempt: neither the run's time nor its end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents import run
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.model.process.model import ModelProcess
from rai_missions.answerers.model.providers import check_model
from rai_missions.connectors.connector import Report
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.node import MissionNode
from rai_missions.node.transport import Carrier
from rai_missions.profile import Robot
from rai_missions.runtime.result import Result
from rai_missions.testing import QUESTION, ReplyCollector, check_answerer
from tests.answerers.model_process.processes import (
    EXIT_S,
    PROVIDERS,
    ROBOT,
    asking,
    left_of,
    patient,
    pause,
    talking_robot,
)
from tests.providers.langchain_hostile import DEEDS, FORGED

PATIENT_S = 20.0
STARTS_WITHIN_S = 120.0
"""A script that loads the engine and has a model begin takes three seconds, and far longer on a busy machine."""
"""For a process to start, on a machine that is busy with others."""


ACTION = "test_msgs/action/Fibonacci"
MOVER = Robot.model_validate(
    {"name": "mover", "connector": {"kind": "local"}, "actions": {"move": {"action": "/move", "type": ACTION}}}
)
MOVING = Mission.model_validate(
    {
        "name": "moving_and_asking", "initial": "both",
        "states": {
            "both": {
                "parallel": {
                    "acts": {
                        "initial": "moves",
                        "states": {
                            "moves": {
                                "action": "move", "timeout_s": 600, "transitions": [{"on": "succeeded", "to": "moved"}],
                            },
                            "moved": {"final": "succeeded"},
                        },
                    },
                    "thinks": {
                        "initial": "asks",
                        "states": {
                            "asks": {
                                "decision": {
                                    "question": "?", "options": {"stay": {}}, "ask": ["agent"], "deadline_s": 600,
                                    "fallback": "stay",
                                },
                                "transitions": [{"on": "stay", "to": "thought"}],
                            },
                            "thought": {"final": "succeeded"},
                        },
                    },
                },
                "transitions": [{"on": "succeeded", "to": "over"}],
            },
            "over": {"final": "aborted"},
        },
    }
)  # fmt: skip


class Watched:
    """A run, and when its mission ended."""

    def __init__(self, mission: Mission, model: str, **words: Any) -> None:
        self.steps: list[Step] = []
        self.ended = 0.0
        self.result: Result = run(mission, model=model, on_step=self._step, **words)
        self.left_s = time.monotonic() - self.ended

    def _step(self, step: Step) -> None:
        self.steps.append(step)
        if step.outcome:
            self.ended = time.monotonic()

    @property
    def proposals(self) -> list[dict[str, Any]]:
        return [dict(step.event.data) for step in self.steps if step.event.kind == "proposal"]


def test_a_named_model_is_asked_and_answers(mark: str) -> None:
    watched = Watched(asking(PATIENT_S), "hostile:answers:stay")
    assert watched.result.outcome == "aborted"
    assert watched.proposals[0]["usage"]["model"] == "answers:stay"
    assert watched.left_s < EXIT_S
    assert patient(mark, EXIT_S) == []


def test_it_may_look_things_up_by_tools_that_run_in_the_engine(mark: str) -> None:
    """The process knows no connector."""
    mission = asking(PATIENT_S, tools=["list_topics"])
    robot = talking_robot("/hay_on_the_road_17")
    watched = Watched(mission, "hostile:looks:hay", robot=ROBOT, connector=robot)
    (answer,) = watched.proposals
    assert "hay_on_the_road_17" in answer["why"]
    assert [each["tool"] for each in answer["looked"]] == ["list_topics"]
    assert answer["usage"]["calls"] == 3
    robot.stop()


@pytest.mark.long
def test_its_keys_are_not_in_what_others_may_read_of_it(mark: str, tmp_path: Path) -> None:
    """Arguments and variables of a process are in /proc; the key comes by pipe, and the model has it."""
    watched = Watched(asking(PATIENT_S), "hostile:reports_its_start:HOSTILE_API_KEY")
    assert watched.proposals[0]["why"] == "it was hidden"
    raising = Watched(asking(PATIENT_S), "hostile:raises", journal=tmp_path / "run.journal")
    assert raising.proposals[0]["failed"] == "the model raised RuntimeError: 401: [hidden]"
    assert os.environ["HOSTILE_API_KEY"].encode() not in (tmp_path / "run.journal").read_bytes()


@pytest.mark.long
def test_one_that_crashes_is_started_again_for_the_next_attempt(mark: str) -> None:
    watched = Watched(asking(2 * PATIENT_S, attempts=2), "hostile:crashes")
    assert [each["failed"] for each in watched.proposals] == ["the model's process ended: it was ended by SIGSEGV"] * 2
    assert watched.result.outcome == "canceled", "the fallback"


@pytest.mark.long
def test_one_that_holds_its_interpreter_s_lock_is_replaced(mark: str, tmp_path: Path) -> None:
    """The first attempt is lost; the second one meets another process."""
    agent = DecisionAgent(ModelProcess(f"hostile:holds_once:{tmp_path / 'held'}"))
    patience = QUESTION._replace(until=PATIENT_S, at=0.01)
    first = ReplyCollector()
    agent.ask(patience, first)
    until = time.monotonic() + PATIENT_S
    while not (tmp_path / "held").exists():
        assert time.monotonic() < until
        pause()
    agent.withdraw(patience.number)
    agent.ask(patience._replace(number=2), second := ReplyCollector())
    assert "option" in second.wait(PATIENT_S)
    assert first.all == []
    began = time.monotonic()
    agent.stop()
    assert time.monotonic() - began < EXIT_S


@pytest.mark.long
def test_memory_beyond_the_limit_ends_it_and_the_reason_names_it(mark: str) -> None:
    watched = Watched(asking(PATIENT_S), "hostile:grows", model_memory_gib=0.25)
    assert "GiB of memory and may use 0.25" in watched.proposals[0]["failed"]


def test_a_model_that_never_opens_holds_up_no_start(mark: str, caplog: pytest.LogCaptureFixture) -> None:
    """Only the question waits for it, and the log gives the reason."""
    began = time.monotonic()
    watched = Watched(asking(0.3), "hostile:opens_never")
    assert watched.result.outcome == "canceled"
    assert time.monotonic() - began < EXIT_S + 1.0
    assert watched.left_s < EXIT_S
    assert "the model 'hostile:opens_never' is still opening, after 0." in caplog.text


def test_the_contract_of_answerers_is_kept(mark: str) -> None:
    check_answerer(lambda: DecisionAgent(ModelProcess("hostile:answers:replan")), within_s=PATIENT_S)


@pytest.mark.long
def test_the_same_goes_for_a_node(mark: str) -> None:
    robot = talking_robot("/somewhere")
    setting = RunConfig(asking(PATIENT_S), ROBOT, model="hostile:answers:stay", connector=robot)
    node = MissionNode(setting, "asking", managed=False, carrier=Carrier(robot, True, False), operator=False)
    node.run()
    try:
        with prepare(node.joined(setting)) as prepared:
            assert node.attend(prepared.runner).run().outcome == "aborted"
        assert patient(mark, EXIT_S) == []
    finally:
        node.conclude()
        node.stop()
        robot.stop()


class Motor:
    """Moves until it is stopped, and notes when."""

    def __init__(self) -> None:
        self.stopped = threading.Event()
        self.at = 0.0
        self._report: Callable[[Report], None] = lambda reply: None

    def accept(self, goal_id: str, goal: Any, report: Callable[[Report], None]) -> None:
        self._report = report
        report(Report(goal_id, "accepted", {}))

    def cancel(self, goal_id: str) -> None:
        self.at = time.monotonic()
        self.stopped.set()
        self._report(Report(goal_id, "canceled", {}))


def test_an_e_stop_does_not_wait_for_a_model_that_holds_its_lock(mark: str, tmp_path: Path) -> None:
    """On a thread of the engine's it would wait for an hour."""
    held, motor, robot = tmp_path / "held", Motor(), talking_robot("/somewhere")
    robot.offer("/move", ACTION, motor)
    setting = RunConfig(MOVING, MOVER, model=f"hostile:holds_once:{held}", connector=robot)
    with prepare(setting) as prepared:
        running = threading.Thread(target=prepared.runner.run)
        running.start()
        until = time.monotonic() + PATIENT_S
        while not held.exists():
            assert time.monotonic() < until
            pause()
        pressed = time.monotonic()
        prepared.runner.kill("the button")
        assert motor.stopped.wait(PATIENT_S)
        running.join(PATIENT_S)
    assert motor.at - pressed < 0.5, "on an idle machine it is 0.2 ms; see benchmarks/bench_models.py"
    assert not running.is_alive()
    robot.stop()


@pytest.mark.long
def test_everything_ends_with_an_engine_that_is_killed(mark: str, tmp_path: Path) -> None:
    """Also a daemon that a model left behind: with a session and a parent of its own."""
    command = program(tmp_path, f"run(mission, model='hostile:leaves_children:{mark}')", asking(600.0))
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as engine:
        try:
            until = time.monotonic() + STARTS_WITHIN_S
            while sum("MARK" in each for each in left_of(mark)) < 2:
                assert time.monotonic() < until, left_of(mark)
                assert engine.poll() is None
                pause()
        finally:
            engine.kill()
    assert patient(mark, EXIT_S) == []


def program(folder: Path, does: str, mission: Mission) -> list[str]:
    """A user's script that runs a mission on its top level, without a guard against being imported again."""
    (folder / "mission.json").write_text(dump(mission))
    script = folder / "script.py"
    script.write_text(
        f"import sys\nsys.path.insert(0, {str(PROVIDERS)!r})\n"
        f"open({str(folder / 'begun')!r}, 'a').write('x')\n"
        "from rai_missions import load\nfrom rai_missions.agents import run\n"
        f"mission = load({str(folder / 'mission.json')!r})\n{does}\n"
    )
    return [sys.executable, str(script)]


@pytest.mark.long
def test_a_script_is_not_imported_again(mark: str, tmp_path: Path) -> None:
    does = "assert run(mission, model='hostile:answers:stay').outcome == 'aborted'"
    subprocess.run(program(tmp_path, does, asking(PATIENT_S)), check=True, timeout=60)
    assert (tmp_path / "begun").read_text() == "x"


# -- the command line --------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_the_command_line_s_program_ends_although_the_model_hangs_with_threads(mark: str, tmp_path: Path) -> None:
    seconds, printed = timed_end(tmp_path, "hostile:pools", asking(4.0))
    assert printed["outcome"] == "canceled"
    assert seconds < EXIT_S + timed_end(tmp_path, "", asking(4.0))[0]


def timed_end(folder: Path, model: str, mission: Mission) -> tuple[float, dict[str, Any]]:
    """Seconds from the end of the mission to the program's; of a program without a model, those that Python takes."""
    (folder / "mission.json").write_text(dump(mission))
    ended = folder / "ended"
    script = (
        "import sys, time\nfrom rai_missions.cli import main as cli\nfrom rai_missions.runtime import runner\nbefore = runner.Runner._result\n"  # noqa: E501
        "def noted(self, began):\n"
        f"    open({str(ended)!r}, 'w').write(str(time.time()))\n"
        "    return before(self, began)\n"
        "runner.Runner._result = noted\nsys.exit(cli.main(sys.argv[1:]))\n"
    )
    words = ["run", str(folder / "mission.json"), "--json", "--journal", str(folder / f"run{bool(model)}.journal")]
    words += ["--model", model] if model else []
    environment = os.environ | {"PYTHONPATH": str(PROVIDERS)}
    done = subprocess.run(
        [sys.executable, "-c", script, *words], env=environment, capture_output=True, text=True, timeout=90, check=False
    )
    now = time.time()
    assert done.returncode == 1, done.stderr
    return now - float(ended.read_text()), json.loads(done.stdout)


@pytest.mark.parametrize(("spec", "memory_gib", "why"), [
    ("hostil:answers", 2.0, "no model provider 'hostil'"),
    ("hostile", 2.0, "names no model"),
    ("openai:x", 2.0, "set the environment variable OPENAI_API_KEY"),
    ("hostile:answers", 0.0, "is a number of GiB above 0"),
    ("local:/no/such.gguf", 2.0, "there is no file"),
])  # fmt: skip
def test_what_is_wrong_with_a_name_is_reported_before_anything_starts(
    spec: str, memory_gib: float, why: str, mark: str
) -> None:
    with pytest.raises(UsageError, match=why):
        check_model(spec, memory_gib=memory_gib)
    with pytest.raises(UsageError, match=why):
        run(asking(1.0), model=spec, model_memory_gib=memory_gib)


def test_weights_that_are_larger_than_the_memory_are_refused(tmp_path: Path) -> None:
    with (tmp_path / "large.gguf").open("wb") as file:
        file.write(b"GGUF")
        file.truncate(3 << 30)
    with pytest.raises(
        UsageError, match=r"has 3\.0 GiB of weights and may use 2 GiB of memory; allow it more: --model-"
    ):
        check_model(f"local:{tmp_path / 'large.gguf'}", memory_gib=2.0)


# -- the drill ---------------------------------------------------------------------------------------------------------

FORGERIES = [f"forges:{number}" for number in range(len(FORGED))]
EVERYTHING = [*(deed for deed in DEEDS if deed not in ("forges", "holds_once", "reports_its_start")), *FORGERIES]


@pytest.mark.drill
@pytest.mark.timeout(120)
@pytest.mark.parametrize("deed", [*EVERYTHING, "opens_never", "dies_early", "refuses"])
def test_whatever_a_model_does_the_run_ends_in_time(deed: str, mark: str, tmp_path: Path) -> None:
    """Every deed by the command line: its mission ends by its own deadline, and everything within two seconds of it."""
    seconds, printed = timed_end(tmp_path, f"hostile:{deed}", asking(6.0, attempts=2))
    assert printed["outcome"] in ("aborted", "canceled")
    assert seconds < EXIT_S + timed_end(tmp_path, "", asking(6.0))[0]
    assert patient(mark, EXIT_S) == []


@pytest.mark.drill
@pytest.mark.timeout(120)
@pytest.mark.parametrize("deed", EVERYTHING)
def test_whatever_a_model_does_all_ends_with_an_engine_that_is_killed(deed: str, mark: str, tmp_path: Path) -> None:
    does = f"run(mission, model='hostile:{deed}', on_step=lambda step: print(step.seq, flush=True))"
    with subprocess.Popen(program(tmp_path, does, asking(600.0)), stdout=subprocess.PIPE) as engine:
        assert engine.stdout is not None
        engine.stdout.readline()
        time.sleep(3.0)  # the model is at it
        engine.send_signal(signal.SIGKILL)
    assert patient(mark, EXIT_S) == []

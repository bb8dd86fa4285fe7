# SPDX-License-Identifier: Apache-2.0
"""Several agents as one: in order, stopped in reverse by real signals, and none takes another with it."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from rai_missions.agents.agent import Agent, AgentHealth
from rai_missions.agents.health import DIAGNOSTIC_ARRAY, DIAGNOSTICS, diagnostics_of
from rai_missions.agents.mission import MissionAgent, RunConfig
from rai_missions.agents.process_agent import ProcessAgent
from rai_missions.agents.runner import AgentRunner
from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.testing import check_agent
from tests.agents.test_mission import WAITING
from tests.agents.troupe import Player, agent_of
from tests.replay.deaths import wait_until
from tests.ros2 import load_quietly, on_ros

TROUPE = Path(__file__).parent / "troupe.py"


class Troupe:
    """Agents in a process of their own."""

    def __init__(self, folder: Path, *kinds: str) -> None:
        self.file = folder / "lines"
        self.file.touch()
        env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
        self.process = subprocess.Popen(
            [sys.executable, str(TROUPE), str(self.file), *kinds],
            stderr=subprocess.PIPE,
            text=True,
            env=env,
            stdout=subprocess.DEVNULL,
        )
        self.log: Inbox[str] = Inbox(30.0)
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        with self.process.stderr:
            for line in self.process.stderr:
                self.log(line.rstrip())

    def wait_for(self, words: str) -> None:
        self.log.wait(lambda lines: any(words in line for line in lines), f"'{words}' is logged")

    def signal_and_wait(self, number: int = signal.SIGTERM) -> tuple[int, float]:
        """The exit status, and how long it took."""
        began = time.monotonic()
        self.process.send_signal(number)
        return self.wait(), time.monotonic() - began

    def wait(self) -> int:
        status = self.process.wait(30.0)
        self._reader.join()
        return status

    def lines(self) -> list[str]:
        return self.file.read_text(encoding="utf-8").splitlines()


@pytest.fixture
def troupe(tmp_path: Path) -> Iterator[Any]:
    made: list[Troupe] = []

    def start(*kinds: str) -> Troupe:
        made.append(Troupe(tmp_path, *kinds))
        return made[-1]

    yield start
    for each in made:
        if each.process.poll() is None:
            each.process.kill()
        each.wait()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_stops_all_in_the_reverse_order(troupe: Any, number: int) -> None:
    ran = troupe("plain", "process", "plain")
    ran.wait_for("2_plain: running")
    assert ran.signal_and_wait(number)[0] == 0
    assert ran.lines() == ["run 0_plain", "run 2_plain", "stop 2_plain", "stop 0_plain"]


def test_one_that_hangs_is_named_and_all_end_within_seconds(troupe: Any) -> None:
    ran = troupe("plain", "hangs", "stubborn", "mute")
    ran.wait_for("3_mute hangs: it has not reported how it fares for 2 s")
    status, took_s = ran.signal_and_wait()
    assert status == 1 and took_s < 6.0, took_s
    assert ran.lines()[-3:] == ["stop 3_mute", "stop 1_hangs", "stop 0_plain"]
    assert any("1_hangs hangs: stop has not returned within" in line for line in ran.log.all)
    assert any("1_hangs is cut off; its connector 'stage': was stopped" in line for line in ran.log.all)


def test_one_that_dies_is_named_with_its_reason_and_takes_no_other_with_it(troupe: Any) -> None:
    ran = troupe("refuses", "dies", "crashes", "never_begins", "breaks", "plain")
    for words in (
        "0_refuses died: run raised ValueError: no stage",
        "1_dies died: stage fright",
        "2_crashes failed: exit status 1: the lights went out",
        "3_never_begins hangs: run has not returned within",
        "5_plain: running",
    ):
        ran.wait_for(words)
    assert ran.process.poll() is None, "the others live"
    assert ran.signal_and_wait()[0] == 1
    assert any("4_breaks died: stop raised OSError: the curtain is stuck" in line for line in ran.log.all)
    assert ran.lines()[-1] == "stop 0_refuses", "even what never began is asked to end"


def test_a_second_signal_waits_for_no_one(troupe: Any) -> None:
    ran = troupe("hangs", "hangs", "hangs")
    ran.wait_for("2_hangs: running")
    ran.process.send_signal(signal.SIGTERM)
    ran.wait_for("2_hangs: hangs")
    assert ran.signal_and_wait()[1] < 1.5
    assert not any("0_hangs hangs" in line for line in ran.log.all), "it had its time to end, and was not waited for"
    assert any("0_hangs is cut off; its connector 'stage': was stopped" in line for line in ran.log.all)


def test_when_no_agent_lives_it_is_over(troupe: Any) -> None:
    assert troupe("ends", "ends").wait() == 0


def test_a_program_has_the_time_to_end_that_it_was_given(tmp_path: Path) -> None:
    calm = "trap 'sleep 0.5; touch at_rest; exit 0' TERM; touch begun; sleep 600 & wait"
    agent = ProcessAgent(["bash", "-c", f"cd '{tmp_path}'; {calm}"], stop_s=20.0)
    runner = AgentRunner({"robot": agent}, stop_s=0.1)
    runner.run()
    assert wait_until((tmp_path / "begun").exists, within_s=30)
    runner.stop()
    assert runner.agents["robot"].state == "stopped"
    assert (tmp_path / "at_rest").exists()


def test_nothing_is_left_of_a_program_that_is_killed(tmp_path: Path) -> None:
    child = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(600)'])"
    agent = ProcessAgent([sys.executable, "-c", child], stop_s=0.3)
    agent.run()
    session = int(agent.health.values["pid"])
    agent.stop()
    assert agent.health.state == "stopped"
    assert is_gone(session)


@pytest.mark.parametrize(("command", "words"), [("sleep 5", "['sleep', '5']"), ("", "['sleep', '600']"), ([], "[")])
def test_a_command_that_is_no_list_of_words_is_refused(command: Any, words: str) -> None:
    with pytest.raises(UsageError, match=re.escape(f"a program is a list of its words, such as {words}")):
        ProcessAgent(command)


def test_a_program_that_is_not_there_is_named() -> None:
    runner = AgentRunner({"ear": ProcessAgent(["/no/such/program"])})
    runner.run()
    assert runner.agents["ear"] == AgentHealth(
        "died", "run raised FileNotFoundError: [Errno 2] No such file or directory: '/no/such/program'"
    )
    runner.stop()
    assert runner.health.why.startswith("ear: died")


def test_every_agent_keeps_the_contract(tmp_path: Path) -> None:
    mission = Mission.model_validate(WAITING)
    makers: dict[str, Any] = {
        "a player": lambda: Player("x", "plain", tmp_path / "lines"),
        "a program": lambda: agent_of("x", "process", tmp_path),
        "several": lambda: AgentRunner({"one": Player("x", "plain", tmp_path / "lines")}),
        "a mission": lambda: MissionAgent(RunConfig(mission)),
    }
    for make in makers.values():
        check_agent(make)


@pytest.mark.parametrize(
    ("kind", "promise"),
    [("hangs", "stop returns at once"), ("mute", "health returns at once"), ("breaks", "stop raises OSError")],
)
def test_the_contract_finds_what_breaks_it(tmp_path: Path, kind: str, promise: str) -> None:
    class Odd(Player):
        def run(self) -> None:
            self._is_running = True

    with pytest.raises(AssertionError, match=promise):
        check_agent(lambda: Odd("x", kind, tmp_path / "lines"), within_s=0.2)


def test_the_health_of_each_is_published(tmp_path: Path) -> None:
    connector = LocalConnector()
    connector.start()
    inbox: Inbox[Message] = Inbox(10.0)
    connector.subscribe(DIAGNOSTICS, DIAGNOSTIC_ARRAY, inbox)
    agents: dict[str, Agent] = {
        "eye": Player("eye", "plain", tmp_path / "l"),
        "ear": Player("ear", "dies", tmp_path / "l"),
    }
    runner = AgentRunner(agents, connector=connector, name="robot1")
    runner.run()
    bad = {"level": 2, "name": "robot1: ear", "message": "died: stage fright", "hardware_id": "", "values": []}
    inbox.wait(lambda all_: any(bad in each.data["status"] for each in all_), "a death is published")
    fine = {"level": 0, "name": "robot1: eye", "message": "running", "hardware_id": "", "values": []}
    assert fine in inbox.all[-1].data["status"]
    runner.stop()
    stopped = {each["name"]: each["message"] for each in inbox.all[-1].data["status"]}
    assert stopped == {"robot1: eye": "stopped", "robot1: ear": "died: stage fright"}


def test_a_mission_is_one_agent_among_others(tmp_path: Path) -> None:
    mission = MissionAgent(RunConfig(Mission.model_validate(WAITING)))
    assert mission.health.state == "ready" and dict(mission.connectors) == {}
    runner = AgentRunner({"mission": mission, "ear": Player("ear", "plain", tmp_path / "lines")})
    runner.run()
    assert runner.agents["mission"].state == "running"
    runner.stop()
    assert mission.result is not None and mission.result.outcome == "canceled"
    assert mission.health == AgentHealth("ended", "canceled")
    assert runner.health.state == "stopped"


class Slow(Player):
    """Takes longer to stop than others, as it states."""

    stop_s = 20.0

    def stop(self) -> None:
        self.is_asked.set()
        self.may_end.wait()
        super().stop()

    is_asked, may_end = threading.Event(), threading.Event()


def test_a_runner_among_others_has_the_time_and_the_connectors_of_its_agents(tmp_path: Path) -> None:
    slow, quick = Slow("slow", "plain", tmp_path / "lines"), Player("quick", "plain", tmp_path / "lines")
    inner = AgentRunner({"slow": slow, "quick": quick}, stop_s=2.0)
    assert inner.stop_s == 23.0
    assert inner.connectors == {"slow/stage": slow.connectors["stage"], "quick/stage": quick.connectors["stage"]}
    outer = AgentRunner({"inner": inner}, stop_s=0.01)
    outer.run()
    end = threading.Thread(target=outer.stop)
    end.start()
    assert slow.is_asked.wait(10.0)
    slow.may_end.set()
    end.join(10.0)
    assert (outer.agents["inner"].state, inner.agents["slow"].state) == ("stopped", "stopped")


class Speechless(Player):
    """Never states how long its end may take, and takes a moment for it."""

    @property
    def stop_s(self) -> float:
        threading.Event().wait()
        return 1.0

    def stop(self) -> None:
        threading.Event().wait(0.2)
        super().stop()


def test_an_agent_that_does_not_state_how_long_its_end_takes_has_the_usual_time_for_it(tmp_path: Path) -> None:
    runner = AgentRunner({"speechless": Speechless("speechless", "plain", tmp_path / "lines")}, stop_s=1.0)
    runner.run()
    runner.stop()
    assert runner.agents["speechless"].state == "stopped"


class Liar(Player):
    """States what no agent may."""

    @property
    def stop_s(self) -> float:
        if self.kind == "raises":
            raise RuntimeError("no time")
        if self.kind == "endless":
            return 10**400
        return float("nan")

    @property
    def connectors(self) -> Any:
        raise RuntimeError("no connectors")

    @connectors.setter
    def connectors(self, _: Any) -> None: ...

    def run(self) -> None:
        self.note("run")

    def stop(self) -> None:
        self.note("stop")
        if self.kind == "hangs":
            threading.Event().wait()

    @property
    def health(self) -> Any:
        if self.kind == "leaves":
            raise SystemExit(3)
        odd: dict[str, Any] = {"none": None, "flies": ("flies",), "five": ("running", 5), "flat": ("running", "", "x")}
        stated = odd.get(self.kind, ("running",))
        return stated and AgentHealth(*stated)


def test_what_an_agent_states_of_itself_harms_no_other(tmp_path: Path) -> None:
    connector, inbox = LocalConnector(), Inbox[Message](10.0)
    connector.start()
    connector.subscribe(DIAGNOSTICS, DIAGNOSTIC_ARRAY, inbox)
    kinds = ("raises", "hangs", "nan", "endless", "none", "leaves", "five", "flat", "flies")
    agents: dict[str, Agent] = {each: Liar(each, each, tmp_path / "lines") for each in kinds}
    runner = AgentRunner(
        {"first": Player("first", "plain", tmp_path / "lines"), **agents}, connector=connector, stop_s=0.1
    )
    runner.run()

    def levels(message: Message) -> dict[str, int]:
        return {each["name"]: each["level"] for each in message.data["status"]}

    inbox.wait(lambda all_: any(levels(each).get("agents: flies") == 2 for each in all_), "all are still published")
    assert runner.agents["none"] == AgentHealth(
        "died",
        "it reports None; health is an AgentHealth whose state is one of "
        "ready, running, ended, failed, died, stopped, hangs",
    )
    assert runner.agents["leaves"] == AgentHealth("died", "it cannot report how it fares: SystemExit: 3")
    runner.stop()
    assert {name: health.state for name, health in runner.agents.items()} == {
        "first": "stopped",
        "raises": "stopped",
        "hangs": "hangs",
        "nan": "stopped",
        "none": "died",
        "flies": "died",
        "endless": "stopped",
        "leaves": "died",
        "five": "died",
        "flat": "died",
    }
    connector.stop()


class Unended:
    """An agent of which only the start was written."""

    def run(self) -> None: ...


class Wrapped:
    """An agent that passes on all that it is asked."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent

    def __getattr__(self, name: str) -> Any:
        return getattr(self._agent, name)


class Unwired(Unended):
    """An agent that hangs, and talks through nothing that can be stopped."""

    connectors: ClassVar = {"wire": 5}

    def stop(self) -> None:
        threading.Event().wait()


def test_what_is_no_agent_is_refused_before_any_begins(tmp_path: Path) -> None:
    first = Player("first", "plain", tmp_path / "lines")
    wrong: dict[str, Any] = {"number": 5, "unended": Unended(), "class": Player}
    with pytest.raises(UsageError) as caught:
        AgentRunner({"first": first, **wrong})
    assert str(caught.value) == (
        "'number': int has no 'run'; an agent has run() and stop(); "
        "'unended': Unended has no 'stop'; an agent has run() and stop(); "
        "'class': Player is a class; give an agent of it, Player(…)"
    )
    unnamed: Any = [first]
    with pytest.raises(UsageError, match=r'agents are given by their names, {"lamp": Lamp\(\)}, not as \['):
        AgentRunner(unnamed)
    wrapped: Any = Wrapped(first)
    runner = AgentRunner({"wrapped": wrapped})
    runner.run()
    runner.stop()
    assert runner.agents["wrapped"].state == "stopped"


def test_what_is_no_connector_is_named_and_holds_up_no_other(tmp_path: Path) -> None:
    first = Player("first", "hangs", tmp_path / "lines")
    runner = AgentRunner({"first": first, "unwired": Unwired()}, stop_s=0.1)
    runner.run()
    runner.stop()
    found = runner.agents
    assert (found["unwired"].state, found["first"].state) == ("hangs", "hangs")
    assert not first.connectors["stage"].running, "it is cut off as well"


class Ending:
    """An agent whose life ends at a moment of its own choice: it has its runner stop, or is asked while it begins."""

    def __init__(self, kind: str, runner: list[AgentRunner]) -> None:
        self.kind, self.runner = kind, runner
        self.may_return, self.begins = threading.Event(), threading.Event()
        self.lives = 0

    def run(self) -> None:
        self.lives += 1
        self.begins.set()
        if self.kind == "run stops":
            self.runner[0].stop()
        if self.kind == "returns late" or (self.kind == "hangs again" and self.lives == 2):
            self.may_return.wait()

    def stop(self) -> None:
        if self.kind == "stop stops":
            self.runner[0].stop()
        if self.kind == "returns late":
            threading.Timer(0.1, self.may_return.set).start()


PATIENT_S = 20.0


@pytest.mark.parametrize(
    ("script", "health"),
    [
        ("exit 0", ("ended", "")),
        ("echo canceling >&2; exit 1", ("failed", "exit status 1: canceling")),
        ("kill -KILL $$", ("died", "ended by SIGKILL")),
        ("kill -TERM $$", ("stopped", "ended by SIGTERM")),
        ("exit 129", ("stopped", "exit status 129")),
        ("exit 130", ("stopped", "exit status 130")),
    ],
)
def test_a_program_that_ends_by_itself_is_named_by_how_it_did(script: str, health: tuple[str, str]) -> None:
    agent = ProcessAgent(["sh", "-c", script])
    agent.run()
    assert wait_until(lambda: agent.health.state != "running", PATIENT_S)
    assert agent.health[:2] == health
    runner = AgentRunner({"program": ProcessAgent(["sh", "-c", script])})
    assert runner.serve() == runner.agents["program"].is_fault
    assert (runner.agents["program"].state, runner.agents["program"].why) == health


def test_of_a_line_without_an_end_its_beginning_is_kept_alone() -> None:
    agent = ProcessAgent(["sh", "-c", "printf 'no light ' >&2; head -c 100000000 /dev/zero | tr '\\0' x >&2; exit 3"])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    agent.run()
    assert wait_until(lambda: agent.health.state != "running", PATIENT_S)
    assert agent.health.why.startswith("exit status 3: no light xxx") and len(agent.health.why) < 250
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000, "kB"


@pytest.mark.parametrize("kind", ["run stops", "stop stops", "returns late"])
@pytest.mark.parametrize("serves", [False, True])
def test_an_agent_that_ends_as_it_is_asked_is_stopped_at_whatever_moment(kind: str, serves: bool) -> None:
    runner: list[AgentRunner] = []
    ending, before = Ending(kind, runner), Ending("plain", runner)
    runner.append(AgentRunner({"before": before, "ending": ending, "after": Ending("plain", runner)}))
    status: list[int] = []
    life = threading.Thread(target=lambda: status.append(runner[0].serve()) if serves else runner[0].run())
    life.start()
    assert ending.begins.wait(10.0)
    runner[0].stop()
    life.join(10.0)
    assert not life.is_alive() and status == [0] * serves
    states = {name: health.state for name, health in runner[0].agents.items()}
    assert states.pop("after") in ("ready", "stopped")
    assert states == {"before": "stopped", "ending": "stopped"}
    ending.kind = "plain"
    runner[0].run()
    assert {health.state for health in runner[0].agents.values()} == {"running"}, "a stopped one may be run again"
    runner[0].stop()


def test_one_that_hangs_in_its_second_life_is_named() -> None:
    ending = Ending("hangs again", [])
    runner = AgentRunner({"ending": ending}, start_s=0.1, stop_s=0.1)
    for state in ("stopped", "hangs"):
        runner.run()
        runner.stop()
        assert runner.agents["ending"].state == state
    ending.may_return.set()


def test_a_long_reason_is_cut_where_it_is_published() -> None:
    found = diagnostics_of("all", {"ear": AgentHealth("died", "x" * 5000, {"log": "y" * 5000})}, at=1.0)
    (status,) = found["status"]
    assert len(status["message"]) < 400 and len(status["values"][0]["value"]) < 400


def test_health_has_only_texts_that_a_message_carries() -> None:
    found = diagnostics_of("a\ud800", {"b\0": AgentHealth("died", "c\ud800\0", {"k\ud800": "v\0"})}, at=1.0)
    (status,) = found["status"]
    assert (status["name"], status["message"]) == ("a?: b?", "died: c\ufffd?")
    assert status["values"] == [{"key": "k?", "value": "v?"}]


@on_ros
def test_health_is_a_message_of_ros() -> None:
    load_quietly()
    from rai_missions.connectors.ros2.messages import to_data, to_message
    from rai_missions.connectors.ros2.names import find_type

    sent = diagnostics_of("all", {"ear": AgentHealth("died", "no sound", {"pid": "7"})}, at=12.5)
    received = to_data(to_message(find_type(DIAGNOSTIC_ARRAY, "msg"), sent))
    assert received["status"] == sent["status"]
    assert received["header"]["stamp"] == {"sec": 12, "nanosec": 500_000_000}


def test_what_a_program_leaves_behind_ends_with_it() -> None:
    child = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'])"
    agent = ProcessAgent([sys.executable, "-c", child])
    agent.run()
    session = int(agent.health.values["pid"])
    assert wait_until(lambda: agent.health.state == "ended", within_s=30)
    assert is_gone(session)
    agent.stop()
    assert agent.health.state == "ended"


def is_gone(group: int) -> bool:
    """Whether no process is left in a group: the one that adopts what was killed may reap it a moment later."""
    return wait_until(lambda: not is_group(group), within_s=30)


def is_group(number: int) -> bool:
    """Whether any process is in a group."""
    try:
        os.killpg(number, 0)
    except ProcessLookupError:
        return False
    return True

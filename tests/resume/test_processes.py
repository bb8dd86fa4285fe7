# SPDX-License-Identifier: Apache-2.0
"""Real processes and a real `kill -9`: over ROS 2 the robot lives on; a world in the same process starts anew."""

from __future__ import annotations

import json
import os
import random
import signal
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import Record, read, verify
from rai_missions.replay import replay
from rai_missions.step import StartGoal
from tests.connectors.ros2.peer_process import Peer
from tests.ros2 import on_ros
from tests.tractor.ros2_processes import TRACTOR, Graph, Process, graph_in

pytestmark = [pytest.mark.sim]
ORCHARD = {"alleys": 1, "length_m": 14, "obstacles": ["branch"], "camera": True}


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    yield from graph_in(tmp_path, Graph)


def go_on(graph: Graph, *words: str) -> Process:
    return graph.start("run", "--resume", str(graph.folder / "run.journal"), "--no-operator", *words)


def kill(process: Process) -> None:
    process.signal(signal.SIGKILL)
    assert process.ends() == -signal.SIGKILL


def is_whole(journal: Path) -> None:
    assert verify(journal) == ()
    again = replay(journal)
    assert again.holds, again.difference
    with read(journal) as record:
        steps = list(record.steps())
    assert [step.seq for step in steps] == sorted({step.seq for step in steps})
    numbers = [each.number for step in steps for each in step.effects if isinstance(each, StartGoal)]
    assert len(numbers) == len(set(numbers))


def test_two_processes_do_not_go_on_with_one_run(graph: Graph) -> None:
    mission = graph.folder / "wait.json"
    mission.write_text(
        json.dumps(
            {
                "name": "wait",
                "format": 1,
                "version": "1.0.0",
                "initial": "waiting",
                "states": {
                    "waiting": {"transitions": [{"after_s": 1000, "to": "over"}]},
                    "over": {"final": "canceled"},
                },
            }
        )
    )
    journal = graph.folder / "run.journal"
    first = graph.start("run", str(mission), "--journal", str(journal), "--verbose")
    first.says("waiting")
    kill(first)
    second = go_on(graph, "--verbose")
    second.says("take_up")
    third = go_on(graph)
    assert third.ends() == 2
    assert f"{journal} is being written by another process; wait for its end" in third.text
    second.signal(signal.SIGINT)
    assert second.ends() == 1
    assert "canceled" in second.text
    ended = go_on(graph)
    assert ended.ends() == 2
    assert f"the run of {journal} has ended, canceled: canceled by operator (interrupt)" in ended.text
    is_whole(journal)


def written(folder: Path, peer: str) -> tuple[Path, Path]:
    """A mission that does a bit of everything, and the profile of a robot that is a peer in another process."""
    fibonacci = {"action": f"/{peer}/fibonacci", "type": "test_msgs/action/Fibonacci"}
    robot = {
        "name": "peer", "connector": {"kind": "ros2"}, "identity": "",
        "actions": {"go": {**fibonacci, "goal": {"order": 120}, "uses": ["base"]},
                    "look": {**fibonacci, "goal": {"order": 100}, "uses": ["head"]}},
        "services": {"horn": {"service": f"/{peer}/trigger", "type": "std_srvs/srv/Trigger", "repeat": True}},
        "rules": {"asking": [{"answer": "on"}]},
    }  # fmt: skip
    ends = [{"on": "succeeded", "to": "over"}]
    mission = {
        "name": "much", "format": 1, "version": "1.0.0", "initial": "going",
        "states": {
            "going": {"action": "go", "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "asking"}]},
            "asking": {"decision": {"question": "On?", "options": {"on": {"about": "on"}, "off": {"about": "off"}},
                                    "ask": ["rules"], "deadline_s": 60, "fallback": "off"},
                       "transitions": [{"on": "on", "to": "both"}, {"on": "off", "to": "lost"}]},
            "both": {"parallel": {
                "body": {"initial": "turning", "states": {
                    "turning": {"action": "go", "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "turned"}]},
                    "turned": {"final": "succeeded"}}},
                "head": {"initial": "looking", "states": {
                    "looking": {"tree": {"sequence": [{"action": "look", "timeout_s": 60},
                                                      {"call": "horn", "timeout_s": 60}, {"wait_s": 0.5}]},
                                "timeout_s": 120, "transitions": [{"on": "succeeded", "to": "looked"}]},
                    "looked": {"final": "succeeded"}}}},
                "transitions": [{"on": "succeeded", "to": "waiting"}]},
            "waiting": {"transitions": [{"after_s": 1, "to": "leaving"}]},
            "leaving": {"action": "go", "timeout_s": 60, "transitions": ends},
            "over": {"final": "canceled"}, "lost": {"final": "aborted"}},
    }  # fmt: skip
    paths = folder / "much.json", folder / "peer.json"
    for path, content in zip(paths, (mission, robot), strict=True):
        path.write_text(json.dumps(content))
    return paths


def driven(graph: Graph, peer: Peer, chance: random.Random, deaths: int) -> int:
    """Run the mission with a robot that lives on, killed so often at most; how many kills there were."""
    mission, robot = written(graph.folder, peer.name)
    journal = graph.folder / f"{uuid.uuid4().hex}.journal"
    process = graph.start("run", str(mission), "--robot", str(robot), "--json", "--journal", str(journal))
    kills = 0
    while kills < deaths and dies(process, journal, chance):
        kills += 1
        process = graph.start("run", "--resume", str(journal), "--json")
    process.ends()
    assert process.text.endswith("}") or "has ended, canceled: 'over' was reached" in process.text, process.text
    again = replay(journal)
    assert (again.outcome, again.why) == ("canceled", "'over' was reached"), process.text
    is_whole(journal)
    with read(journal) as record:
        entered = sorted(name for step in record.steps() for name in step.entered)
        goals = [each for step in record.steps() for each in step.effects if isinstance(each, StartGoal)]
    assert entered == sorted(set(entered)), "no state was entered twice"
    ran = Counter(said[1] for said in peer.said.all if said[0] == "runs")
    assert max(ran.values()) == 1, "the server was given no goal twice"
    assert len(goals) == 4
    return kills


def dies(process: Process, journal: Path, chance: random.Random) -> bool:
    """Kill it at some instant after it has begun to write; false if it ended before."""
    before, until = journal_rows(journal), time.monotonic() + 120
    while journal_rows(journal) <= before and not process.is_over and time.monotonic() < until:
        time.sleep(0.01)  # watching a file of another process: nothing tells of it
    time.sleep(chance.uniform(0.0, 2.5))
    if process.is_over:
        return False
    process.signal(signal.SIGKILL)
    return process.ends() == -signal.SIGKILL


def journal_rows(journal: Path) -> int:
    try:
        with Record(journal) as record:
            return sum(1 for _ in record.raw())
    except (DefinitionError, UsageError):
        return 0


@pytest.fixture
def robot(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> Iterator[Peer]:
    for name, value in graph.environment.items():
        monkeypatch.setenv(name, value)
    with Peer(f"robot_{uuid.uuid4().hex[:6]}") as peer:
        yield peer


@on_ros
def test_a_mission_over_ros_2_that_is_killed_ends_as_if_it_had_not_been(graph: Graph, robot: Peer) -> None:
    assert driven(graph, robot, random.Random(7), 2) > 0


@on_ros
@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_a_mission_over_ros_2_is_killed_as_often_as_time_allows(graph: Graph, robot: Peer) -> None:
    """`RAI_MISSIONS_DRILL_S` says how long, seconds."""
    began, lasts_s = time.monotonic(), float(os.environ.get("RAI_MISSIONS_DRILL_S", "600"))
    kills, runs, chance = 0, 0, random.Random(20261121)
    while time.monotonic() - began < lasts_s:
        kills, runs = kills + driven(graph, robot, chance, chance.randint(1, 6)), runs + 1
        print(f"{kills} kills in {runs} runs, {time.monotonic() - began:.0f} s", flush=True)  # noqa: T201 - the figure


def test_the_simulated_tractor_that_is_killed_goes_on_in_a_world_that_starts_anew(graph: Graph) -> None:
    profile = json.loads((TRACTOR / "robot.sim.json").read_text()) | {"identity": ""}
    profile["connector"] |= ORCHARD
    robot = graph.folder / "robot.json"
    robot.write_text(json.dumps(profile))
    process = graph.run("--speed", "1", robot=robot)
    process.says("start drive_alleys")
    kill(process)
    process = go_on(graph)
    assert process.ends() == 0, process.text
    assert "the simulated world starts anew, and what was under way in it is begun again" in process.text
    is_whole(graph.folder / "run.journal")

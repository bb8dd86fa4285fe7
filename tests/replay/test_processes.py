# SPDX-License-Identifier: Apache-2.0
"""Real processes and a real `kill -9`: one process a run, and a world in the same process that starts again."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rigs.journals import assert_whole
from tests.tractor.ros2_processes import TRACTOR, Graph, Process, graph_in

pytestmark = [pytest.mark.sim]
ORCHARD = {"alleys": 1, "length_m": 14, "obstacles": ["branch"], "camera": True}


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    yield from graph_in(tmp_path, Graph)


def resume(graph: Graph, *words: str) -> Process:
    return graph.start("run", "--resume", str(graph.folder / "run.journal"), "--no-operator", *words)


def kill(process: Process) -> None:
    process.signal(signal.SIGKILL)
    assert process.ends() == -signal.SIGKILL


@pytest.mark.long
def test_two_processes_do_not_continue_with_one_run(graph: Graph) -> None:
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
    first.wait_for("waiting")
    kill(first)
    second = resume(graph, "--verbose")
    second.wait_for("take_up")
    third = resume(graph)
    assert third.ends() == 2
    assert f"{journal} is being written by another process; wait for its end" in third.text
    second.signal(signal.SIGINT)
    assert second.ends() == 1
    assert "canceled" in second.text
    ended = resume(graph)
    assert ended.ends() == 2
    assert f"the run of {journal} has ended, canceled: canceled by operator (interrupt)" in ended.text
    assert_whole(journal)


@pytest.mark.long
def test_the_simulated_tractor_that_is_killed_continues_in_a_world_that_starts_again(graph: Graph) -> None:
    profile = json.loads((TRACTOR / "robot.sim.json").read_text()) | {"identity": ""}
    profile["connector"] |= ORCHARD
    robot = graph.folder / "robot.json"
    robot.write_text(json.dumps(profile))
    process = graph.run("--speed", "1", robot=robot)
    process.wait_for("start drive_alleys")
    kill(process)
    process = resume(graph)
    assert process.ends() == 0, process.text
    assert "the simulated world starts again, and what was under way in it is begun again" in process.text
    assert_whole(graph.folder / "run.journal")

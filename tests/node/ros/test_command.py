# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --node` in a process of its own: next to one run, and managed, as a launch file starts it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rai_missions.journal import read
from tests.node.scenes import Client, mission, robot

Run = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def run(domain: int, tmp_path: Path) -> Iterator[Run]:
    """Starts the command on `errand`."""
    begun: list[subprocess.Popen[str]] = []
    (tmp_path / "errand.json").write_text(json.dumps({"format": 1, **mission().written()}))
    profile = robot({"kind": "ros2", "domain_id": domain}).written()
    (tmp_path / "robot.json").write_text(json.dumps(profile))

    def start(*words: str) -> subprocess.Popen[str]:
        script = Path(sys.executable).with_name("rai-missions")
        command = [str(script), "run", "errand.json", "--robot", "robot.json", *words]
        process = subprocess.Popen(
            command, cwd=tmp_path, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        begun.append(process)
        return process

    yield start
    for process in begun:
        process.kill()
        process.communicate()


@pytest.mark.long
def test_a_node_next_to_a_run_ends_with_it(run: Run, open_client: Callable[[str], Client]) -> None:
    process = run("--node", "near", "--json", "--ros-args", "-r", "__ns:=/farm", "--log-level", "warn")
    client = open_client("/farm/near")
    client.await_status("it runs", mode="running", lifecycle="active")
    refused = client.call("start")["message"]
    assert refused == "this run is the node's only one; run it with --managed to start it again"
    assert client.call("cancel")["success"]
    out, err = process.communicate(timeout=60)
    reported = json.loads(out)
    assert (process.returncode, reported["outcome"]) == (1, "canceled"), err
    assert reported["why"] == "canceled by operator (~/cancel)" and "node: /farm/near" in err


@pytest.mark.long
def test_a_managed_node_runs_the_mission_again_and_again_until_it_is_shut_down(
    run: Run, open_client: Callable[[str], Client]
) -> None:
    process = run("--node", "managed", "--managed", "--ros-args", "-r", "__node:=remapped")
    client = open_client("/remapped")
    client.await_status("it waits", lifecycle="unconfigured")
    client.activate()
    for _ in range(2):
        client.start()
        assert client.call("cancel")["success"]
        client.await_status("it is over", outcome="canceled")
    assert client.change("shutdown")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert out.count("canceled: canceled by operator (~/cancel)") == 2


@pytest.mark.long
def test_an_interrupt_cancels_what_runs_and_shuts_a_managed_node_down(
    run: Run, open_client: Callable[[str], Client]
) -> None:
    process = run("--node", "interrupted", "--managed")
    client = open_client("/interrupted")
    client.await_status("it waits", lifecycle="unconfigured")
    client.activate()
    client.start()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "canceled: canceled by operator (shutdown)" in out


def test_arguments_that_ros_does_not_take_are_reported_at_once(run: Run) -> None:
    process = run("--ros-args", "-r", "nonsense")
    _, err = process.communicate(timeout=60)
    assert process.returncode == 2 and "ROS does not start with ['-r', 'nonsense']" in err, err


@pytest.mark.long
def test_parameters_of_a_launch_file_are_arguments_and_an_unknown_one_ends_the_command(
    run: Run, open_client: Callable[[str], Client], tmp_path: Path
) -> None:
    (tmp_path / "launch_params").write_text("/**:\n  ros__parameters:\n    speed: 2.5\n    use_sim_time: false\n")
    words = [
        "--journal",
        "given.journal",
        "--json",
        "--ros-args",
        "-r",
        "__node:=given",
        "--params-file",
        "launch_params",
    ]
    process = run("--node", *words)
    client = open_client("/given")
    client.await_status("it runs", mode="running")
    assert client.call("cancel")["success"]
    _, err = process.communicate(timeout=60)
    with read(tmp_path / "given.journal") as record:
        assert record.header.arguments == {"speed": 2.5}, err
    wrong = run("--node", "--ros-args", "-r", "__node:=wrong", "-p", "sped:=2.5")
    _, err = wrong.communicate(timeout=60)
    assert wrong.returncode == 2
    assert "parameter 'sped': the mission takes no argument 'sped'; did you mean 'speed'?" in err

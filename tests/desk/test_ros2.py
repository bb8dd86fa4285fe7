# SPDX-License-Identifier: Apache-2.0
"""The shipped mission over real ROS 2, the arm in another process: what is asked for is built, or refused at once."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.ros2 import open_connector
from rai_missions.journal import read
from rai_missions.replay.replay import replay
from tests.desk.episodes import DESK_MISSIONS
from tests.desk.test_desk import TWO
from tests.ros2 import load_quietly, on_ros, with_messages
from tests.tractor.ros2_processes import PATIENCE_S, Graph, Process, graph_in

MISSION, PROFILE = str(DESK_MISSIONS / "arrange.json"), str(DESK_MISSIONS / "robot.ros2.json")
CUBE_M = 0.044

pytestmark = [
    pytest.mark.drill,
    pytest.mark.sim,
    on_ros,
    with_messages("rai_missions_msgs"),
]


class Arm(Graph):
    """The desk and its mission, on a domain of their own."""

    def desk(self) -> Process:
        scene = json.dumps(TWO["scene"])
        started = self.start(
            "world", "desk", "--ros", "--speed", "4", "--no-camera", "--seed", "7", "--option", f"scene={scene}"
        )
        started.wait_for("^ready")
        return started

    def arrange(self, name: str, request: str) -> dict[str, Any]:
        """Run one request to its end; what was reported."""
        run = self.start(
            "run",
            MISSION,
            "--robot",
            PROFILE,
            "--no-operator",
            "--json",
            "--set",
            f"request={request}",
            "--journal",
            str(self.journal(name)),
        )
        status = run.ends()
        assert status in (0, 1), f"exit status {status}: {run.text}"
        reported: dict[str, Any] = json.loads(run.lines.all[-1])
        return reported

    def journal(self, name: str) -> Path:
        return self.folder / f"{name}.journal"

    def entered(self, name: str) -> list[str]:
        with read(self.journal(name)) as record:
            return [state for step in record.steps() for state in step.entered]

    def seen(self, monkeypatch: pytest.MonkeyPatch) -> dict[str, dict[str, Any]]:
        """The things as the camera reports them now, by name, to another node of the graph."""
        for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE", "ROS_LOG_DIR"):
            monkeypatch.setenv(name, self.environment[name])
        connector = open_connector({"domain_id": int(self.environment["ROS_DOMAIN_ID"])})
        connector.start()
        try:
            received: Inbox[Message] = Inbox(PATIENCE_S)
            connector.subscribe("/desk/objects", "std_msgs/msg/String", received)
            pictures = received.wait(bool, "a picture of the desk")
        finally:
            connector.stop()
        return {thing["name"]: thing for thing in json.loads(pictures[-1].data["data"])["things"]}


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Arm]:
    load_quietly()
    yield from graph_in(tmp_path, Arm)


def test_a_tower_is_refused_or_built_by_an_arm_in_another_process(graph: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    """One desk, two requests: the second begins where the first left it."""
    world = graph.desk()
    refused = graph.arrange("refused", "put the red cube inside the blue cube")
    assert (refused["outcome"], refused["state"]) == ("aborted", "refused"), world.text
    assert "moving" not in graph.entered("refused")
    built = graph.arrange("built", "put the red cube on the blue cube")
    assert (built["outcome"], built["state"]) == ("succeeded", "done"), world.text
    seen = graph.seen(monkeypatch)
    red, blue = seen["red_cube"], seen["blue_cube"]
    assert red["z"] - blue["z"] > CUBE_M / 2
    assert math.dist((red["x"], red["y"]), (blue["x"], blue["y"])) < 0.01
    again = replay(graph.journal("built"))
    assert again.holds, again.difference

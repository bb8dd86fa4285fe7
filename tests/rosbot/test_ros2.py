# SPDX-License-Identifier: Apache-2.0
"""The shipped patrol over ROS 2, with Nav2's action types and the house in another process."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rai_missions.connectors.connector import Connector, Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.ros2 import open_connector
from rai_missions.connectors.sound.wav import write_wav
from rai_missions.journal import read
from rai_missions.replay.replay import replay
from rai_missions.worlds.house.layout import PLACES
from tests.ros2 import load_quietly, on_ros, with_messages
from tests.tractor.ros2_processes import PATIENCE_S, ROOT, Graph, Process, graph_in
from tests.voice.conftest import needs_voice, quiet, spoken

ROSBOT = ROOT / "missions" / "rosbot"
MISSION, PROFILE = str(ROSBOT / "mission.json"), str(ROSBOT / "robot.ros2.json")
STATUS = "/navigate_to_pose/_action/status"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""Of action_msgs/msg/GoalStatus."""

pytestmark = [pytest.mark.sim, on_ros]
with_nav2 = with_messages("nav2_msgs")


class House(Graph):
    """The house and its patrol, on a domain of their own."""

    def house(self, *words: str, **options: Any) -> Process:
        given = [word for name, value in options.items() for word in ("--option", f"{name}={json.dumps(value)}")]
        started = self.start("world", "house", "--ros", "--speed", "6", "--no-camera", *words, *given)
        started.wait_for("^ready")
        return started

    def patrol(self, places: Sequence[str]) -> Process:
        waypoints = [{"x": x, "y": y, "yaw": yaw, "frame": "map"} for x, y, yaw in map(PLACES.__getitem__, places)]
        return self.start(
            "run",
            MISSION,
            "--robot",
            PROFILE,
            "--no-operator",
            "--json",
            "--set",
            f"waypoints={json.dumps(waypoints)}",
            "--journal",
            str(self.journal),
        )

    @property
    def journal(self) -> Path:
        return self.folder / "run.journal"

    @property
    def entered(self) -> list[str]:
        with read(self.journal) as record:
            return [name for step in record.steps() for name in step.entered]

    @contextmanager
    def listener(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[Connector]:
        """Someone else on the graph."""
        for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE", "ROS_LOG_DIR"):
            monkeypatch.setenv(name, self.environment[name])
        qos = {STATUS: {"durability": "latched"}}
        connector = open_connector({"domain_id": int(self.environment["ROS_DOMAIN_ID"]), "qos": qos})
        connector.start()
        try:
            yield connector
        finally:
            connector.stop()

    def goals(self, listener: Connector, wanted: list[int]) -> bool:
        """Wait until the navigation's server reports that its goals are so, the oldest first."""
        received: Inbox[Message] = Inbox(PATIENCE_S)
        close = listener.subscribe(STATUS, "action_msgs/msg/GoalStatusArray", received)
        received.wait(
            lambda all_: bool(all_) and [one["status"] for one in all_[-1].data["status_list"]] == wanted,
            f"goals whose status is {wanted}",
        )
        close()
        return True


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[House]:
    load_quietly()
    yield from graph_in(tmp_path, House)


@with_nav2
def test_the_patrol_succeeds_with_its_robot_in_another_process(graph: House, monkeypatch: pytest.MonkeyPatch) -> None:
    world = graph.house()
    run = graph.patrol(["kitchen", "living_room"])
    assert run.ends() == 0, run.text + world.text
    reported = json.loads(run.lines.all[-1])
    assert (reported["outcome"], reported["decisions"]) == ("succeeded", 0)
    assert graph.entered.count("visited") == 2
    with graph.listener(monkeypatch) as listener:
        assert graph.goals(listener, [SUCCEEDED] * 2)
    again = replay(graph.journal)
    assert again.holds, again.difference


@with_nav2
def test_leaving_a_state_while_it_navigates_cancels_the_goal_at_its_server(
    graph: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Someone pushes the button while it drives."""
    world = graph.house()
    with graph.listener(monkeypatch) as listener:
        driven: Inbox[Message] = Inbox(PATIENCE_S)
        listener.subscribe("/odom", "nav_msgs/msg/Odometry", driven)
        run = graph.patrol(["bedroom"])
        driven.wait(lambda all_: bool(all_) and speed(all_[-1]) > 0.2, "the robot to drive")
        listener.publish("/e_stop", "std_msgs/msg/Empty", {})
        assert run.ends() == 1, run.text + world.text
        reported = json.loads(run.lines.all[-1])
        assert (reported["outcome"], reported["state"]) == ("aborted", "stopped")
        assert graph.goals(listener, [CANCELED])
        driven.wait(lambda all_: speed(all_[-1]) < 0.02, "the robot to stop")


@with_nav2
@with_messages("rai_interfaces")
@needs_voice
@pytest.mark.drill
@pytest.mark.timeout(600)
def test_a_person_speaks_with_the_robot_all_in_processes_of_their_own(
    graph: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    """House, mission, ears and voice are four processes; the question is answered in sound, "stop" stops the base."""
    asked, spoken_back, profile = graph.folder / "asked.wav", graph.folder / "back.wav", graph.folder / "robot.json"
    write_wav(asked, quiet(3.0) + spoken("Stop.", "rms") + quiet(6.0) + spoken("What are you doing?") + quiet(1.0))
    robot = json.loads(Path(PROFILE).read_text())
    robot["conversation"]["begins"] = "at_once"
    del robot["identity"]
    profile.write_text(json.dumps(robot))
    world = graph.house("--speed", "1")
    with graph.listener(monkeypatch) as listener:
        driven: Inbox[Message] = Inbox(PATIENCE_S)
        listener.subscribe("/odom", "nav_msgs/msg/Odometry", driven)
        run = graph.start(
            "run",
            str(ROSBOT / "assist.json"),
            "--robot",
            str(profile),
            "--node",
            "--talk",
            "--set",
            "task=go",
            "--set",
            "place=pantry",
            "--journal",
            str(graph.journal),
        )
        run.wait_for("start navigate")
        voice = graph.start("voice", str(asked), "--ros", "-o", str(spoken_back))
        run.wait_for(r"person voice \(topic\): [Ss]top")
        driven.wait(lambda all_: speed(all_[-1]) < 0.02, "the robot to stop")
        assert not run.is_over, run.text + world.text
        voice.wait_for(r"What are you doing\?")
        voice.wait_for(r"robot \(whole\): .*paused")
        voice.signal(signal.SIGINT)
        assert voice.ends() == 0, voice.text
        run.signal(signal.SIGINT)
        assert run.ends() == 1, run.text
    reader = graph.start("listen", str(spoken_back))
    assert reader.ends() == 0
    assert "paused" in reader.text, reader.text


def speed(odometry: Message) -> float:
    return float(odometry.data["twist"]["twist"]["linear"]["x"])


@with_nav2
def test_recoveries_that_fail_abort_the_goal_and_a_decision_is_made(
    graph: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = graph.house(blocked=["study_pantry"], recoveries=1)
    run = graph.patrol(["pantry"])
    assert run.ends() == 1, run.text + world.text
    reported = json.loads(run.lines.all[-1])
    assert (reported["outcome"], reported["state"]) == ("failed", "incomplete")
    with graph.listener(monkeypatch) as listener:
        assert graph.goals(listener, [ABORTED] * 3)


def test_without_nav2s_types_it_reports_at_once_how_to_get_them() -> None:
    """Nothing is started: the types are missed before the robot is looked for."""
    hidden = "import sys; sys.modules['nav2_msgs'] = None; from rai_missions.cli.main import main; sys.exit(main(sys.argv[1:]))"  # noqa: E501
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", hidden, "run", MISSION, "--robot", PROFILE, "--no-operator"],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 2
    printed = [line for line in done.stderr.splitlines() if "robot.ros2.json: /" in line]
    assert [line.split("robot.ros2.json: ")[1].split(":")[0] for line in printed] == [
        "/actions/navigate/type",
        "/actions/dock/type",
    ]
    assert all(
        line.endswith(
            "no ROS package 'nav2_msgs' on this machine; source a ROS 2 that has it (Nav2), "
            "or build it in a checkout: make ros-interfaces"
        )
        for line in printed
    )

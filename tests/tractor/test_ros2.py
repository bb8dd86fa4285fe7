# SPDX-License-Identifier: Apache-2.0
"""The shipped mission over ROS 2, unchanged, with the world in another process and nothing but the command line."""

from __future__ import annotations

import importlib.util
import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.check import check
from rai_missions.connectors.ros2 import open_connector
from rai_missions.mission.files import load
from rai_missions.profile import load_profile, missing
from rai_missions.replay.replay import replay
from tests.ros2 import load_quietly, on_ros
from tests.tractor.ros2_processes import TRACTOR, Graph, answers, graph_in

over_ros = [pytest.mark.sim, on_ros]
LIVELY = {"alleys": 2, "length_m": 14, "obstacles": ["branch", "person"]}
UNHURRIED = "1"
"""Where many decisions are compared: a busy machine must not make the mission late by the world's time."""
with_each_profile = pytest.mark.parametrize("profile", ["robot.ros2.json", "robot.nav2.json"])


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    yield from graph_in(tmp_path, Graph)


def skip_what_is_not_here(profile: str) -> None:
    if "nav2" in profile and importlib.util.find_spec("nav2_msgs") is None:
        pytest.skip("nav2_msgs is not installed: make ros-interfaces")


@with_each_profile
def test_a_profile_has_all_that_the_mission_uses(profile: str) -> None:
    mission = load(TRACTOR / "mission.json")
    assert list(check(mission)) == []
    assert missing(mission, load_profile(TRACTOR / profile)) == ()


def test_the_profile_for_ros_2_needs_nothing_that_is_not_on_pypi_and_the_other_differs_in_that_alone() -> None:
    plain, nav2 = (json.loads((TRACTOR / f"robot.{name}.json").read_text()) for name in ("ros2", "nav2"))
    assert "nav2_msgs" not in json.dumps(plain)
    for profile in (plain, nav2):
        for word in ("name", "about"):
            del profile[word]
        for action in ("cross", "go_home"):
            del profile["actions"][action]
    assert plain == nav2


class TestOnRos:
    pytestmark = over_ros

    @pytest.mark.long
    @with_each_profile
    def test_it_drives_over_what_is_low_to_the_end_of_the_alley(self, graph: Graph, profile: str) -> None:
        skip_what_is_not_here(profile)
        world = graph.world(speed="2", alleys=1, length_m=14, obstacles=["branch"])
        mission = graph.run("--json", robot=TRACTOR / profile)
        assert mission.ends() == 0, mission.text + world.text
        reported = json.loads(mission.lines.all[-1])
        assert (reported["outcome"], reported["state"]) == ("succeeded", "done")
        assert answers(Path(reported["journal"])) == ["drive_over"]
        assert replay(reported["journal"]).holds
        world.wait_for("passed: True")
        world.wait_for("alleys_driven: 1")
        world.signal(signal.SIGINT)
        assert world.ends() == 0, world.text

    @pytest.mark.drill
    def test_the_same_mission_takes_the_same_answers_to_the_same_end_as_in_one_process(self, graph: Graph) -> None:
        """A branch is driven over, a person is signalled to, as the rules state; no one is touched."""
        world = graph.world("--seed", "7", speed=UNHURRIED, **LIVELY)
        over_ros = graph.run("--json", alleys=2)
        assert over_ros.ends() == 0, over_ros.text + world.text
        reported = json.loads(over_ros.lines.all[-1])
        assert (reported["outcome"], reported["state"]) == ("succeeded", "done")
        again = replay(reported["journal"])
        assert again.holds and again.outcome == "succeeded", again.difference
        taken = answers(Path(reported["journal"]))
        world.wait_for("alleys_driven: 2")
        world.signal(signal.SIGINT)
        assert world.ends() == 0, world.text
        assert "touched_living: True" not in world.text

        profile = json.loads((TRACTOR / "robot.sim.json").read_text())
        profile["connector"] |= {"seed": 7, **LIVELY}
        robot = graph.folder / "robot.json"
        robot.write_text(json.dumps(profile | {"identity": ""}))
        in_process = graph.run("--json", alleys=2, robot=robot)
        assert in_process.ends() == 0, in_process.text
        assert json.loads(in_process.lines.all[-1])["outcome"] == "succeeded"
        assert taken == answers(Path(reported["journal"])) == ["drive_over", "signal"]

    @pytest.mark.long
    def test_a_world_that_is_killed_ends_the_run_which_states_why(self, graph: Graph) -> None:
        world = graph.world(alleys=1, obstacles=["none"])
        mission = graph.run(mission=graph.mission(cancel_s=0.5))  # no one is there to confirm it
        world.wait_for("state: DRIVING")
        world.signal(signal.SIGKILL)
        assert mission.ends() == 1, mission.text
        assert "aborted: 'stopped' was reached" in mission.text
        assert "because not touched_living is fresh" in mission.text, "what was no longer received is named there"
        assert replay(graph.folder / "run.journal").holds

    def test_an_e_stop_from_a_third_process_stops_the_tractor(
        self, graph: Graph, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        world = graph.world(alleys=1, obstacles=["none"])
        mission = graph.run()
        world.wait_for("state: DRIVING")
        for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE", "ROS_LOG_DIR"):
            monkeypatch.setenv(name, graph.environment[name])
        load_quietly()
        button = open_connector({"domain_id": int(graph.environment["ROS_DOMAIN_ID"])})
        button.start()
        try:
            button.publish("/tractor1/e_stop", "std_msgs/msg/Empty", {})
            assert mission.ends() == 1
        finally:
            button.stop()
        assert "aborted: 'stopped' was reached" in mission.text, mission.text
        world.wait_for("state: STOPPED")

    @pytest.mark.drill
    @with_each_profile
    def test_it_drives_over_what_is_low_and_comes_home_where_an_alley_stays_blocked(
        self, graph: Graph, profile: str
    ) -> None:
        """The two actions, composed of plain services, or with servers where the types of Nav2 are known."""
        skip_what_is_not_here(profile)
        world = graph.world(speed=UNHURRIED, alleys=2, length_m=14, obstacles=["branch", "log"])
        mission = graph.run(alleys=2, robot=TRACTOR / profile)
        assert mission.ends() == 1, mission.text
        assert "failed: 'unfinished_home' was reached" in mission.text, mission.text + world.text
        assert answers(graph.folder / "run.journal") == ["drive_over", "replan"]
        assert "passed: True" in world.text
        assert world.lines.all[-1].endswith("at_home: True") or "at_home: True" in world.text.split("FINISHED")[-1]

    def test_a_world_that_does_not_run_is_missed_by_name_and_one_learns_how_to_start_it(self, graph: Graph) -> None:
        mission = graph.run(mission=graph.mission(ready_s=0.5))
        assert mission.ends() == 2
        last = mission.lines.all[-1]
        assert last.startswith("rai-missions run: the robot has not reported within 0.5 s: alleys_driven, at_home, ")
        assert "rai-missions world orchard --ros" in last

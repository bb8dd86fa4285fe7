# SPDX-License-Identifier: Apache-2.0
"""`rai-missions world`: what it reports, how it ends, and what is wrong when it does not begin."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from tests.ros2 import ABSENT, on_ros
from tests.tractor.ros2_processes import Graph, graph_in


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    yield from graph_in(tmp_path, Graph)


@pytest.mark.long
@on_ros
@pytest.mark.sim
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_states_what_it_serves_and_ends_in_good_order(graph: Graph, number: signal.Signals) -> None:
    world = graph.world("--no-camera", alleys=1, obstacles=["none"])
    reported = world.text
    domain = graph.environment["ROS_DOMAIN_ID"]
    assert reported.startswith(f"orchard on ROS 2, domain {domain}: 4 simulated seconds to one of the wall\n")
    assert "  service  /tractor1/continue (std_srvs/srv/Trigger)" in reported
    assert "  topic    /clock (rosgraph_msgs/msg/Clock)" in reported
    assert "/tractor1/camera_image_color" not in reported
    for action in ("/navigate_to_pose", "/tractor1/cross"):
        assert (
            f"  action   {action} (nav2_msgs/action/" in reported or f"  left out {action}: no ROS package" in reported
        )
    world.signal(number)
    assert world.ends() == 0, world.text
    assert world.lines.all[-1].endswith(" s  ended")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["orchard"], "name where the world is to run: 'rai-missions world orchard --ros' puts it on the ROS graph"),
        (["orchard", "--ros", "--option", "alleys"], "--option alleys: write KEY=VALUE"),
        (["orchrd", "--ros"], "there is no world 'orchrd'; did you mean 'orchard'?"),
        (["orchard", "--ros", "--option", "trees=5"], "the world 'orchard' has no option 'trees'; there are: seed, "),
        (["orchard", "--ros", "--option", "obstacles=cow"], "obstacles: 'cow' is no list; give a kind for"),
        (["orchard", "--ros", "--option", "alleys=two"], "the world 'orchard' cannot be opened with alleys=\"two\": "),
        (["orchard", "--ros", "--domain", "999"], "connector/domain_id: 999 is no ROS domain; one goes from 0 to 232"),
    ],
)
def test_what_is_at_fault_is_reported_in_a_sentence(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    if "--ros" in words and ABSENT:
        pytest.skip("ROS 2 is not installed")
    assert main(["world", *words]) == 2
    assert capsys.readouterr().err.startswith(f"rai-missions world: {sentence}")


@pytest.mark.parametrize("pace", ["0", "-1", "nan", "fast"])
def test_a_pace_is_a_number_above_zero_or_max(pace: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["world", "orchard", "--ros", f"--speed={pace}"])
    assert end.value.code == 2
    assert f"{pace!r} is no speed; give a positive number such as 5, or max" in capsys.readouterr().err


def test_without_rclpy_one_sentence_states_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main(["world", "orchard", "--ros"]) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    assert "needs rclpy, which does not load" in reported.err
    assert "pip install '.[ros]'" in reported.err
    assert "source /opt/ros/jazzy/setup.bash" in reported.err

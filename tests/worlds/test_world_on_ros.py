# SPDX-License-Identifier: Apache-2.0
"""A world on a ROS graph of its own: what others see of it from the first moment, and whom it does not be next to."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.cli.doctor.robot import reach
from rai_missions.profile import load_profile
from tests.ros2 import on_ros
from tests.tractor.ros2_processes import TRACTOR, Graph, graph_in

pytestmark = on_ros


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    yield from graph_in(tmp_path, Graph)


def test_the_object_finder_is_a_process_that_is_ready_and_ends_on_a_signal(graph: Graph) -> None:
    words = [sys.executable, "-m", "rai_missions.worlds.perception"]
    finder = subprocess.Popen(words, env=graph.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        assert finder.stdout is not None
        assert finder.stdout.readline() == "ready: /look_for starts it, /seen has what it sees\n"
        finder.send_signal(signal.SIGINT)
        assert finder.wait(30.0) == 0
    finally:
        finder.kill()
        finder.communicate()


@pytest.mark.long
def test_all_that_its_profile_names_is_there_at_once_and_a_second_world_is_refused(graph: Graph) -> None:
    world, missing, within_s = graph.world(speed="1"), ["not looked for yet"], 1.0
    while missing and within_s < 30.0:  # on a busy machine two processes take longer to find each other
        within_s *= 2
        found = reach(load_profile(TRACTOR / "robot.ros2.json"), graph.environment, within_s=within_s)
        missing = [each.what for each in found if each.status == "missing"]
    assert missing == []

    second = graph.start("world", "house", "--ros", "--no-camera")
    assert second.ends() == 2
    assert "another world or robot is there and publishes /clock" in second.text
    assert "--domain N here, and ROS_DOMAIN_ID=N" in second.text
    assert not world.is_over

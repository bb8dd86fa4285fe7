# SPDX-License-Identifier: Apache-2.0
"""The last step of the tutorial: its mission on its ROS 2 robot, in processes of their own, as its page shows."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.ros2 import QUICK_DISCOVERY, lock_free_domain, on_ros

TUTORIAL = Path(__file__).parents[2] / "docs/tutorial"


@pytest.mark.long
@on_ros
@pytest.mark.timeout(120)
def test_the_mission_succeeds_on_the_robot_of_the_last_step(tmp_path: Path) -> None:
    domain, lock = lock_free_domain()
    own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    environment = {**os.environ, **own, "FASTRTPS_DEFAULT_PROFILES_FILE": str(QUICK_DISCOVERY)}
    robot = subprocess.Popen([sys.executable, TUTORIAL / "6_ros/ros_robot.py", "40"], env=environment)
    command = [
        Path(sys.executable).with_name("rai-missions"), "run", TUTORIAL / "5_proof/mission.json", "--robot",
        TUTORIAL / "6_ros/robot.ros.json", "--no-operator", "--json", "--journal", tmp_path / "run.journal",
    ]  # fmt: skip
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False, env=environment)
    finally:
        robot.terminate()
        robot.wait(20)
        lock.close()
    assert ran.returncode == 0, ran.stderr
    assert "'done' was reached" in ran.stdout

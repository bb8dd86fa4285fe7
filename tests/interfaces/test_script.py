# SPDX-License-Identifier: Apache-2.0
"""What `scripts/build_interfaces.sh` reports where something is missing, and where there is nothing for it to do."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts" / "build_interfaces.sh"
pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the wheels of ROS 2 are for Linux")


def ran(*arguments: str, **environment: str) -> tuple[int, str]:
    """Exit status, and what was reported."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "AMENT_", "VENV"))}
    done = subprocess.run(
        [SCRIPT, *arguments], env={**kept, **environment}, capture_output=True, text=True, check=False, timeout=120
    )
    return done.returncode, done.stderr


@pytest.fixture
def empty_venv(tmp_path: Path) -> Path:
    """A Python, and nothing else."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(sys.executable)
    (tmp_path / "venv" / "bin").mkdir(parents=True)
    (tmp_path / "venv" / "bin" / "python").symlink_to("/bin/false")
    return tmp_path / "venv"


def test_a_check_reports_what_is_not_built_and_who_builds_it(empty_venv: Path) -> None:
    code, reported = ran("--check", "nav2_msgs", VENV=str(empty_venv))
    assert code == 1
    assert reported == "interfaces: nav2_msgs: absent (8 interfaces)\ninterfaces: make ros-interfaces builds them\n"


def test_a_package_brings_those_of_ours_that_it_is_made_of(empty_venv: Path) -> None:
    _, reported = ran("--check", "rai_interfaces", "tf2_msgs", VENV=str(empty_venv))
    packages = [line.split(":")[1].strip() for line in reported.splitlines()[:-1]]
    assert packages == ["vision_msgs", "rai_interfaces", "tf2_msgs"]


def test_without_the_wheels_it_states_how_to_get_them(empty_venv: Path) -> None:
    if not all(map(shutil.which, ("cmake", "g++"))):
        pytest.skip("no cmake or no g++ here")
    code, reported = ran("nav2_msgs", VENV=str(empty_venv))
    assert code == 1 and "the ROS 2 wheels are not in" in reported and "make middleware" in reported


def test_without_a_compiler_it_states_how_to_get_one(tmp_path: Path, empty_venv: Path) -> None:
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in ("bash", "dirname", "ls", "xargs", "find", "sort", "wc", "cat", "basename", "realpath", "env"):
        (tools / name).symlink_to(str(shutil.which(name)))
    code, reported = ran("nav2_msgs", VENV=str(empty_venv), PATH=str(tools))
    assert code == 1 and "cmake is missing" in reported and "apt-get install cmake g++" in reported


def test_with_a_sourced_ros_nothing_is_built_and_colcon_is_named(tmp_path: Path) -> None:
    share = tmp_path / "opt" / "share" / "nav2_msgs"
    share.mkdir(parents=True)
    (share / "package.xml").touch()
    code, reported = ran("nav2_msgs", ROS_DISTRO="jazzy", AMENT_PREFIX_PATH=str(tmp_path / "opt"))
    assert (code, reported) == (0, f"interfaces: nav2_msgs: in {tmp_path / 'opt'}\n")
    code, reported = ran("nav2_msgs", "tf2_msgs", ROS_DISTRO="jazzy", AMENT_PREFIX_PATH=str(tmp_path / "opt"))
    assert code == 1 and "colcon build --paths interfaces/tf2_msgs" in reported


def test_what_it_does_not_know_it_refuses_with_what_there_is() -> None:
    assert ran("--fast") == (1, "interfaces: no option --fast; there is: --check\n")
    code, reported = ran("nav3_msgs")
    assert code == 1 and "no package nav3_msgs in interfaces/; there are: nav2_msgs" in reported

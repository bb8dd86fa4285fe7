# SPDX-License-Identifier: Apache-2.0
"""colcon builds the package, installed and linked, and what `ros2 run` finds there runs."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.ros2 import on_ros

SCRIPT = Path(__file__).parents[2] / "scripts" / "try_ros_package.sh"


@on_ros
@pytest.mark.drill
@pytest.mark.timeout(900)
def test_a_workspace_builds_it_in_both_ways_and_runs_it() -> None:
    """Takes a minute, and colcon from a package index."""
    done = subprocess.run([SCRIPT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(" runs\n") == 2

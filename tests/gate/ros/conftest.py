# SPDX-License-Identifier: Apache-2.0
"""What the tests of the gate on ROS 2 need: loopback only, and a domain of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.agents.ros_domain import domain, open_ros
from tests.ros2 import skip_below

__all__ = ("domain", "open_ros")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    skip_below(Path(__file__).parent, items)

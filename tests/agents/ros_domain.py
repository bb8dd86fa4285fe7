# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the agents' tests on ROS 2: a domain that is named wherever a node starts, and connectors on it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.ros2 import QUICK_DISCOVERY, connectors, load_quietly, lock_free_domain

__all__ = ("domain", "open_ros")


@pytest.fixture(scope="session")
def domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """A ROS domain that is named wherever a node starts, so that other tests' domain is left as it is."""
    load_quietly()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(QUICK_DISCOVERY)
    os.environ.setdefault("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros-log")))
    number, lock = lock_free_domain()
    with lock:
        yield number


@pytest.fixture
def open_ros(domain: int) -> Iterator[Callable[..., Any]]:
    """Opens connectors, started; all are stopped after the test."""
    yield from connectors(domain_id=domain)

# SPDX-License-Identifier: Apache-2.0
"""The rig of the tests of ROS 2: loopback only, a domain of their own, quick discovery, a peer process."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.connectors.ros2.peer_process import Peer
from tests.ros2 import ABSENT, QUICK_DISCOVERY, connectors, load_quietly, lock_free_domain, skip_below

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    skip_below(HERE, items)


@pytest.fixture(scope="session", autouse=True)
def ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The environment that every node of this process and of its peers reads."""
    if ABSENT:
        yield
        return
    load_quietly()
    domain, lock = lock_free_domain()
    os.environ.update(
        ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
        ROS_DOMAIN_ID=str(domain),
        FASTRTPS_DEFAULT_PROFILES_FILE=str(QUICK_DISCOVERY),
        ROS_LOG_DIR=str(tmp_path_factory.mktemp("ros-log")),
    )
    with lock:
        yield


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """No process but this one is found."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")


@pytest.fixture
def open_ros(ros: None) -> Iterator[Callable[..., Any]]:
    """Opens connectors, started; all are stopped after the test."""
    yield from connectors(discovery_s=30.0)  # on a busy machine


@pytest.fixture(scope="module")
def ours(ros: None) -> Iterator[Any]:
    """A connector that several tests use: what is on its graph is known, so that its goals are sent at once."""
    from rai_missions.connectors.ros2 import open_connector

    made = open_connector({"discovery_s": 30.0})
    made.start()
    yield made
    made.stop()


@pytest.fixture(scope="module")
def peer_of_module(ros: None) -> Iterator[Peer]:
    """A process for the tests of one module, so that goals which another module's tests lost do not run in it."""
    with Peer("peer") as started:
        yield started


@pytest.fixture
def peer(peer_of_module: Peer) -> Peer:
    """A process of plain rclpy that serves an action, services and topics; it runs as the test begins."""
    return peer_of_module.still_runs()


@pytest.fixture
def own_peer(ros: None) -> Iterator[Peer]:
    """Such a process for one test, which may kill it."""
    with Peer(f"own_{uuid.uuid4().hex[:6]}") as started:
        yield started

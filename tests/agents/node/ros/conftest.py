# SPDX-License-Identifier: Apache-2.0
"""What the tests of the node on ROS 2 stand on: loopback only, and a domain of their own."""

from __future__ import annotations

import importlib
import os
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import Setting
from rai_missions.agents.node import MissionNode
from tests.agents.node.scenes import Client, mission, robot
from tests.connectors.ros2.conftest import ABSENT, lock_free_domain
from tests.connectors.ros2.conftest import HERE as ROS_TESTS

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if ABSENT:
        reason = f"ROS 2 is not installed ({', '.join(ABSENT)}): pip install -e '.[ros,ros-test]'"
        for item in items:
            if HERE in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=reason))


@pytest.fixture(scope="session")
def domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """A ROS domain that is named wherever a node starts, so that other tests' domain is left as it is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a parser that ROS brings along uses a deprecated module
        importlib.import_module("rosidl_generator_py")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(ROS_TESTS / "quick_discovery.xml")
    os.environ.setdefault("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros-log")))
    number, lock = lock_free_domain()
    with lock:
        yield number


@pytest.fixture
def open_ros(domain: int) -> Iterator[Callable[..., Any]]:
    """Opens connectors, started; all are stopped after the test."""
    from rai_missions.connectors.ros2 import open_connector

    opened: list[Any] = []

    def open_one(**options: Any) -> Any:
        opened.append(open_connector({"domain_id": domain, **options}))
        opened[-1].start()
        return opened[-1]

    yield open_one
    for connector in opened:
        connector.stop()


@pytest.fixture
def open_node(domain: int) -> Iterator[Callable[..., MissionNode]]:
    """Opens nodes that run `errand` on the stand-in robot; all are stopped after the test."""
    opened: list[MissionNode] = []

    def open_one(name: str, **words: Any) -> MissionNode:
        setting = Setting(mission(), robot({"kind": "ros2", "domain_id": domain, "discovery_s": 1.0}, f"/{name}_robot"))
        opened.append(MissionNode(setting, name, **words))
        opened[-1].run()
        return opened[-1]

    yield open_one
    for node in opened:
        node.stop()


@pytest.fixture
def open_client(open_ros: Callable[..., Any]) -> Callable[..., Client]:
    """A client in a context of its own; a late one hears what was latched."""

    def open_one(path: str) -> Client:
        latched = {"durability": "latched", "depth": 1}
        names = ("status", "control", "mission_status")
        return Client(open_ros(qos={f"{path}/{name}": latched for name in names}), path)

    return open_one

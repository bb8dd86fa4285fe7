# SPDX-License-Identifier: Apache-2.0
"""The rig of the tests of the node on ROS 2: loopback only, and a domain of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig
from rai_missions.node import MissionNode
from tests.agents.ros_domain import domain, open_ros
from tests.node.scenes import Client, mission, robot
from tests.ros2 import skip_below

__all__ = ("domain", "open_client", "open_node", "open_ros")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    skip_below(Path(__file__).parent, items)


@pytest.fixture
def open_node(domain: int) -> Iterator[Callable[..., MissionNode]]:
    """Opens nodes that run `errand` on the fake robot; all are stopped after the test."""
    opened: list[MissionNode] = []

    def open_one(name: str, **words: Any) -> MissionNode:
        setting = RunConfig(
            mission(), robot({"kind": "ros2", "domain_id": domain, "discovery_s": 1.0}, f"/{name}_robot")
        )
        opened.append(MissionNode(setting, name, **words))
        opened[-1].run()
        return opened[-1]

    yield open_one
    for node in opened:
        node.stop()


@pytest.fixture
def open_client(open_ros: Callable[..., Any]) -> Callable[..., Client]:
    """A client in a context of its own; a late one receives what was latched."""

    def open_one(path: str) -> Client:
        latched = {"durability": "latched", "depth": 1}
        names = ("status", "control", "mission_status")
        return Client(open_ros(qos={f"{path}/{name}": latched for name in names}), path)

    return open_one

# SPDX-License-Identifier: Apache-2.0
"""A node over a connector in this process, and a client of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from rai_missions.agents.mission import RunConfig
from rai_missions.connectors.local import LocalConnector
from rai_missions.node import MissionNode
from rai_missions.node.transport import Carrier
from tests.node.scenes import Client, FakeRobot, mission, robot


class Scene(NamedTuple):
    node: MissionNode
    client: Client
    robot: FakeRobot


@pytest.fixture
def open_scene() -> Iterator[Callable[..., Scene]]:
    """Opens a node, a robot and a client on one connector."""
    opened: list[tuple[MissionNode, LocalConnector]] = []

    def open_one(name: str = "errand", *, typed: bool = False, **words: Any) -> Scene:
        connector = LocalConnector()
        connector.start()
        profile = robot({"kind": "local"})
        setting = RunConfig(words.pop("mission", mission()), profile, answerers=words.pop("answerers", {}))
        node = MissionNode(setting, name, carrier=Carrier(connector, True, typed), **words)
        opened.append((node, connector))
        scene = Scene(node, Client(connector, node.name.path), FakeRobot(connector))
        node.run()
        return scene

    yield open_one
    for node, connector in opened:
        node.stop()
        connector.stop()


@pytest.fixture
def scene(open_scene: Callable[..., Scene]) -> Scene:
    """A node that waits to be configured."""
    return open_scene()

# SPDX-License-Identifier: Apache-2.0
"""The robots that tools are tried on: in process, over ROS 2, over MQTT."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from rai_missions.connectors.connector import Connector, Data
from rai_missions.connectors.local import LocalConnector
from rai_missions.tools import Allowlist, Toolbox
from tests.connectors.ros2.conftest import ros
from tests.connectors.test_mqtt import ABSENT as NO_BROKER
from tests.connectors.test_mqtt import Broker
from tests.ros2 import ABSENT as NO_ROS

__all__ = ("ros",)

PATIENCE_S = 30.0


class ToolRig(NamedTuple):
    """A robot to try tools on, and its clock."""

    connector: Connector
    now: Callable[[], float]

    def box(self, **words: Any) -> Toolbox:
        return Toolbox(self.connector, Allowlist(**{"write": ("*",), **words}), now=self.now)


class RepeatingPublisher:
    """Publishes again and again, as sensors do, while it is entered."""

    def __init__(self, connector: Connector, topic: str, type_name: str, on_result: Callable[[], Data]) -> None:
        self._publish = lambda: connector.publish(topic, type_name, on_result())
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work)

    def _work(self) -> None:
        while not self._ended.wait(0.02):
            self._publish()

    def __enter__(self) -> RepeatingPublisher:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture(scope="module", params=["local", "ros2", "mqtt"])
def tried(request: pytest.FixtureRequest, ros: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ToolRig]:
    """Each kind of connector, started."""
    if request.param == "local":
        yield from started(LocalConnector(), time.monotonic)
    elif request.param == "ros2":
        if NO_ROS:
            pytest.skip(f"ROS 2 is not installed ({', '.join(NO_ROS)})")
        from rai_missions.connectors.ros2 import open_connector

        yield from started(open_connector({"discovery_s": 1.0}), time.time)
    else:
        if NO_BROKER:
            pytest.skip(f"no MQTT broker or client here: {' and '.join(NO_BROKER)}")
        from rai_missions.connectors.mqtt import open_connector as open_mqtt

        broker = Broker(tmp_path_factory.mktemp("broker"))
        yield from started(open_mqtt({"port": broker.port}), time.time)
        broker.stop()


def started(connector: Connector, now: Callable[[], float]) -> Iterator[ToolRig]:
    connector.start()
    yield ToolRig(connector, now)
    connector.stop()


@pytest.fixture
def local() -> Iterator[ToolRig]:
    yield from started(LocalConnector(), time.monotonic)

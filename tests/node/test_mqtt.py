# SPDX-License-Identifier: Apache-2.0
"""The same node over a real MQTT broker, against which nothing in it was written."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.agents.mission import RunConfig
from rai_missions.connectors.mqtt import open_connector
from rai_missions.errors import UsageError
from rai_missions.node import MissionNode
from tests.connectors.test_mqtt import Broker, needs_broker
from tests.node.scenes import Client, FakeRobot, mission, robot
from tests.node.test_node import revisions_rise


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    importlib.import_module("paho.mqtt.client")
    made = Broker(tmp_path)
    yield made
    made.stop()


@needs_broker
def test_a_client_runs_the_mission_over_mqtt(broker: Broker) -> None:
    connector = open_connector({"port": broker.port})
    connector.start()
    setting = RunConfig(mission(), robot({"kind": "mqtt", "port": broker.port}))
    node, client, fake_robot = MissionNode(setting), Client(connector, "/errand"), FakeRobot(connector)
    try:
        node.run()
        with pytest.raises(UsageError, match="another node is called /errand already"):
            MissionNode(setting).run()
        client.activate()
        client.start()
        assert client.command(command="post", event="go")["success"]
        fake_robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
        fake_robot.arrive()
        client.await_status("it is over", outcome="succeeded")
        revisions_rise(client)
    finally:
        node.stop()
        connector.stop()

# SPDX-License-Identifier: Apache-2.0
"""The same node over a real MQTT broker, against which nothing in it was written."""

from __future__ import annotations

import importlib
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.connectors.mqtt import open_connector
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.node import MissionNode
from rai_missions.runtime.clock import ContinuedClock, WallClock
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


@needs_broker
def test_a_run_that_was_cut_short_continues_on_a_node_over_its_broker(broker: Broker, tmp_path: Path) -> None:
    connector, killed = open_connector({"port": broker.port}), tmp_path / "killed"
    killed.mkdir()
    profile = robot({"kind": "mqtt", "port": broker.port})
    connector.start()

    def on_step(step: Step) -> None:
        if step.entered == ("waiting",):
            for file in tmp_path.glob("run.journal*"):
                shutil.copy(file, killed)
            cut.runner.cancel()

    late = ContinuedClock(WallClock(), 1000.0)
    with prepare(RunConfig(mission(), profile, clock=late, journal=tmp_path / "run.journal", on_step=on_step)) as cut:
        cut.runner.run()
    setting = RunConfig(mission(), resume=killed / "run.journal")
    node, client, fake_robot = MissionNode(setting, managed=False), Client(connector, "/errand"), FakeRobot(connector)
    try:
        node.run()
        with prepare(node.joined(setting)) as again:
            running = threading.Thread(target=node.attend(again.runner).run)
            running.start()
            client.await_status("it continues", mode="running")
            assert client.command(command="post", event="go")["success"]
            fake_robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
            fake_robot.arrive()
            client.await_status("what the robot reports is new", mode="succeeded")
            running.join()
    finally:
        node.stop()
        connector.stop()

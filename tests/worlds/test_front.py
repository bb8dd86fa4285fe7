# SPDX-License-Identifier: Apache-2.0
"""A world on a connector that others share: what is there, what is left out, and what time it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rai_missions.connectors.connector import ActionServer, Close, Data, Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError
from rai_missions.worlds import open_world
from rai_missions.worlds.front import CLOCK, Front, Stage


class Poor(LocalConnector):
    """A machine without the types of Nav2."""

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        _known(type_name)
        return super().offer(action, type_name, server)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        _known(type_name)
        super().publish(topic, type_name, message)


def _known(type_name: str) -> None:
    if type_name.startswith(("nav2_msgs/", "geometry_msgs/")):
        raise ConnectorError(f"no ROS package {type_name.partition('/')[0]!r} on this machine")


def staged(connector: LocalConnector, told: Callable[[str, Any], None] = lambda _n, _f: None) -> tuple[Front, Stage]:
    front = Front(connector, told)
    world = open_world("orchard", alleys=1, obstacles=["none"], camera=False)
    connector.start()
    world.open(front.as_connector())
    return front, Stage(world, front.as_connector())


def test_what_the_machine_has_no_types_for_is_left_out_and_the_rest_is_there() -> None:
    connector = Poor()
    front, stage = staged(connector)
    for _ in range(25):
        stage.step()
    assert front.left_out == {
        "/navigate_to_pose": "no ROS package 'nav2_msgs' on this machine",
        "/tractor1/cross": "no ROS package 'nav2_msgs' on this machine",
        "/tractor1/pose": "no ROS package 'geometry_msgs' on this machine",
    }
    assert front.actions == {}
    assert front.services["/tractor1/drive_over"] == "std_srvs/srv/Trigger"
    assert front.topics["/tractor1/state"] == "std_msgs/msg/String"
    assert "/tractor1/pose" not in front.topics


def test_the_time_is_said_after_each_step() -> None:
    connector, heard = LocalConnector(), list[Message]()
    connector.subscribe(CLOCK, "rosgraph_msgs/msg/Clock", heard.append)
    _, stage = staged(connector)
    for _ in range(30):
        stage.step()
    told = [message.data["clock"]["sec"] + message.data["clock"]["nanosec"] / 1e9 for message in heard]
    assert told == [round(0.05 * number, 9) for number in range(1, 31)]
    assert stage.at == 1.5


def test_a_plain_fact_is_told_once_for_each_time_it_changes() -> None:
    said: list[tuple[str, Any]] = []
    _, stage = staged(LocalConnector(), lambda name, fact: said.append((name, fact)))
    for _ in range(60):
        stage.step()
    assert sorted(said) == [
        ("/tractor1/alleys_driven", 0),
        ("/tractor1/at_home", True),
        ("/tractor1/state", "CHANGING_PATH"),
        ("/tractor1/touched_living", False),
    ]

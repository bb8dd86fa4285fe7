# SPDX-License-Identifier: Apache-2.0
"""A world on a connector that others share: what is there, what is left out, and what time it is."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

import pytest

from rai_missions.connectors.connector import ActionServer, Close, ConnectorMode, Data, Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.bridge import CLOCK, PublishedWorld, TrackedConnector, taken_names


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


class Crowded(Poor):
    """A connector on which others are seen, by mode and name, and who reports of its own topics at once."""

    def __init__(self, others: Mapping[ConnectorMode, Mapping[str, int]] | None = None) -> None:
        super().__init__()
        self.others, self.seen = others or {}, dict[str, str]()

    def expect(self, mode: ConnectorMode, name: str, type_name: str) -> None:
        _known(type_name)
        self.seen[name] = type_name

    def offered(self, mode: ConnectorMode) -> Mapping[str, int]:
        return self.others.get(mode, {})


def staged(
    connector: LocalConnector,
    on_result: Callable[[str, Any], None] = lambda _n, _f: None,
    taken: Mapping[ConnectorMode, Collection[str]] | None = None,
) -> tuple[TrackedConnector, PublishedWorld]:
    front = TrackedConnector(connector, on_result, taken)
    world = open_world("orchard", alleys=1, obstacles=["none"], camera=False)
    connector.start()
    world.open(front)
    return front, PublishedWorld(world, front)


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


def test_the_time_is_reported_after_each_step() -> None:
    connector, received = LocalConnector(), list[Message]()
    connector.subscribe(CLOCK, "rosgraph_msgs/msg/Clock", received.append)
    _, stage = staged(connector)
    for _ in range(30):
        stage.step()
    results = [message.data["clock"]["sec"] + message.data["clock"]["nanosec"] / 1e9 for message in received]
    assert results == [round(0.05 * number, 9) for number in range(1, 31)]
    assert stage.at == 1.5


def test_a_plain_fact_is_reported_once_for_each_time_it_changes() -> None:
    lines: list[tuple[str, Any]] = []
    _, stage = staged(LocalConnector(), lambda name, fact: lines.append((name, fact)))
    for _ in range(60):
        stage.step()
    assert sorted(lines) == [
        ("/tractor1/alleys_driven", 0),
        ("/tractor1/at_home", True),
        ("/tractor1/state", "CHANGING_PATH"),
        ("/tractor1/touched_living", False),
    ]


def test_every_topic_is_seen_before_anything_was_published_on_it() -> None:
    connector = Crowded()
    front, _ = staged(connector)
    silent_at_first = {"/tractor1/passed", "/tractor1/crossing"}
    assert silent_at_first | {"/tractor1/state", CLOCK} <= connector.seen.keys()
    assert front.topics == connector.seen
    assert "/tractor1/pose" in front.left_out, "its type is not here"
    assert "/tractor1/obstacle" not in connector.seen, "no one sees one without a camera"


@pytest.mark.parametrize(
    ("mode", "name", "does"),
    [
        ("topics", CLOCK, "publishes"),
        ("topics", "/tractor1/passed", "publishes"),
        ("services", "/tractor1/continue", "serves"),
        ("actions", "/navigate_to_pose", "serves"),
    ],
)
def test_a_world_does_not_open_next_to_another_that_has_one_of_its_names(
    mode: ConnectorMode, name: str, does: str
) -> None:
    connector = Crowded({mode: {name: 1}})
    with pytest.raises(UsageError, match=f"another world or robot is there and {does} {name}: .* --domain N"):
        staged(connector, taken=taken_names(connector))


def test_anyone_who_only_waits_for_the_robot_is_no_company() -> None:
    connector = Crowded({"topics": {"/tractor2/state": 1}, "services": {"/mission/start": 1}})
    front, _ = staged(connector, taken=taken_names(connector))
    front.refuse_rivals()


def test_two_worlds_that_came_at_once_find_each_other_afterwards() -> None:
    connector = Crowded()
    front, _ = staged(connector)
    connector.others = {"services": {"/tractor1/continue": 1}, "topics": {"/tractor1/state": 1}}
    front.refuse_rivals()
    connector.others = {"services": {"/tractor1/continue": 2}}
    with pytest.raises(UsageError, match="serves /tractor1/continue"):
        front.refuse_rivals()

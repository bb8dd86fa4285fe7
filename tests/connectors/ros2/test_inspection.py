# SPDX-License-Identifier: Apache-2.0
"""What is wrong with what the graph has under a name is found by looking, and named with its node and the remedy."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from rai_missions.connectors.connector import ConnectorMode, Hindrance, SupportsInspection
from rai_missions.connectors.contract import PatientServer
from tests.connectors.ros2.peer_process import FIBONACCI, TRIGGER

STRING, CLOCK = "std_msgs/msg/String", "rosgraph_msgs/msg/Clock"
Open = Callable[..., Any]


def found(connector: Any, count: int, *wanted: tuple[ConnectorMode, str, bool]) -> Sequence[Hindrance]:
    """What hinders, once there is so much of it and the nodes are known."""
    assert isinstance(connector, SupportsInspection)
    until, tick = time.monotonic() + 30.0, threading.Event()
    while len(hindrances := connector.hindrances(wanted)) != count or "not known" in str(hindrances):
        assert time.monotonic() < until, hindrances
        tick.wait(0.02)
    return hindrances


def test_two_servers_of_an_action_and_of_a_service_are_named_by_their_nodes(open_ros: Open) -> None:
    for node in ("left", "right"):
        robot = open_ros(node=node, namespace="/robots")
        robot.offer("/drive", FIBONACCI, PatientServer())
        robot.serve("/horn", TRIGGER, lambda _: {"success": True})
    hindrances = found(open_ros(), 2, ("actions", "/drive", False), ("services", "/horn", False))
    assert [(each.name, each.is_fatal) for each in hindrances] == [("/drive", True), ("/horn", True)]
    for each in hindrances:
        assert each.what.startswith("has 2 servers: ") and "/robots/left" in each.what and "/robots/right" in each.what
        assert each.remedy == "end all but one, or give each a namespace"


def test_one_server_and_a_topic_that_fits_hinder_nothing(open_ros: Open) -> None:
    robot, ours = open_ros(node="robot"), open_ros()
    robot.serve("/horn", TRIGGER, lambda _: {"success": True})
    robot.publish("/state", STRING, {"data": "ready"})
    until, tick = time.monotonic() + 30.0, threading.Event()
    while "/horn" not in ours.offered("services") or "/state" not in ours.offered("topics"):
        assert time.monotonic() < until
        tick.wait(0.02)
    assert not ours.hindrances([("services", "/horn", False), ("topics", "/state", False), ("topics", "/none", True)])


RELIABLE, LOSSY, LATCHED = {"reliability": "reliable"}, {"reliability": "best_effort"}, {"durability": "latched"}


@pytest.mark.parametrize(
    ("offered", "asked", "is_ours", "what"),
    [
        (LOSSY, RELIABLE, False, "is not received from /robot, which lacks 'reliable'"),
        ({}, LATCHED, False, "is not received from /robot, which lacks 'latched'"),
        (LATCHED, {}, True, "does not reach /robot, which asks for 'latched'"),
        (RELIABLE, LOSSY, True, "does not reach /robot, which asks for 'reliable'"),
    ],
)
def test_a_quality_that_does_not_fit_is_named_with_the_node(
    open_ros: Open, offered: dict[str, str], asked: dict[str, str], is_ours: bool, what: str
) -> None:
    robot = open_ros(node="robot", qos={"/state": offered})
    if is_ours:
        robot.subscribe("/state", STRING, lambda _: None)
    else:
        robot.publish("/state", STRING, {"data": "ready"})
    (only,) = found(open_ros(qos={"/state": asked}), 1, ("topics", "/state", is_ours))
    assert (only.what, only.remedy, only.is_fatal) == (what, "correct connector/qos//state or that node", True)


def test_a_latched_topic_that_is_read_as_another_warns(open_ros: Open) -> None:
    open_ros(node="robot", qos={"/state": {"durability": "latched"}}).publish("/state", STRING, {"data": "ready"})
    (only,) = found(open_ros(), 1, ("topics", "/state", False))
    assert not only.is_fatal and '"qos": {"/state": {"durability": "latched"}}' in only.remedy


def test_a_clock_that_is_missing_and_one_that_is_not_followed_are_named(open_ros: Open) -> None:
    (missing,) = found(open_ros(sim_time=True), 1)
    assert (missing.name, missing.is_fatal) == ("/clock", True) and "'sim_time'" in missing.what
    open_ros(node="simulation").publish("/clock", CLOCK, {"clock": {"sec": 1, "nanosec": 0}})
    (unused,) = found(open_ros(), 1)
    assert not unused.is_fatal and '"sim_time": true' in unused.remedy
    assert not found(open_ros(sim_time=True), 0)


@pytest.mark.parametrize(
    ("name", "arguments", "full"),
    [
        ("horn", ["-r", "horn/_action/status:=/elsewhere"], "/robots/left/horn"),
        ("horn", [], "/robots/left/horn"),
        ("~/horn", [], "/robots/left/ours/horn"),
        ("/horn", [], "/horn"),
        ("horn", ["-r", "horn:=/loud/horn"], "/loud/horn"),
        ("horn", ["-r", "__ns:=/right"], "/right/horn"),
        ("no name", [], "no name"),
        ("{none}/horn", [], "{none}/horn"),
    ],
)
def test_a_name_in_full_is_the_one_by_which_others_list_it(
    open_ros: Open, name: str, arguments: list[str], full: str
) -> None:
    from rai_missions.connectors.ros2.endpoints import servers_of_action

    ours = open_ros(node="ours", namespace="/robots/left", arguments=arguments)
    assert ours.resolved("topics", name) == ours.resolved("services", name) == full
    if not full.startswith("/"):
        assert ours.resolved("actions", name) == full
        return
    close = ours.serve(name, TRIGGER, lambda _: {"success": True})
    assert full in ours.listed("services")
    close()
    ours.offer(name, FIBONACCI, PatientServer())
    assert [ours.resolved("actions", name)] == [*ours.listed("actions")], "Jazzy remaps no action by its own name"
    runtime = ours._session.runtime
    servers = servers_of_action(runtime.node, name)
    until, tick = time.monotonic() + 30.0, threading.Event()
    while not runtime.ask(lambda: dict(servers()), {}):
        assert time.monotonic() < until, "its server is not found"
        tick.wait(0.02)


def test_a_connector_that_is_not_started_leaves_a_name_as_it_is(ros: None) -> None:
    from rai_missions.connectors.ros2 import open_connector

    assert open_connector({"namespace": "/robots"}).resolved("services", "horn") == "horn"

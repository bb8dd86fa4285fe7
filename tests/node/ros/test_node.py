# SPDX-License-Identifier: Apache-2.0
"""The node on the real rclpy: any client starts, watches, steers and answers a mission with standard messages alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.ros2.config import read_options
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.node import MissionNode
from rai_missions.node.node import LOOK_S
from rai_missions.node.prerequisites import readied
from rai_missions.profile import Robot
from tests.node.scenes import Client, FakeRobot, mission, robot
from tests.node.test_node import ORDERS, obeys, revisions_rise

OpenNode = Callable[..., MissionNode]
OpenClient = Callable[[str], Client]


@pytest.fixture
def errand(open_node: OpenNode, open_client: OpenClient) -> Client:
    """A client of an active node."""
    client = open_client(open_node("errand").name.path)
    client.activate()
    return client


def test_a_client_runs_the_mission_with_standard_messages(
    open_node: OpenNode, open_client: OpenClient, open_ros: Callable[..., Any]
) -> None:
    fake_robot = FakeRobot(open_ros(), "/whole_robot")
    client = open_client(open_node("whole").name.path)
    client.await_status("it waits", lifecycle="unconfigured", mode="idle")
    client.activate()
    client.start()
    assert client.command(command="post", event="go", by="Ann")["success"]
    fake_robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
    assert client.call("pause")["success"]
    fake_robot.asked.wait(lambda asked: asked == ["move", "halt"], "the robot halts")
    assert client.call("resume")["success"]
    fake_robot.asked.wait(lambda asked: asked == ["move", "halt", "move"], "the robot moves again")
    fake_robot.arrive()
    assert client.await_status("it is over", outcome="succeeded")["why"] == "'done' was reached, and there is true"
    client.steps.wait(lambda steps: any(step.get("outcome") == "succeeded" for step in steps), "the last step")
    revisions_rise(client)


@pytest.mark.parametrize("managed", [True, False], ids=["managed", "of one run"])
def test_a_profile_that_names_a_field_that_is_not_there_begins_no_run_of_a_node(domain: int, managed: bool) -> None:
    written = robot({"kind": "ros2", "domain_id": domain, "discovery_s": 1.0}).written()
    written["blackboard"]["there"]["field"] = "dta"
    setting = RunConfig(mission(), Robot.model_validate(written))
    node = MissionNode(setting, "misled", managed=managed)
    node.run()
    try:
        with pytest.raises(DefinitionError, match="/blackboard/there/field: a std_msgs/msg/Bool has no field 'dta'"):
            readied(setting) if managed else prepare(node.joined(setting))
    finally:
        node.stop()


def test_a_client_that_joins_late_receives_the_latest(errand: Client, open_client: OpenClient) -> None:
    errand.start()
    errand.call("pause")
    latest = errand.await_status("it is paused", mode="paused")
    late = open_client("/errand")
    assert late.await_status("the latest", revision=latest["revision"]) == latest
    assert late.holders.wait(bool, "who holds control") == ["autonomy"]


@given(orders=st.lists(st.sampled_from(ORDERS), min_size=2, max_size=6))
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_orders_are_taken_where_the_lifecycle_allows_them_and_refused_elsewhere(
    errand: Client, orders: list[str]
) -> None:
    obeys(errand, orders)
    revisions_rise(errand)


def test_the_standard_services_report_what_can_be_done(open_node: OpenNode, open_client: OpenClient) -> None:
    client = open_client(open_node("standard").name.path)
    kind = "lifecycle_msgs/srv/GetAvailableTransitions"
    reported = client.call("get_available_transitions", kind)["available_transitions"]
    assert [way["transition"] for way in reported] == [{"id": 1, "label": "configure"}, {"id": 5, "label": "shutdown"}]
    assert len(client.call("get_transition_graph", kind)["available_transitions"]) == 25
    assert len(client.call("get_available_states", "lifecycle_msgs/srv/GetAvailableStates")["available_states"]) == 11
    assert client.change(number=1) and client.state() == "inactive"
    assert not client.change(number=1) and not client.change("fly")


def test_diagnostics_report_how_the_mission_fares(errand: Client) -> None:
    received: Inbox[Message] = Inbox(30.0)
    errand.connector.subscribe("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", received)

    def states(level: int, message: str) -> Callable[[list[Message]], bool]:
        return lambda all_: bool(all_) and _first(all_[-1]) == (level, message)

    errand.start()
    received.wait(states(0, "running"), "it is well")
    errand.command(command="post", event="ask")
    received.wait(states(1, "question 1 waits for operator: Which way?"), "a person should look")
    errand.call("e_stop")
    received.wait(states(2, "aborted: e-stop by operator (~/e_stop)"), "it has failed")


def _first(message: Message) -> tuple[int, str]:
    status = message.data["status"][0]
    return status["level"], status["message"]


def test_a_second_node_of_the_same_name_is_refused(errand: Client, open_node: OpenNode) -> None:
    with pytest.raises(UsageError, match="another node is called /errand already"):
        open_node("errand")
    assert errand.state() == "active", "the first is left as it was"


def test_another_node_is_looked_for_until_one_that_is_there_was_found() -> None:
    assert read_options({}).discovery_s < LOOK_S


def test_a_malformed_command_is_answered_with_why(errand: Client) -> None:
    assert "an order is not understood" in errand.command("{")["why"]
    assert "characters is not read" in errand.command("x" * 100_000)["why"]

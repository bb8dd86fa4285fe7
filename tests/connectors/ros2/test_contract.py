# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 connector keeps the connectors' contract on the real rclpy, and its promises under any interleaving."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Connector, Report
from rai_missions.connectors.contract import ENDS, Heard, PatientServer, check_connector
from rai_missions.connectors.ros2 import open_connector

FIBONACCI = "test_msgs/action/Fibonacci"
MOVES = ("accepted", "rejected", "feedback", "succeeded", "failed", "canceled", "cancel_rejected", "cancel")


@pytest.mark.usefixtures("alone")
def test_it_keeps_the_contract() -> None:
    check_connector(lambda: open_connector({"discovery_s": 5.0}))


def test_it_is_a_connector() -> None:
    assert isinstance(open_connector({}), Connector)
    assert open_connector({}).modes == {"topics", "services", "actions"}


@pytest.fixture(scope="module")
def connector() -> Any:
    made = open_connector({"discovery_s": 30.0})
    made.start()
    yield made
    made.stop()


@given(moves=st.lists(st.sampled_from(MOVES), max_size=8), number=st.integers(min_value=0))
@settings(max_examples=40)
def test_whatever_both_sides_do_a_goal_has_one_end_and_it_is_the_servers(
    connector: Connector, moves: list[str], number: int
) -> None:
    server, reports, goal_id = PatientServer(), Heard[Report](), f"goal{number % 10**9}"
    close = connector.offer("/law/action", FIBONACCI, server)
    try:
        connector.send_goal("/law/action", FIBONACCI, {"order": 1}, goal_id=goal_id, report=reports)
        server.asked.wait(bool, "a goal was sent")
        for move in (*moves, "succeeded"):
            if move == "cancel":
                connector.cancel_goal(goal_id)
            else:
                server.say(goal_id, move)
        told = reports.wait(lambda all_: bool(all_) and all_[-1].said in ENDS, f"it has ended after {moves}")
    finally:
        close()
    said = [report.said for report in told]
    assert [each for each in said if each in ENDS] == said[-1:], f"{said} after {moves}"
    assert said.count("accepted") == (said[-1] != "rejected"), f"{said} after {moves}"
    first_end = next(move for move in (*moves, "succeeded") if move in ENDS)
    allowed = {first_end} | ({"failed"} if first_end in ("canceled", "rejected") else set())
    assert said[-1] in allowed, f"{said} after {moves}"
    assert {report.goal_id for report in told} == {goal_id}


@pytest.mark.usefixtures("alone")
def test_two_hundred_calls_at_once_are_all_answered(open_ros: Callable[..., Any]) -> None:
    connector, replies = open_ros(), Heard[Any]()
    connector.serve("/many", "std_srvs/srv/SetBool", lambda request: {"success": request["data"], "message": "m"})
    for index in range(200):
        connector.call("/many", "std_srvs/srv/SetBool", {"data": index % 2 == 0}, answered=replies)
    told = replies.wait(lambda all_: len(all_) == 200, "every call is answered")
    assert [reply.data["success"] for reply in told] == [index % 2 == 0 for index in range(200)]

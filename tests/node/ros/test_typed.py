# SPDX-License-Identifier: Apache-2.0
"""The types of `rai_missions_msgs` over the real rclpy, where `make ros-interfaces` has built them."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Report
from rai_missions.connectors.contract import Inbox
from rai_missions.node import MissionNode
from tests.node.scenes import Client, FakeRobot
from tests.ros2 import with_messages

PACKAGE = "rai_missions_msgs"
pytestmark = with_messages(PACKAGE)
ENDS = ("rejected", "succeeded", "failed", "canceled", "lost")


@pytest.fixture
def typed(open_node: Callable[..., MissionNode], open_client: Callable[[str], Client]) -> Client:
    client = open_client(open_node("typed").name.path)
    client.activate()
    return client


def send(client: Client, **goal: Any) -> tuple[str, Inbox[Report]]:
    reports: Inbox[Report] = Inbox(30.0)
    goal_id = uuid.uuid4().hex
    kind = f"{PACKAGE}/action/RunMission"
    client.connector.send_goal(f"{client.path}/run", kind, goal, goal_id=goal_id, on_report=reports)
    return goal_id, reports


def end_of(reports: Inbox[Report]) -> Report:
    return reports.wait(lambda all_: bool(all_) and all_[-1].status in ENDS, "the goal ends")[-1]


def test_a_goal_runs_the_mission(typed: Client, open_ros: Callable[..., Any]) -> None:
    fake_robot = FakeRobot(open_ros(), "/typed_robot")
    _, reports = send(typed, arguments='{"speed": 0.5}', by="Ann")
    typed.await_status("it runs", mode="running")
    posted = typed.call("post", f"{PACKAGE}/srv/Post", event="go", data="{}", by="Ann")
    assert posted == {"success": True, "message": ""}
    fake_robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
    fake_robot.arrive()
    end = end_of(reports)
    assert (end.status, end.data["outcome"], end.data["why"]) == (
        "succeeded",
        "succeeded",
        "'done' was reached, and there is true",
    )
    states = [report.data["state"] for report in reports.all if report.status == "feedback"]
    assert ["moving"] in states


def test_canceling_the_goal_cancels_the_mission(typed: Client) -> None:
    goal_id, reports = send(typed)
    typed.await_status("it runs", mode="running")
    typed.connector.cancel_goal(goal_id)
    end = end_of(reports)
    assert (end.status, end.data["outcome"]) == ("canceled", "canceled")
    typed.await_status("it is over", outcome="canceled", why="canceled by operator (~/run)")


def test_a_mission_that_another_client_stops_aborts_the_goal(typed: Client) -> None:
    _, reports = send(typed)
    typed.await_status("it runs", mode="running")
    assert typed.call("e_stop")["success"]
    end = end_of(reports)
    assert (end.status, end.data["outcome"]) == ("failed", "aborted")


def test_a_goal_that_cannot_be_is_rejected_and_the_reply_states_why(typed: Client) -> None:
    goal_id, reports = send(typed, arguments='{"sped": 1}')
    assert end_of(reports).status == "rejected"
    reported = typed.replies.wait(bool, "a reply")[-1]
    assert reported["id"] == goal_id and "the mission takes no argument 'sped'" in reported["why"]


def test_questions_and_control_have_types(typed: Client) -> None:
    statuses: Inbox[Message] = Inbox(30.0)
    steps: Inbox[Message] = Inbox(30.0)
    typed.connector.subscribe(f"{typed.path}/mission_status", f"{PACKAGE}/msg/MissionStatus", statuses)
    typed.connector.subscribe(f"{typed.path}/mission_step", f"{PACKAGE}/msg/Step", steps)
    typed.start()
    assert typed.call("post", f"{PACKAGE}/srv/Post", event="ask")["success"]
    reported = statuses.wait(lambda all_: bool(all_) and bool(all_[-1].data["questions"]), "a question")[-1].data
    (question,) = reported["questions"]
    assert reported["active"] == ["asking"] and [option["name"] for option in question["options"]] == ["left", "right"]
    assert typed.call("set_control", f"{PACKAGE}/srv/Control", to="agent")["success"]
    answer = {"number": question["number"], "option": "left", "run": reported["run"]}
    assert typed.call("answer", f"{PACKAGE}/srv/Answer", **answer)["success"]
    steps.wait(lambda all_: any(step.data["outcome"] == "aborted" for step in all_), "the last step")

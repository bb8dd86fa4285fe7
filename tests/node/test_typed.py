# SPDX-License-Identifier: Apache-2.0
"""The typed services and the action do what the JSON does; the types themselves are tried on ROS."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rai_missions.connectors.connector import Message, Report
from rai_missions.connectors.contract import Inbox
from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.decision import Offer, Question
from rai_missions.node.status_message import OpenQuestion, StatusMessage
from tests.node.conftest import Scene
from tests.node.scenes import mission

RUN = "rai_missions_msgs/action/RunMission"
MESSAGES = Path(__file__).parents[2] / "interfaces/rai_missions_msgs/msg"
GUIDE = Path(__file__).parents[2] / "docs/guide/ros2.md"


@pytest.fixture
def scene(open_scene: Callable[..., Scene]) -> Scene:
    made = open_scene(typed=True)
    made.client.activate()
    return made


def send(scene: Scene, goal_id: str = "g1", arguments: str = "") -> Inbox[Report]:
    reports: Inbox[Report] = Inbox(30.0)
    goal = {"arguments": arguments, "by": "Ann"}
    scene.client.connector.send_goal("/errand/run", RUN, goal, goal_id=goal_id, on_report=reports)
    return reports


def ended(reports: list[Report]) -> bool:
    return bool(reports) and reports[-1].status in ("succeeded", "failed", "canceled", "rejected")


def test_a_goal_runs_the_mission_and_its_result_reports_how_it_ended(scene: Scene) -> None:
    reports = send(scene, arguments='{"speed": 2}')
    scene.client.await_status("it runs", mode="running")
    assert scene.client.call("post", "rai_missions_msgs/srv/Post", event="go", data="{}", by="Ann")["success"]
    scene.robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
    reports.wait(lambda all_: all_[-1].data.get("state") == ["moving"], "the feedback reports it")
    scene.robot.arrive()
    reported = reports.wait(ended, "the goal ends")
    assert reported[0].status == "accepted" and reported[-1].status == "succeeded"
    assert (
        reported[-1].data["outcome"] == "succeeded"
        and reported[-1].data["why"] == "'done' was reached, and there is true"
    )
    states = [report.data["state"] for report in reported if report.status == "feedback"]
    assert ["waiting"] in states and ["moving"] in states
    revisions = [report.data["revision"] for report in reported if report.status == "feedback"]
    assert revisions == sorted(set(revisions))


def test_canceling_the_goal_cancels_the_mission(scene: Scene) -> None:
    reports = send(scene)
    scene.client.await_status("it runs", mode="running")
    scene.client.connector.cancel_goal("g1")
    last = reports.wait(ended, "the goal ends")[-1]
    assert (last.status, last.data["outcome"], last.data["why"]) == (
        "canceled",
        "canceled",
        "canceled by operator (~/run)",
    )


def test_a_mission_that_someone_else_cancels_aborts_the_goal(scene: Scene) -> None:
    reports = send(scene)
    scene.client.await_status("it runs", mode="running")
    assert scene.client.call("cancel")["success"]
    last = reports.wait(ended, "the goal ends")[-1]
    assert (last.status, last.data["outcome"]) == ("failed", "canceled")


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ("{", "arguments is not understood"),
        ('{"sped": 1}', "takes no argument 'sped'"),
        ("[]", "arguments is a JSON object"),
    ],
)
def test_a_goal_that_cannot_be_is_rejected_and_the_reply_reports_why(scene: Scene, arguments: str, why: str) -> None:
    assert send(scene, arguments=arguments).wait(ended, "it is rejected")[-1].status == "rejected"
    reported = scene.client.replies.wait(bool, "a reply")[-1]
    assert reported["id"] == "g1" and why in reported["why"]


def test_a_goal_that_may_still_move_the_robot_is_named(open_scene: Callable[..., Scene]) -> None:
    given = mission()
    moving = given.states["moving"].model_copy(update={"cancel_s": 0.1})
    scene = open_scene(typed=True, mission=given.model_copy(update={"states": {**given.states, "moving": moving}}))
    received: Inbox[Message] = Inbox(30.0)
    scene.client.connector.subscribe("/errand/mission_status", "rai_missions_msgs/msg/MissionStatus", received)
    scene.client.activate()

    def obey(word: str) -> None:
        scene.robot.asked(word)
        if word == "halt":
            raise RuntimeError("no brakes")

    scene.robot.obey = obey
    reports = send(scene)
    scene.client.await_status("it runs", mode="running")
    scene.client.command(command="post", event="go")
    scene.robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
    scene.client.connector.cancel_goal("g1")
    open_goals = [{"number": 1, "action": "move", "owner": "moving", "reason": "refused"}]
    last = reports.wait(ended, "the goal ends")[-1]
    assert (last.status, last.data["open_goals"]) == ("canceled", open_goals)
    received.wait(
        lambda all_: all_[-1].data["outcome"] == "canceled" and all_[-1].data["open_goals"] == open_goals, "so"
    )


def test_a_second_goal_is_rejected_while_a_mission_runs(scene: Scene) -> None:
    send(scene)
    scene.client.await_status("it runs", mode="running")
    assert send(scene, "g2").wait(ended, "it is rejected")[-1].status == "rejected"
    scene.client.await_status("the first continues", mode="running")


def test_questions_are_answered_by_a_service(scene: Scene) -> None:
    received: Inbox[Message] = Inbox(30.0)
    scene.client.connector.subscribe("/errand/mission_status", "rai_missions_msgs/msg/MissionStatus", received)
    scene.client.start()
    scene.client.command(command="post", event="ask")
    reported = received.wait(lambda all_: bool(all_) and bool(all_[-1].data["questions"]), "the question is published")
    (question,) = reported[-1].data["questions"]
    answer = {"number": question["number"], "option": "left", "by": "Ann"}
    refused = scene.client.call("answer", "rai_missions_msgs/srv/Answer", **answer, parameters="[1")
    assert not refused["success"] and refused["message"].startswith("parameters is not understood")
    late = scene.client.call("answer", "rai_missions_msgs/srv/Answer", **answer, parameters="", run="yesterday")
    assert not late["success"] and "was asked in another run, yesterday" in late["message"]
    answer["run"] = reported[-1].data["run"]
    assert scene.client.call("answer", "rai_missions_msgs/srv/Answer", **answer, parameters="")["success"]
    scene.client.await_status("it is over", outcome="aborted")


def test_control_is_asked_for_by_a_service(scene: Scene) -> None:
    scene.client.start()
    assert scene.client.call("set_control", "rai_missions_msgs/srv/Control", to="operator", by="")["success"]
    scene.client.holders.wait(lambda all_: all_[-1] == "operator", "the operator holds control")
    reported = scene.client.call("set_control", "rai_missions_msgs/srv/Control", to="agent", by="agent")
    assert not reported["success"] and reported["message"]


def fields_of(message: str) -> set[str]:
    """The names of the fields in a definition."""
    text = (MESSAGES / f"{message}.msg").read_text(encoding="utf-8")
    return set(re.findall(r"^[\w/\[\]]+ (\w+)$", text, re.MULTILINE))


def test_a_step_has_the_fields_of_its_definition_and_verdict_mode_holder_and_refusal_in_them(scene: Scene) -> None:
    received: Inbox[Message] = Inbox(30.0)
    scene.client.connector.subscribe("/errand/mission_step", "rai_missions_msgs/msg/Step", received)
    scene.client.start()
    scene.client.command(command="post", event="ask")
    scene.client.command(command="answer", question=1, option="left", by="Ann")
    step = received.wait(lambda all_: bool(all_) and bool(all_[-1].data["outcome"]), "it ends")[-1].data
    (verdict,) = step["verdicts"]
    assert (step.keys(), verdict.keys()) == (fields_of("Step"), fields_of("Verdict"))
    assert (verdict["accepted"], verdict["kind"], verdict["number"], verdict["option"]) == (True, "proposal", 1, "left")
    assert (step["mode"], step["holder"], step["refusal"], step["kept"]) == ("aborted", "autonomy", "", False)
    assert step["remarks"] == []


def test_a_status_has_the_fields_of_its_definition_and_the_guide_names_its_words() -> None:
    question = Question(1, "assessing", "operator", "what now?", (Offer("left"),))
    goal = OpenGoal(1, "move", "moving", "orphaned")
    status = StatusMessage(
        1,
        "/errand",
        "a",
        "active",
        "errand",
        "1",
        "r",
        "running",
        "agent",
        questions=(OpenQuestion(question, 1.0),),
        open_goals=(goal,),
    )
    fields, data = status.fields(), status.data()
    assert fields.keys() == fields_of("MissionStatus")
    assert fields["questions"][0].keys() == fields_of("Question")
    assert fields["open_goals"][0].keys() == fields_of("OpenGoal")
    only_json = {"instance", "waits", "fault", "question", "at"}
    assert data.keys() - only_json == fields.keys() - {"stamp"}, "add what is new to fields() and MissionStatus.msg too"
    guide = GUIDE.read_text(encoding="utf-8").partition("- `~/status`")[2].partition("\n- `")[0]
    assert [word for word in data if f"`{word}`" not in guide] == []

# SPDX-License-Identifier: Apache-2.0
"""What a mission calls after it canceled a composed action reaches the robot after the cancel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from rai_missions.connectors.connector import Data, Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.profile import Robot
from rai_missions.runtime.goals import Goals
from tests.rigs.runs import ROBOT

DONE = Reply("succeeded", {"success": True})
GONE = Reply("unavailable", {}, "it vanished", may_have_arrived=True)


class SlowRobot(LocalConnector):
    """Answers when the test states it."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[str] = []
        self.answered: dict[str, Callable[[Reply], None]] = {}

    def call(
        self,
        service: str,
        type_name: str,
        request: Data,
        *,
        on_reply: Callable[[Reply], None],
        timeout_s: float | None = None,
    ) -> None:
        self.asked.append(service)
        self.answered[service] = on_reply
        if service == "/broken":
            raise RuntimeError("the wire is cut")


class Driven(NamedTuple):
    """A composed action that runs."""

    goals: Goals
    robot: SlowRobot
    reported: list[str]
    """The names of the events."""
    later: list[Callable[[], None]]
    """What is to be done after a while."""


def driving(**drive: Any) -> Driven:
    robot, reported, later = SlowRobot(), list[str](), list[Callable[[], None]]()
    words = {**ROBOT["actions"]["drive"], **drive}
    profile = {**ROBOT, "actions": {"drive": {word: value for word, value in words.items() if value is not None}}}
    goals = Goals(
        "run",
        Robot.model_validate(profile),
        robot,
        on_event=lambda kind, name, number, data: reported.append(name),
        later=lambda seconds, do: later.append(do),
    )
    goals.start(StartGoal(1, "driving", "drive", {}))
    robot.answered["/drive"](DONE)
    return Driven(goals, robot, reported, later)


def test_a_call_waits_for_the_reply_to_the_cancel() -> None:
    goals, robot, reported, _ = driving()
    goals.cancel(CancelGoal(1, "drive"))
    goals.cancels.behind(lambda: robot.asked.append("/turn_back"))
    assert robot.asked == ["/drive", "/halt"]
    robot.answered["/halt"](DONE)
    assert robot.asked == ["/drive", "/halt", "/turn_back"]
    assert reported == ["accepted", "canceled"]


@pytest.mark.parametrize("outcome", ["failed", "timed_out", "unavailable"])
def test_a_cancel_that_fails_keeps_no_one_waiting(outcome: Any) -> None:
    goals, robot, reported, _ = driving()
    goals.cancel(CancelGoal(1, "drive"))
    goals.cancels.behind(lambda: robot.asked.append("/turn_back"))
    robot.answered["/halt"](Reply(outcome, {}))
    assert robot.asked[-1] == "/turn_back"
    assert reported == ["accepted", *(["drive"] if outcome == "failed" else [])], "its end is not confirmed"


def test_a_cancel_that_cannot_be_sent_keeps_no_one_waiting() -> None:
    goals, robot, _, _ = driving(cancel="/broken")
    with pytest.raises(RuntimeError, match="the wire is cut"):
        goals.cancel(CancelGoal(1, "drive"))
    goals.cancels.behind(lambda: robot.asked.append("/turn_back"))
    assert robot.asked[-1] == "/turn_back"


def test_without_a_cancel_a_call_goes_at_once() -> None:
    goals, robot, _, _ = driving()
    goals.cancels.behind(lambda: robot.asked.append("/turn_back"))
    assert robot.asked == ["/drive", "/turn_back"]


@pytest.mark.parametrize("reply", [DONE, Reply("failed", {}), Reply("unavailable", {})])
def test_a_start_that_is_in_doubt_has_ended_once_the_robot_has_answered_its_end(reply: Reply) -> None:
    """Else what the mission starts next reaches the robot before the order that ends this one."""
    goals, robot, reported, _ = driving()
    goals.resume(StartGoal(2, "driving", "drive", {}), accepted=False, on_doubt=lambda: reported.append("uncertain"))
    assert robot.asked[-1] == "/halt" and "uncertain" not in reported
    robot.answered["/halt"](reply)
    assert "uncertain" in reported


def test_a_start_whose_server_vanished_has_ended_once_the_robot_has_answered_its_end() -> None:
    goals, robot, reported, _ = driving()
    goals.start(StartGoal(2, "driving", "drive", {}))
    robot.answered["/drive"](GONE)
    assert robot.asked[-1] == "/halt" and reported == ["accepted", "drive"], "it may be under way"
    robot.answered["/halt"](DONE)
    assert reported == ["accepted", "drive", "rejected", "drive"]


def test_a_goal_whose_end_was_ordered_twice_has_ended_with_the_last_answer() -> None:
    """The first order may have reached the robot ahead of the start; the second ends what comes behind it."""
    goals, robot, reported, _ = driving()
    goals.start(StartGoal(2, "driving", "drive", {}))
    goals.cancel(CancelGoal(2, "drive"))
    first = robot.answered["/halt"]
    robot.answered["/drive"](DONE)
    goals.cancel(CancelGoal(2, "drive"))
    goals.cancels.behind(lambda: robot.asked.append("/turn_back"))
    first(DONE)
    assert "canceled" not in reported and robot.asked[-1] == "/halt"
    robot.answered["/halt"](DONE)
    assert reported[-1] == "canceled" and robot.asked[-1] == "/turn_back"

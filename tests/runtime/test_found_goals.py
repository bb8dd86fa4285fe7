# SPDX-License-Identifier: Apache-2.0
"""A run that continues looks for its goals: what becomes of one whose acceptance is missing in its journal."""

from __future__ import annotations

import pytest

from rai_missions.connectors.connector import Data, OnReport, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import StartGoal
from rai_missions.profile import Robot
from rai_missions.runtime.goals import Goals

UNKNOWN = Report("", "lost", {}, "the server of /move knows nothing of the goal", may_run=False)
ACCEPTED, REJECTED, SUCCEEDED, OVER = (Report("", how, {}) for how in ("accepted", "rejected", "succeeded", "over"))
GONE = Report("", "lost", {}, "the server of /move is gone")


class ScriptedRobot(LocalConnector):
    """Reports what the test states; `asked` holds what was asked of it, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[str] = []
        self._reports: list[tuple[str, OnReport]] = []

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        self.asked.append("send")
        self._reports.append((goal_id, on_report))

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        self.asked.append("find")
        self._reports.append((goal_id, on_report))

    def report(self, report: Report, *, to: int = -1) -> None:
        """Report of the goal that was asked for last, or of an earlier one."""
        goal_id, on_report = self._reports[to]
        on_report(report._replace(goal_id=goal_id))


def resumed(*, accepted: bool = False, repeat: bool = False) -> tuple[ScriptedRobot, list[str]]:
    """A goal of a run that continues, and the events of it."""
    robot, events = ScriptedRobot(), list[str]()
    move = {"action": "/move", "type": "test_msgs/action/Fibonacci", "repeat": repeat}
    goals = Goals(
        "run",
        Robot.model_validate({"name": "robot", "actions": {"move": move}}),
        robot,
        on_event=lambda kind, name, number, data: events.append(name if kind == "result" else kind),
        later=lambda seconds, do: None,
    )
    goals.resume(StartGoal(1, "moving", "move", {}), accepted=accepted, on_doubt=lambda: events.append("doubt"))
    return robot, events


def test_one_that_its_server_knows_nothing_of_is_sent_again() -> None:
    robot, events = resumed()
    robot.report(UNKNOWN)
    robot.report(ACCEPTED)
    robot.report(SUCCEEDED)
    assert robot.asked == ["find", "send"] and events == ["accepted", "succeeded"]


@pytest.mark.parametrize("repeat", [False, True])
def test_one_that_was_found_and_is_lost_later_is_not_sent_again(repeat: bool) -> None:
    robot, events = resumed(repeat=repeat)
    robot.report(ACCEPTED)
    robot.report(GONE)
    robot.report(OVER)
    assert robot.asked == ["find"] and events == ["accepted", "lost", "failed", "over"]


def test_one_that_was_accepted_while_it_was_sent_again_is_looked_for_once_more() -> None:
    """Its server takes no second goal of one id, and pursues the first."""
    robot, events = resumed()
    robot.report(UNKNOWN)
    robot.report(REJECTED)
    assert robot.asked == ["find", "send", "find"] and events == []
    robot.report(ACCEPTED)
    robot.report(SUCCEEDED)
    assert events == ["accepted", "succeeded"]


def test_one_that_its_server_does_not_take_is_rejected() -> None:
    robot, events = resumed()
    robot.report(UNKNOWN)
    robot.report(REJECTED)
    robot.report(UNKNOWN)
    assert robot.asked == ["find", "send", "find"] and events == ["rejected"]


def test_the_end_of_one_that_was_not_found_is_not_the_end_of_the_one_that_is_sent_again() -> None:
    robot, events = resumed()
    robot.report(GONE)
    robot.report(ACCEPTED)
    robot.report(OVER, to=0)
    assert events == ["accepted"]


@pytest.mark.parametrize(("repeat", "asked"), [(False, ["find"]), (True, ["find", "send"])])
def test_one_that_was_accepted_is_sent_again_only_where_that_is_harmless(repeat: bool, asked: list[str]) -> None:
    robot, events = resumed(accepted=True, repeat=repeat)
    robot.report(UNKNOWN)
    assert robot.asked == asked and events == ([] if repeat else ["failed"])

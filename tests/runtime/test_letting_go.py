# SPDX-License-Identifier: Apache-2.0
"""What a run asks of the robot once, and what it never asks: to let go, to cancel, to end what never began."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import StartGoal
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.goals import Goals, id_of_goal
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.runner import Runner
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import ROBOT, Rig, robot

WAITING: Any = {
    "waiting": {"control": "autonomy", "transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}
}  # fmt: skip
STRING = "std_msgs/msg/String"
GUARDED = robot(
    control={"nobody": {"service": "/let_go", "type": "std_srvs/srv/Trigger"}},
    holder={"topic": "/holder", "type": STRING},
)


@pytest.mark.parametrize(("end", "calls"), [("cancel", 0), ("kill", 1)])
def test_only_the_stop_of_the_run_has_control_let_go(end: str, calls: int) -> None:
    """A robot that no one controls by its own decision is left so: the run does not change that."""
    asked: list[str] = []

    def let_go(_: object) -> dict[str, object]:
        asked.append("nobody")
        return {"success": True}

    rig = Rig(WAITING, robot=GUARDED)
    rig.connector.serve("/let_go", "std_srvs/srv/Trigger", let_go)
    rig.stage.play(
        {
            1.0: lambda: rig.connector.publish("/holder", STRING, {"data": "nobody"}),
            2.0: rig.runner.pause,
            3.0: rig.runner.resume,
            4.0: lambda: rig.connector.publish("/holder", STRING, {"data": "operator"}),
            5.0: getattr(rig.runner, end),
        }
    )
    rig.run()
    assert "paused" in {step.mode for step in rig.steps}
    assert len(asked) == calls


def test_what_the_operator_asked_for_is_kept_until_it_comes() -> None:
    control = Control()
    assert not control.request("operator", "operator")
    control.follow("autonomy", taken=False)
    assert control.refuses("autonomy", "software") == "the operator has control and has not given it back"


class Faltering(LocalConnector):
    """A connector that fails as it sends, and knows what it was asked to cancel."""

    def __init__(self) -> None:
        super().__init__()
        self.canceled: list[str] = []

    def send_goal(
        self,
        action: str,
        type_name: str,
        goal: Mapping[str, Any],
        *,
        goal_id: str,
        on_report: Callable[[Report], None],
    ) -> None:
        raise RuntimeError("the wire is cut")

    def cancel_goal(self, goal_id: str) -> None:
        self.canceled.append(goal_id)


def test_a_goal_that_may_have_arrived_is_canceled_and_one_that_cannot_have_is_not() -> None:
    connector, reported = Faltering(), list[tuple[int, str]]()
    goals = Goals(
        "run",
        Robot.model_validate(ROBOT),
        connector,
        on_event=lambda kind, name, number, data: reported.append((number, name)),
        later=lambda seconds, do: None,
    )
    with pytest.raises(RuntimeError):
        goals.start(StartGoal(1, "moving", "move", {}))
    goals.give_up(1, "the wire is cut")
    goals.give_up(2, "the wire is cut")
    assert connector.canceled == [id_of_goal("run", 1, "moving")]
    assert reported == [(1, "rejected"), (2, "rejected")]


def test_a_call_without_a_server_ends_once() -> None:
    book = MemoryJournal()
    states = {
        "calling": {"call": "horn", "timeout_s": 5, "transitions": [{"on": "rejected", "to": "waiting"}]},
        "waiting": {"transitions": [{"after_s": 1, "to": "over"}]},
        "over": {"final": "aborted"},
    }  # fmt: skip
    mission = Mission.model_validate({"name": "alone", "initial": "calling", "states": states})
    rig = Rig(WAITING)
    Runner(mission, clock=rig.clock, journal=book).run()
    assert [step.event.name for step in book.steps if step.event.kind == "result"] == ["unavailable"]


@pytest.mark.parametrize(("sent", "why"), [(b"much", "bytes"), ("much", "much")])
def test_a_reading_that_is_not_understood_is_known_as_such(sent: object, why: str) -> None:
    misread: list[str] = []
    rig = Rig(WAITING)
    rig.stage.play(
        {
            1.0: lambda: rig.publish("/battery", percentage=sent),
            2.0: lambda: misread.append(rig.runner.view.source("battery").misread),
            3.0: lambda: rig.post("go"),
        }
    )
    rig.run()
    assert len(misread) == 1 and why in misread[0]

# SPDX-License-Identifier: Apache-2.0
"""An event that is received during an action: what our own commands make the robot state is none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import pytest
from pydantic import ValidationError

from rai_missions.connectors.local import LocalConnector
from rai_missions.profile import Robot
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.robot_listener import RobotListener
from rai_missions.runtime.scheduler import Scheduler

TYPE = "std_msgs/msg/String"
STUCK = {"topic": "/state", "type": TYPE, "when": {"key": "data", "==": "STOPPED"}, "during": "drive"}
DRIVE = {"start": "/go", "cancel": "/stop", "succeeded": {"key": "there", "==": True}}


class Ear(NamedTuple):
    senses: RobotListener
    connector: LocalConnector
    mailbox: Mailbox
    received: list[str]

    def receive(self, *words: str) -> list[str]:
        """What has happened by the time that the robot has reported all this."""
        for word in words:
            self.connector.publish("/state", TYPE, {"data": word})
        while (event := self.mailbox.take()) is not None:
            self.received.append(event.name)
        return self.received


@pytest.fixture
def ear() -> Iterator[Ear]:
    robot = Robot.model_validate({"name": "one", "events": {"stuck": STUCK}, "actions": {"drive": DRIVE}})
    connector, received = LocalConnector(), list[str]()
    connector.start()
    mailbox = Mailbox()
    senses = RobotListener(robot, connector, Scheduler(SimulatedClock(), mailbox))
    senses.open()
    yield Ear(senses, connector, mailbox, received)
    senses.close()
    connector.stop()


def test_it_happens_while_the_action_is_under_way(ear: Ear) -> None:
    ear.senses.begin_action("drive")
    assert ear.receive("DRIVING", "STOPPED", "STOPPED") == ["stuck"]
    assert ear.receive("DRIVING", "STOPPED") == ["stuck", "stuck"]


def test_it_does_not_happen_before_the_action_nor_after_its_end_was_asked_for(ear: Ear) -> None:
    assert ear.receive("DRIVING", "STOPPED") == []
    ear.senses.begin_action("drive")
    ear.receive("DRIVING")
    ear.senses.end_action("drive")
    assert ear.receive("STOPPED", "DRIVING", "STOPPED") == []


def test_what_was_so_before_the_action_is_no_news_until_it_was_otherwise(ear: Ear) -> None:
    ear.senses.begin_action("drive")
    ear.senses.end_action("drive")
    ear.receive("STOPPED")
    ear.senses.begin_action("drive")
    assert ear.receive("STOPPED", "STOPPED") == [], "a stop that is still received"
    assert ear.receive("DRIVING", "STOPPED") == ["stuck"]


def test_a_run_that_continues_receives_what_happened_while_no_one_listened(ear: Ear) -> None:
    ear.senses.continue_action("drive")
    assert ear.receive("STOPPED", "STOPPED") == ["stuck"]


def test_another_action_changes_nothing(ear: Ear) -> None:
    ear.senses.begin_action("drive")
    ear.receive("DRIVING")
    ear.senses.begin_action("turn")
    ear.senses.end_action("turn")
    assert ear.receive("STOPPED") == ["stuck"]


def test_an_action_that_is_not_there_is_a_fault() -> None:
    with pytest.raises(ValidationError, match="'stuck' is received during 'drive', which is no action here"):
        Robot.model_validate({"name": "one", "events": {"stuck": STUCK}})
    with pytest.raises(ValidationError, match="drop 'during'"):
        Robot.model_validate({"name": "one", "events": {"stuck": {"posted": True, "during": "drive"}}})

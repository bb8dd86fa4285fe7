# SPDX-License-Identifier: Apache-2.0
"""A composed action whose `cancel` is unanswered is ended once the robot answers, and before the next one starts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.runtime.result import Result
from tests.rigs.runs import Rig
from tests.runtime.test_behind_cancels import DONE, GONE, driving

TRIGGER = "std_srvs/srv/Trigger"
RETRIES = {"on": ["rejected", "timed_out"], "to": "resting"}


def states(**second: Any) -> dict[str, Any]:
    """An action that is left unfinished, and the same again until it is done."""
    return {
        "first": {"action": "drive", "timeout_s": 1, "cancel_s": 1, "transitions": [RETRIES]},
        "resting": {"transitions": [{"after_s": 1, "to": "second"}]},
        "second": {
            "action": "drive",
            "timeout_s": 30,
            "transitions": [{"on": "succeeded", "to": "done"}, {"on": "rejected", "to": "resting"}],
            **second,
        },
        "done": {"final": "failed"},
    }


class Vanishing(LocalConnector):
    """A connector on which the server of the first `/drive` is gone before it replies."""

    has_vanished = False

    def call(
        self, service: str, type_name: str, request: Any, *, on_reply: Any, timeout_s: float | None = None
    ) -> None:
        if service == "/drive" and not self.has_vanished:
            self.has_vanished = True
            on_reply(GONE)
        else:
            super().call(service, type_name, request, on_reply=on_reply, timeout_s=timeout_s)


class _NoHalt(Rig):
    """A rig whose `/halt` is away for the first seconds."""

    result: Result

    def serve(self) -> None:
        self.connector.serve("/drive", TRIGGER, lambda _: self._answer("/drive"))

    def come_back(self) -> None:
        self.connector.serve("/halt", TRIGGER, lambda _: self._answer("/halt"))


def played(back: float, given: dict[str, Any] | None = None, connector: Callable[..., Any] = LocalConnector) -> _NoHalt:
    rig: _NoHalt = _NoHalt(given or states(), connector=connector(now=lambda: rig.clock.now()))
    rig.stage.play({back: rig.come_back, 20.0: lambda: rig.publish("/there", data=True), 60.0: rig.runner.kill})
    rig.result = rig.run()
    assert rig.result.why == "'done' was reached"
    return rig


def test_an_orphan_is_canceled_once_its_service_is_back_and_the_next_starts() -> None:
    rig = played(6.0)
    notes = [note for step in rig.book.steps for note in step.notes]
    assert any("orphaned" in note for note in notes)
    services = [service for _, service in rig.called]
    assert services == ["/drive", "/halt", "/drive"], "nothing starts before the end of the first"
    assert 6.0 <= rig.called[1][0] <= 8.5
    assert rig.result.open_goals == ()


def test_a_cancel_that_is_answered_in_time_leaves_no_orphan() -> None:
    first = {**states()["first"], "cancel_s": 5}
    rig = played(2.5, {**states(), "first": first})
    assert not any("orphaned" in note for step in rig.book.steps for note in step.notes)


def test_a_start_that_may_have_arrived_is_ended_before_the_next() -> None:
    rig = played(6.0, connector=Vanishing)
    assert [service for _, service in rig.called][:2] == ["/halt", "/drive"]
    assert rig.result.open_goals == ()
    whys = {step.event.data.get("why") for step in rig.book.steps if step.event and step.event.name == "rejected"}
    assert "an earlier goal of 'drive', which was lost, may still run: no server offers /halt" in whys


def test_a_start_over_an_orphan_is_not_ended_by_the_cancel_of_the_first() -> None:
    rig = played(6.0, states(over_orphan=True))
    assert [service for _, service in rig.called] == ["/drive", "/drive"]
    assert [goal.reason for goal in rig.result.open_goals] == ["orphaned"], "its end was never confirmed"


@pytest.mark.parametrize("reply", [DONE, Reply("failed", {}, "no")])
def test_a_cancel_that_is_answered_is_not_repeated(reply: Reply) -> None:
    driven = driving()
    driven.goals.cancel(CancelGoal(1, "drive"))
    driven.robot.answered["/halt"](reply)
    assert not driven.later


@pytest.mark.parametrize("outcome", ["timed_out", "unavailable"])
def test_a_cancel_that_is_unanswered_is_repeated_and_holds_back_no_call(outcome: Any) -> None:
    driven = driving()
    driven.goals.cancel(CancelGoal(1, "drive"))
    driven.robot.answered["/halt"](Reply(outcome, {}))
    driven.later.pop()()
    assert driven.robot.asked == ["/drive", "/halt", "/halt"]
    driven.goals.cancels.behind(lambda: driven.robot.asked.append("/turn_back"))
    assert driven.robot.asked[-1] == "/turn_back"
    driven.robot.answered["/halt"](DONE)
    assert driven.reported == ["accepted", "canceled"] and not driven.later


def test_a_start_that_is_canceled_while_it_waits_for_the_end_of_a_lost_one_is_never_sent() -> None:
    driven = driving()
    driven.goals.start(StartGoal(2, "driving", "drive", {}))
    driven.robot.answered["/drive"](GONE)
    driven.robot.answered["/halt"](Reply("unavailable", {}))
    driven.goals.start(StartGoal(3, "driving", "drive", {}))
    driven.goals.cancel(CancelGoal(3, "drive"))
    before = driven.robot.asked.count("/drive")
    driven.robot.answered["/halt"](DONE)
    assert driven.robot.asked.count("/drive") == before and "canceled" in driven.reported


def test_a_lost_start_without_a_cancel_bars_no_other() -> None:
    driven = driving(cancel=None)
    driven.goals.start(StartGoal(2, "driving", "drive", {}))
    driven.robot.answered["/drive"](GONE)
    driven.goals.start(StartGoal(3, "driving", "drive", {}))
    assert driven.robot.asked == ["/drive"] * 3

# SPDX-License-Identifier: Apache-2.0
"""A run as those outside see it: what is asked, and how long there is."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.node.order import ClientOrder, OrderReply, read_order
from rai_missions.node.run_session import RunSession
from rai_missions.node.web_operator import WebOrders
from tests.node.scenes import mission, robot
from tests.rigs.runs import ManualClock, Rig, by_hand

SPANS = st.lists(st.floats(0.001, 100.0), max_size=6)


class AskingRun:
    """A run whose steps the test makes, followed by its course."""

    def __init__(self) -> None:
        self.clock = ManualClock(waits=True)
        self.chart = Chart(mission(), CompiledTrees())
        self.runner = by_hand(self.chart, robot=robot({"kind": "local"}), clock=self.clock)
        self.session = RunSession(self.runner, None)
        self.session.step(self.chart.start(0.0))

    def send(self, name: str, kind: str = "event") -> None:
        self.session.step(self.chart.send(Event(name, self.clock.at, {}, kind)))

    @property
    def left_s(self) -> float:
        (asked,) = self.session.questions()
        return round(asked.left_s, 6)


@given(goes=SPANS, rests=SPANS)
def test_a_question_loses_no_time_while_its_run_is_paused(goes: list[float], rests: list[float]) -> None:
    answered_at, gone = AskingRun(), 0.0
    answered_at.send("ask")
    for went, rested in zip(goes, rests, strict=False):
        answered_at.clock.at += went
        gone += went
        left = max(0.0, round(600.0 - gone, 6))
        assert abs(answered_at.left_s - left) < 1e-5
        answered_at.send("pause", "command")
        answered_at.clock.at += rested
        assert abs(answered_at.left_s - left) < 1e-5, "its time stops"
        answered_at.send("resume", "command")
        assert abs(answered_at.left_s - left) < 1e-5, "and continues from there"


def test_a_pause_before_a_question_gives_it_no_more_time() -> None:
    answered_at = AskingRun()
    answered_at.send("pause", "command")
    answered_at.clock.at = 50.0
    answered_at.send("resume", "command")
    answered_at.send("ask")
    answered_at.clock.at = 60.0
    assert answered_at.left_s == 590.0


def test_a_run_that_continues_shows_what_was_asked_before_with_the_time_left() -> None:
    answered_at = AskingRun()
    answered_at.send("ask")
    answered_at.clock.at = 10.0
    answered_at.send("pause", "command")
    answered_at.clock.at = 99.0
    resumed = RunSession(answered_at.runner, None)
    ((question, left_s),) = resumed.questions()
    assert (question.state, question.asked, left_s) == ("asking", "operator", 590.0)
    resumed.step(answered_at.chart.send(Event("resume", 99.0, {}, "command")))
    assert resumed.questions()[0].left_s == 590.0


def test_a_run_that_continues_shows_from_the_first_where_it_is_and_who_has_control() -> None:
    before = AskingRun()
    before.send("ask")
    before.session.step(before.chart.send(Event("operator", 5.0, {"role": "operator"}, "control")))
    status = RunSession(before.runner, None).status
    assert status is not None
    assert (status.mode, status.control, status.active) == ("running", "operator", before.chart.active_in_order)


@pytest.mark.parametrize("reported", [{"id": 1}, [1], None, 7, "another"])
def test_what_a_robot_calls_a_request_is_none_of_the_orders(reported: Any) -> None:
    """An order waits; a robot's event comes first, in which something has the name of what distinguishes orders."""
    answered_at, receipts = AskingRun(), list[OrderReply]()
    answered_at.session.submit(ClientOrder("pause"), receipts.append)
    event = Event("robot_reports", 0.0, {"request": reported})
    assert not answered_at.session.requests.drops(event)
    answered_at.session.receive(answered_at.chart.send(event))
    assert receipts == []


def test_anyone_who_cannot_be_reported_what_became_of_an_order_ends_no_run() -> None:
    rig = Rig({"idle": {}})
    course, asked = RunSession(rig.runner, None), list[OrderReply]()

    def gone(reply: OrderReply) -> None:
        asked.append(reply)
        raise ConnectorError("the broker is gone")

    rig.stage.play(
        {
            1.0: lambda: course.submit(ClientOrder("control", role="operator", to="operator"), gone),
            2.0: rig.runner.kill,
            2.1: lambda: course.submit(ClientOrder("pause"), gone),
        }
    )
    assert course.run().outcome == "aborted"
    assert asked[0].success


@given(st.booleans(), st.sampled_from(["", "its own", "another"]))
def test_an_answer_to_a_question_of_another_run_is_refused_and_changes_nothing(by_page: bool, of: str) -> None:
    run = AskingRun()
    run.send("ask")
    (asked,) = run.session.questions()
    posted, replies = list[Event](), list[tuple[bool, str]]()
    run.runner.post = posted.append  # type: ignore[method-assign]
    name = {"its own": run.runner.run_id, "another": "0123456789ab"}.get(of, "")
    order = {"command": "answer", "question": asked.question.number, "option": "left", **({"run": name} if of else {})}
    if by_page:
        page = WebOrders(run.session, answers=True, note=print)
        page.submit(json.dumps(order), lambda success, why: replies.append((success, why)))
    else:
        read = read_order(json.dumps(order))
        assert isinstance(read, ClientOrder)
        run.session.submit(read, lambda reply: replies.append((reply.success, reply.why)))
    assert len(posted) == (of != "another")
    assert not replies or "was asked in another run, 0123456789ab" in replies[0][1]


@given(
    st.sampled_from(["left", "right"]) | st.text(max_size=9),
    st.dictionaries(st.text(max_size=5), st.none() | st.booleans(), max_size=2),
)
def test_an_answer_that_is_none_to_its_question_is_refused_as_the_engine_would_and_costs_no_attempt(
    option: str, parameters: dict[str, Any]
) -> None:
    run, posted, replies = AskingRun(), list[Event](), list[OrderReply]()
    run.send("ask")
    (asked,) = run.session.questions()
    run.runner.post = posted.append  # type: ignore[method-assign]
    number = asked.question.number
    run.session.submit(ClientOrder("answer", question=number, option=option, parameters=parameters), replies.append)
    assert run.session.questions()[0].question.number == number
    if not posted:
        verdict = run.chart.propose(number, option, parameters, by="operator").verdict
        assert verdict is not None and (verdict.accepted, verdict.why) == (False, replies[0].why)
    else:
        assert run.chart.propose(number, option, parameters, by="operator").verdict.accepted  # type: ignore[union-attr]

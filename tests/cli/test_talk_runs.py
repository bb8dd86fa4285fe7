# SPDX-License-Identifier: Apache-2.0
"""Which run follows another in one conversation, where an order comes in the moment between the two."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.run.talk_runs import TalkRuns
from rai_missions.conversation import Order
from rai_missions.conversation.inputs import OrderResult
from rai_missions.mission.mission import Mission
from rai_missions.node.run_session import RunSession
from rai_missions.node.web_operator import WebOrders
from rai_missions.runtime.clock import SimulatedClock

MISSION: dict[str, Any] = {
    "format": 1, "name": "errand", "initial": "waiting",
    "blackboard": {"rounds": {"type": "integer", "source": "argument", "initial": 1}},
    "states": {"waiting": {"transitions": [{"after_s": 1, "to": "over"}]}, "over": {"final": "aborted"}},
}  # fmt: skip
START = Order(1, "start", "operator", "page", "", "errand", {"rounds": 3})


def test_a_start_that_is_ordered_while_the_next_run_is_prepared_begins_that_run() -> None:
    config = RunConfig(Mission.model_validate(MISSION), clock=SimulatedClock(), waits=True)
    ends = list[OrderResult]()
    with prepare(config) as first:
        runs = TalkRuns(config, waits=True, is_reachable=lambda: True)
        runs.begin(first)
        assert not first.runner.start({})
        assert first.runner.run().outcome == "aborted"
        second = runs.following()
        assert second is not None
        runs.order(START, ends.append)
        runs.follow(second)
        runner = second.runner
        runner.call_soon(lambda: runner.cancel("test") if runner.waits else None)  # where the order was lost
        runner.run()
        assert ends == [OrderResult()] and not runner.waits, "it never began"
        assert runner.view.board["rounds"].value == 3
        second.close()


def test_a_stop_keeps_back_the_run_whose_start_was_ordered_and_has_not_begun() -> None:
    config = RunConfig(Mission.model_validate(MISSION), clock=SimulatedClock())
    ends, stops = list[OrderResult](), list[OrderResult]()
    with prepare(config) as first:
        runs = TalkRuns(config, waits=False, is_reachable=lambda: True)
        runs.begin(first)
        assert first.runner.run().outcome == "aborted"
        runs.order(START, ends.append)
        runs.order(START._replace(name="stop"), stops.append)
        assert not runs.is_continued and stops == [OrderResult()] and ends[0].kind == "stopped"
        runs.order(START, ends.append)
        second = runs.following()
        assert second is not None
        runs.order(START._replace(name="stop"), stops.append)
        runs.follow(second)
        runner = second.runner
        runner.call_soon(lambda: runner.cancel("test"))
        assert (runner.run().outcome, runner.waits) == ("canceled", True), "it never began"
        second.close()


def test_an_e_stop_that_finds_the_run_over_has_no_other_follow() -> None:
    config = RunConfig(Mission.model_validate(MISSION), clock=SimulatedClock())
    replies = list[tuple[bool, str]]()
    with prepare(config) as first:
        runs = TalkRuns(config, waits=False, is_reachable=lambda: True)
        session = RunSession(runs.begin(first), None)
        page = WebOrders(session, answers=True, note=first.runner.note, on_late_stop=runs.kill)
        session.run()
        runs.order(START, print)
        assert runs.is_continued
        page.submit('{"command": "e_stop"}', lambda success, why: replies.append((success, why)))
        assert replies == [(False, "the mission has ended")] and not runs.is_continued


def test_a_run_that_waits_ends_where_the_input_ended_while_it_was_prepared() -> None:
    config = RunConfig(Mission.model_validate(MISSION), clock=SimulatedClock(), waits=True)
    with prepare(config) as first:
        runs = TalkRuns(config, waits=True, is_reachable=lambda: True)
        runs.begin(first)
        first.runner.start({})
        first.runner.run()
        second = runs.following()
        assert second is not None
        runs.give_up()
        runs.follow(second)
        second.runner.call_soon(lambda: second.runner.cancel("test"))  # what ends it where it would wait for ever
        assert "end of input" in second.runner.run().why
        second.close()


@pytest.mark.parametrize(
    ("orders", "ends"),
    [
        ("", "end of input"), ("start", "reached"), ("start pause", "end of input"), ("start stop", "end of input"),
        ("stop", "end of input"),
    ],
)  # fmt: skip
def test_where_the_input_ends_a_run_that_only_an_order_moves_ends_and_any_other_runs_to_its_end(
    orders: str, ends: str
) -> None:
    runs = TalkRuns(RunConfig(Mission.model_validate(MISSION)), waits=True, is_reachable=lambda: False)
    clock = SimulatedClock()
    config = RunConfig(Mission.model_validate(MISSION), clock=clock, waits=True, on_status=lambda _: runs.changed())
    with prepare(config) as first:
        runner = runs.begin(first)
        for word in orders.split():
            runner.start({}) if word == "start" else getattr(runner, word)("operator")
        runs.give_up()
        assert ends in runner.run().why

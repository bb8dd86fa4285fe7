# SPDX-License-Identifier: Apache-2.0
"""What every connector must do, as a function that a connector's tests call.

Rule: each check opens a fresh connector, so that one broken promise does not hide another.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Generic, TypeVar, get_args

from rai_missions.connectors.connector import ENDS, Connector, ConnectorMode, Data, Message, OnReport, Reply, Report
from rai_missions.errors import UsageError
from rai_missions.given import check_function

__all__ = ("Inbox", "PatientServer", "check_connector")

T = TypeVar("T")
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
MODES: tuple[ConnectorMode, ...] = get_args(ConnectorMode)
PATIENCE_S = 30.0


class Inbox(Generic[T]):
    """Collects what a callback receives, from any thread.

    Args:
        within_s: How long `wait` waits before it gives up.
    """

    def __init__(self, within_s: float = PATIENCE_S) -> None:
        self.all: list[T] = []
        self._within_s = within_s
        self._changed = threading.Condition()

    def __call__(self, what: T) -> None:
        with self._changed:
            self.all.append(what)
            self._changed.notify_all()

    def wait(self, enough: Callable[[list[T]], bool], what: str) -> list[T]:
        """Wait until enough was received, and something at all; else an `AssertionError` names what is missing."""
        with self._changed:
            is_enough = self._changed.wait_for(lambda: bool(self.all) and enough(self.all), self._within_s)
            assert is_enough, f"{what}; received only {self.all}"
            return list(self.all)


class PatientServer:
    """An action server that does only what the test asks; the words of its goals are kept in order."""

    def __init__(self) -> None:
        self.asked: Inbox[tuple[str, str]] = Inbox()
        self.goals: dict[str, Data] = {}
        self.report: dict[str, OnReport] = {}

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        self.goals[goal_id], self.report[goal_id] = goal, report
        self.asked(("accept", goal_id))

    def cancel(self, goal_id: str) -> None:
        self.asked(("cancel", goal_id))

    def send(self, goal_id: str, status: Any, data: Data | None = None) -> None:
        self.report[goal_id](Report(goal_id, status, data or {}))


def check_connector(
    make: Callable[[], Connector], *, action_type: str = "test_msgs/action/Fibonacci", goal: Data | None = None
) -> None:
    """Hold a connector to the contract of `Connector`, in the modes that it has.

    Args:
        make: Gives a fresh connector, not started.
        action_type: An action type that the connector can carry.
        goal: A goal of that type.

    Raises:
        AssertionError: A promise is broken; the text states which.
    """
    check_function(make, "check_connector", "what makes a connector", "give its class, or a function")
    checks = {"topics": TOPICS, "services": SERVICES, "actions": ACTIONS}
    for mode in sorted(make().modes):
        for check in checks[mode]:
            connector = make()
            connector.start()
            try:
                check(connector, action_type, {"order": 3} if goal is None else goal)
            finally:
                connector.stop()
    _starts_and_stops_repeatedly(make())


def _starts_and_stops_repeatedly(connector: Connector) -> None:
    connector.stop()
    for _ in range(2):
        assert connector.running is False, "what was not started, or was stopped, does not run"
        connector.start()
        connector.start()
        _is_running(connector)
        connector.stop()
        connector.stop()
    assert connector.running is False, "what was stopped does not run"
    assert all(connector.listed(mode) == {} for mode in MODES), "what does not run lists nothing"


def _is_running(connector: Connector) -> None:
    assert connector.running is True, "what was started runs"


def _comes_to_list(connector: Connector, mode: ConnectorMode, type_name: str | None, name: str) -> None:
    """Wait until a name is listed with its type; or, for None, until it is no more."""
    until, tick = time.monotonic() + PATIENCE_S, threading.Event()
    while (found := connector.listed(mode)).get(name) != type_name:
        assert time.monotonic() < until, f"{name} should be listed with the type {type_name!r}, not: {dict(found)}"
        tick.wait(0.02)
    others = [other for each in MODES for other in connector.listed(each) if other.startswith(name) and other != name]
    assert not others, f"what a transport makes {name} of is not listed: {others}"


def _lists_its_topics(connector: Connector, *_: Any) -> None:
    connector.subscribe("/check/received", STRING, lambda _message: None)
    connector.publish("/check/sent", STRING, {"data": "x"})
    _comes_to_list(connector, "topics", STRING, "/check/received")
    _comes_to_list(connector, "topics", STRING, "/check/sent")


def _lists_what_is_served(connector: Connector, *_: Any) -> None:
    close = connector.serve("/check/service", TRIGGER, lambda request: request)
    _comes_to_list(connector, "services", TRIGGER, "/check/service")
    close()
    _comes_to_list(connector, "services", None, "/check/service")


def _lists_its_actions(connector: Connector, action_type: str, _goal: Data) -> None:
    close = connector.offer("/check/action", action_type, PatientServer())
    _comes_to_list(connector, "actions", action_type, "/check/action")
    close()
    _comes_to_list(connector, "actions", None, "/check/action")


def _receives_what_is_published(connector: Connector, *_: Any) -> None:
    inbox: Inbox[Message] = Inbox()
    close = connector.subscribe("/check/topic", STRING, inbox)
    for text in ("one", "two", "three"):
        connector.publish("/check/topic", STRING, {"data": text})
    messages = inbox.wait(lambda all_: len(all_) == 3, "three messages were published")
    assert [message.data["data"] for message in messages] == ["one", "two", "three"], "messages come in order"
    assert all(message.topic == "/check/topic" for message in messages), "a message names its topic"
    close()
    close()
    connector.publish("/check/topic", STRING, {"data": "late"})
    assert len(inbox.all) == 3, "a closed subscription receives nothing"


def _receives_nothing_after_stop(connector: Connector, *_: Any) -> None:
    inbox: Inbox[Message] = Inbox()
    connector.subscribe("/check/topic", STRING, inbox)
    connector.stop()
    connector.start()
    connector.publish("/check/topic", STRING, {"data": "late"})
    assert inbox.all == [], "stop closes the subscriptions"


def _answers_a_call_once(connector: Connector, *_: Any) -> None:
    replies: Inbox[Reply] = Inbox()
    connector.serve("/check/service", TRIGGER, lambda _request: {"success": True, "message": "done"})
    connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=PATIENCE_S)
    (reply,) = replies.wait(bool, "the service was called")
    assert (reply.outcome, dict(reply.data)) == ("succeeded", {"success": True, "message": "done"}), reply


def _answers_a_call_later(connector: Connector, *_: Any) -> None:
    replies: Inbox[Reply] = Inbox()
    asked: Inbox[Data] = Inbox()
    answers: list[Future[Data]] = [Future(), Future(), Future()]

    def answer(request: Data) -> Future[Data]:
        asked(request)
        return answers[len(asked.all) - 1]

    connector.serve("/check/service", TRIGGER, answer)
    connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=PATIENCE_S)
    asked.wait(bool, "the service was called")
    assert replies.all == [], "no reply comes before the answer"
    answers[0].set_result({"success": True, "message": "done"})
    (reply,) = replies.wait(bool, "the answer came")
    assert (reply.outcome, dict(reply.data)) == ("succeeded", {"success": True, "message": "done"}), reply
    connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=PATIENCE_S)
    asked.wait(lambda all_: len(all_) == 2, "the service was called again")
    answers[1].set_exception(ValueError("no lamp"))
    failed = replies.wait(lambda all_: len(all_) == 2, "the answer failed")[1]
    assert failed.outcome == "failed", failed
    assert "no lamp" in failed.why, failed
    connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=PATIENCE_S)
    asked.wait(lambda all_: len(all_) == 3, "the service was called a third time")
    answers[2].cancel()
    assert replies.wait(lambda all_: len(all_) == 3, "the answer was given up")[2].outcome == "failed", replies.all


class _Wordless(Exception):
    """What a stranger may raise: its text raises."""

    def __str__(self) -> str:
        raise ValueError("no words")


def _reports_why_a_call_failed(connector: Connector, *_: Any) -> None:
    faults = iter((ValueError("no lamp"), _Wordless()))

    def answer(_request: Data) -> Data:
        raise next(faults)

    connector.serve("/check/service", TRIGGER, answer)
    for why in ("no lamp", "_Wordless"):
        replies: Inbox[Reply] = Inbox()
        connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=5.0)
        (reply,) = replies.wait(bool, f"the service raised: {why}")
        assert reply.outcome in ("failed", "timed_out"), reply
        assert reply.outcome == "timed_out" or why in reply.why, reply


def _reports_that_no_server_offers(connector: Connector, *_: Any) -> None:
    replies: Inbox[Reply] = Inbox()
    close = connector.serve("/check/service", TRIGGER, lambda _request: {})
    close()
    connector.call("/check/service", TRIGGER, {}, on_reply=replies, timeout_s=0.5)
    (reply,) = replies.wait(bool, "no server offers it")
    assert reply.outcome in ("unavailable", "timed_out"), reply


def _sent(
    connector: Connector, action_type: str, goal: Data, goal_id: str, server: PatientServer | None = None
) -> tuple[PatientServer, Inbox[Report]]:
    server, reports = server or PatientServer(), Inbox[Report]()
    connector.offer("/check/action", action_type, server)
    connector.send_goal("/check/action", action_type, goal, goal_id=goal_id, on_report=reports)
    server.asked.wait(bool, "a goal was sent")
    return server, reports


def _ended_with(*ends: str) -> Callable[[list[Report]], bool]:
    """Whether the last report, if any has come yet, is one of these."""
    return lambda reports: bool(reports) and reports[-1].status in ends


def _carries_a_goal_to_its_end(connector: Connector, action_type: str, goal: Data) -> None:
    server, reports = _sent(connector, action_type, goal, "g1")
    assert {key: server.goals["g1"][key] for key in goal} == dict(goal), "the server gets the goal as it was sent"
    for status in ("accepted", "feedback", "succeeded", "succeeded", "failed", "feedback"):
        server.send("g1", status)
    statuses = [report.status for report in reports.wait(_ended_with(*ENDS), "the goal succeeded")]
    assert statuses[0] == "accepted", statuses
    assert statuses[-1] == "succeeded", f"nothing is reported after the end, but: {statuses}"
    assert statuses.count("succeeded") == 1, statuses


def _remembers_an_early_cancel(connector: Connector, action_type: str, goal: Data) -> None:
    server, reports = _sent(connector, action_type, goal, "g2")
    connector.cancel_goal("g2")
    server.send("g2", "accepted")
    server.asked.wait(lambda all_: ("cancel", "g2") in all_, "a cancel before the acceptance is sent after it")
    server.send("g2", "canceled")
    reports.wait(_ended_with("canceled"), "the goal was canceled")


def _ignores_a_cancel_of_nothing(connector: Connector, action_type: str, goal: Data) -> None:
    connector.cancel_goal("nobody")
    server, reports = _sent(connector, action_type, goal, "g3")
    server.send("g3", "accepted")
    server.send("g3", "failed")
    reports.wait(_ended_with("failed"), "the goal failed")
    connector.cancel_goal("g3")
    assert ("cancel", "g3") not in server.asked.all, "an ended goal is not canceled"


class StubbornServer(PatientServer):
    """An action server that refuses every cancel."""

    def cancel(self, goal_id: str) -> None:
        self.send(goal_id, "cancel_rejected")
        super().cancel(goal_id)


def _reports_a_refused_cancel(connector: Connector, action_type: str, goal: Data) -> None:
    server, reports = _sent(connector, action_type, goal, "g6", StubbornServer())
    server.send("g6", "accepted")
    reports.wait(_ended_with("accepted"), "the goal was accepted")
    connector.cancel_goal("g6")
    reports.wait(_ended_with("cancel_rejected"), "a refused cancel is reported, and is no end")
    server.send("g6", "succeeded")
    reports.wait(_ended_with("succeeded"), "the goal ends nevertheless")


def _refuses_a_second_offer(connector: Connector, action_type: str, *_: Any) -> None:
    close = connector.offer("/check/action", action_type, PatientServer())
    _is_refused(lambda: connector.offer("/check/action", action_type, PatientServer()))
    no_server: Any = print
    _is_refused(lambda: connector.offer("/check/other", action_type, no_server))
    close()
    connector.offer("/check/action", action_type, PatientServer())


def _refuses_to_serve_twice(connector: Connector, *_: Any) -> None:
    close = connector.serve("/check/service", TRIGGER, lambda request: request)
    _is_refused(lambda: connector.serve("/check/service", TRIGGER, lambda request: request))
    close()
    connector.serve("/check/service", TRIGGER, lambda request: request)


def _is_refused(serve: Callable[[], Any]) -> None:
    try:
        serve()
    except UsageError:
        return
    raise AssertionError("a second server on one name is refused")


def _rejects_what_no_server_offers(connector: Connector, action_type: str, goal: Data) -> None:
    reports: Inbox[Report] = Inbox()
    connector.send_goal("/check/none", action_type, goal, goal_id="g4", on_report=reports)
    (report,) = reports.wait(bool, "no server offers the action")
    assert report.status in ("rejected", "lost"), report


def _cancels_running_goals_on_stop(connector: Connector, action_type: str, goal: Data) -> None:
    server, _reports = _sent(connector, action_type, goal, "g5")
    server.send("g5", "accepted")
    connector.stop()
    assert ("cancel", "g5") in server.asked.all, "stop cancels the goals that run"


Check = Callable[[Connector, str, Data], None]
TOPICS: tuple[Check, ...] = (_receives_what_is_published, _receives_nothing_after_stop, _lists_its_topics)
SERVICES: tuple[Check, ...] = (
    _answers_a_call_once,
    _answers_a_call_later,
    _reports_why_a_call_failed,
    _reports_that_no_server_offers,
    _lists_what_is_served,
    _refuses_to_serve_twice,
)
ACTIONS: tuple[Check, ...] = (
    _carries_a_goal_to_its_end,
    _remembers_an_early_cancel,
    _ignores_a_cancel_of_nothing,
    _rejects_what_no_server_offers,
    _cancels_running_goals_on_stop,
    _lists_its_actions,
    _reports_a_refused_cancel,
    _refuses_a_second_offer,
)

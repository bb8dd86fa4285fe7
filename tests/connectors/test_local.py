# SPDX-License-Identifier: Apache-2.0
"""The in-process connector keeps the contract, and the promises of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Connector, Data, Message, Reply, Report
from rai_missions.connectors.contract import PatientServer, check_connector
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError, UsageError

STRING = "std_msgs/msg/String"


@pytest.fixture
def connector() -> LocalConnector:
    made = LocalConnector(now=lambda: 7.5)
    made.start()
    return made


def asked(connector: LocalConnector) -> tuple[PatientServer, list[Report]]:
    """A server that was sent the goal `g`, and what it reports of it."""
    server, reports = PatientServer(), list[Report]()
    connector.offer("/a", "", server)
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    return server, reports


def test_the_local_connector_keeps_the_contract() -> None:
    check_connector(LocalConnector)


@pytest.mark.parametrize("served", [True, False])
def test_a_goal_that_no_one_knows_runs_only_where_its_server_is_away(
    connector: LocalConnector, *, served: bool
) -> None:
    reports = list[Report]()
    if served:
        connector.offer("/a", "", PatientServer())
    connector.find_goal("/a", "", goal_id="g", on_report=reports.append)
    assert [(each.status, each.may_run) for each in reports] == [("lost", not served)]


def test_a_server_remembers_how_a_goal_ended_and_none_that_it_rejected(connector: LocalConnector) -> None:
    server, _ = asked(connector)
    server.send("g", "rejected")
    reports = list[Report]()
    connector.find_goal("/a", "", goal_id="g", on_report=reports.append)
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    server.send("g", "succeeded")
    connector.find_goal("/a", "", goal_id="g", on_report=reports.append)
    assert [each.status for each in reports] == ["lost", "accepted", "succeeded", "succeeded"]


def test_it_is_a_connector() -> None:
    assert isinstance(LocalConnector(), Connector)
    assert LocalConnector().modes == {"topics", "services", "actions"}


@given(st.lists(st.tuples(st.sampled_from(["/a", "/b"]), st.sampled_from(["", STRING, "std_msgs/msg/Bool"]))))
def test_each_topic_that_is_spoken_on_is_listed_with_the_first_type_that_is_given(given: list[tuple[str, str]]) -> None:
    connector, expected = LocalConnector(), dict[str, str]()
    connector.start()
    for topic, type_name in given:
        known = expected.get(topic) or type_name
        if type_name and known != type_name:
            with pytest.raises(ConnectorError, match=f"is a {known}, not a {type_name}"):
                connector.publish(topic, type_name, {})
        else:
            connector.publish(topic, type_name, {})
            expected[topic] = known
    assert connector.listed("topics") == expected


@pytest.mark.parametrize(
    ("message", "at"),
    [
        ({"data": "x"}, 7.5),
        ({"stamp": 3.25}, 3.25),
        ({"header": {"stamp": {"sec": -3600, "nanosec": 300_000_000}}}, -3599.7),
        ({"header": {"stamp": {"sec": 12, "nanosec": 300_000_000}}}, 7.5),
        ({"stamp": "noon"}, 7.5),
        ({"header": {"stamp": 4.0}}, 4.0),
        ({"header": {"frame_id": "map"}}, 7.5),
    ],
)
def test_a_message_is_as_old_as_its_own_stamp_and_never_from_the_future(
    connector: LocalConnector, message: dict[str, object], at: float
) -> None:
    received: list[Message] = []
    connector.subscribe("/t", "", received.append)
    connector.publish("/t", "", message)
    assert [(each.data, each.at) for each in received] == [(message, at)]


@pytest.mark.parametrize(("behind_s", "at"), [(3600.0, 7.5 - 3600), (0.5, 7.0), (-2.0, 7.5)])
def test_a_stamp_may_be_of_the_time_of_day(connector: LocalConnector, behind_s: float, at: float) -> None:
    received: list[Message] = []
    connector.subscribe("/t", "", received.append)
    connector.publish("/t", "", {"header": {"stamp": time.time() - behind_s}})
    assert received[0].at == pytest.approx(at, abs=0.3) and received[0].age_s == pytest.approx(behind_s, abs=0.3)


def test_a_reply_has_the_age_that_its_stamp_reports(connector: LocalConnector) -> None:
    replies: list[Reply] = []
    connector.serve("/s", "", lambda _request: {"stamp": 5.0})
    connector.call("/s", "", {}, on_reply=replies.append)
    assert replies[0].age_s == 2.5


def test_publishing_calls_subscribers_at_once_on_the_callers_thread(connector: LocalConnector) -> None:
    threads: list[int] = []
    connector.subscribe("/t", STRING, lambda _message: threads.append(threading.get_ident()))
    connector.publish("/t", STRING, {"data": "x"})
    assert threads == [threading.get_ident()]


@pytest.mark.parametrize("fault", [RuntimeError("broken ear"), SystemExit(0)])
def test_a_subscriber_that_fails_does_not_keep_the_message_from_the_others(
    connector: LocalConnector, caplog: pytest.LogCaptureFixture, fault: BaseException
) -> None:
    received: list[Message] = []

    def fail(_message: Message) -> None:
        raise fault

    connector.subscribe("/t", STRING, fail)
    connector.subscribe("/t", STRING, received.append)
    connector.publish("/t", STRING, {"data": "x"})
    assert len(received) == 1
    assert "a subscriber of /t failed" in caplog.text


def test_a_subscriber_closed_by_another_receives_nothing(connector: LocalConnector) -> None:
    received: list[Message] = []
    connector.subscribe("/t", STRING, lambda _message: close())
    close = connector.subscribe("/t", STRING, received.append)
    connector.publish("/t", STRING, {"data": "x"})
    assert received == []


def test_two_types_on_one_name_are_an_error_that_names_both(connector: LocalConnector) -> None:
    connector.subscribe("/t", STRING, lambda _message: None)
    with pytest.raises(ConnectorError, match="/t is a std_msgs/msg/String, not a std_msgs/msg/Int32"):
        connector.publish("/t", "std_msgs/msg/Int32", {"data": 1})
    replies: list[Reply] = []
    connector.serve("/s", "std_srvs/srv/Trigger", lambda _request: {})
    connector.call("/s", "std_srvs/srv/SetBool", {}, on_reply=replies.append)
    assert replies == [Reply("failed", {}, "/s is a std_srvs/srv/Trigger, not a std_srvs/srv/SetBool")]


def test_a_name_is_served_once(connector: LocalConnector) -> None:
    connector.serve("/s", "", lambda _request: {})
    connector.offer("/a", "", PatientServer())
    with pytest.raises(UsageError, match="/s is served already"):
        connector.serve("/s", "", lambda _request: {})
    with pytest.raises(UsageError, match="/a is served already"):
        connector.offer("/a", "", PatientServer())


def test_what_is_stopped_neither_receives_nor_answers() -> None:
    connector = LocalConnector()
    received: list[Message] = []
    replies: list[Reply] = []
    reports: list[Report] = []
    connector.subscribe("/t", "", received.append)
    connector.serve("/s", "", lambda _request: {})
    connector.offer("/a", "", PatientServer())
    connector.publish("/t", "", {})
    connector.call("/s", "", {}, on_reply=replies.append)
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    assert received == []
    assert replies == [Reply("unavailable", {}, "no server offers /s")]
    assert reports == [Report("g", "rejected", {}, "no server offers /a")]


def test_what_was_opened_before_the_start_works_after_it() -> None:
    connector = LocalConnector()
    received: list[Message] = []
    connector.subscribe("/t", "", received.append)
    connector.start()
    connector.publish("/t", "", {"data": 1})
    assert len(received) == 1


def test_a_goal_id_in_use_is_refused(connector: LocalConnector) -> None:
    connector.offer("/a", "", PatientServer())
    connector.send_goal("/a", "", {}, goal_id="g", on_report=lambda _report: None)
    with pytest.raises(UsageError, match="goal 'g' is still running"):
        connector.send_goal("/a", "", {}, goal_id="g", on_report=lambda _report: None)


class Unspeakable(Exception):
    """One that cannot state what it is."""

    def __str__(self) -> str:
        raise RuntimeError("not even that")


@pytest.mark.parametrize(
    ("error", "why"),
    [
        (RuntimeError("no motor"), "RuntimeError: no motor"),
        (Unspeakable(), "Unspeakable: a Unspeakable that cannot be put in words"),
        (SystemExit(0), "SystemExit: 0"),
    ],
)
def test_a_server_that_raises_rejects(connector: LocalConnector, error: BaseException, why: str) -> None:
    class Broken(PatientServer):
        def accept(self, goal_id: str, goal: object, report: object) -> None:
            raise error

    reports: list[Report] = []
    connector.offer("/a", "", Broken())
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    assert reports == [Report("g", "rejected", {}, why)]


def test_a_server_that_exits_at_a_cancel_refuses_it(connector: LocalConnector) -> None:
    class Leaving(PatientServer):
        def cancel(self, goal_id: str) -> None:
            raise SystemExit(0)

    server, reports = Leaving(), list[Report]()
    connector.offer("/a", "", server)
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    server.send("g", "accepted")
    connector.cancel_goal("g")
    assert reports[1:] == [Report("g", "cancel_rejected", {}, "SystemExit: 0")]


def test_a_service_that_exits_has_failed(connector: LocalConnector) -> None:
    replies: list[Reply] = []

    def leave(_: object) -> dict[str, object]:
        raise SystemExit(0)

    connector.serve("/s", "", leave)
    connector.call("/s", "", {}, on_reply=replies.append)
    assert [(reply.outcome, reply.why) for reply in replies] == [("failed", "SystemExit: 0")]


def test_an_end_without_acceptance_is_preceded_by_one(connector: LocalConnector) -> None:
    server, reports = asked(connector)
    server.send("g", "succeeded", {"x": 1})
    assert reports == [Report("g", "accepted", {}), Report("g", "succeeded", {"x": 1})]


def test_a_goal_that_was_accepted_fails_where_its_server_rejects_it_afterwards(connector: LocalConnector) -> None:
    server, reports = asked(connector)
    server.send("g", "accepted")
    server.send("g", "rejected")
    assert [report.status for report in reports] == ["accepted", "failed"]


def test_the_refusal_of_a_cancel_that_no_one_asked_for_is_dropped(connector: LocalConnector) -> None:
    server, reports = asked(connector)
    server.send("g", "accepted")
    server.send("g", "cancel_rejected")
    connector.cancel_goal("g")
    server.send("g", "cancel_rejected")
    assert [report.status for report in reports] == ["accepted", "cancel_rejected"]


def test_a_report_under_another_goals_id_is_dropped(connector: LocalConnector) -> None:
    server, reports = asked(connector)
    server.report["g"](Report("h", "succeeded", {}))
    assert reports == []


def test_goals_are_lost_when_their_server_goes_and_over_when_it_ends_them_later(connector: LocalConnector) -> None:
    server = PatientServer()
    reports: list[Report] = []
    close = connector.offer("/a", "", server)
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports.append)
    server.send("g", "accepted")
    close()
    close()
    server.send("g", "feedback")
    assert [report.status for report in reports] == ["accepted", "lost"]
    server.send("g", "succeeded")
    server.send("g", "succeeded")
    assert [report.status for report in reports] == ["accepted", "lost", "over"]


def test_a_cancel_from_inside_a_report_reaches_the_server_after_accept_returns(connector: LocalConnector) -> None:
    calls: list[str] = []

    class Eager(PatientServer):
        def accept(self, goal_id: str, goal: object, report: object) -> None:
            report(Report(goal_id, "accepted", {}))  # type: ignore[operator]
            calls.append("accept returns")

        def cancel(self, goal_id: str) -> None:
            calls.append("cancel")

    connector.offer("/a", "", Eager())
    connector.send_goal("/a", "", {}, goal_id="g", on_report=lambda report: connector.cancel_goal(report.goal_id))
    assert calls == ["accept returns", "cancel"]


def test_the_calls_of_a_server_come_one_after_the_other_from_many_threads(connector: LocalConnector) -> None:
    inside: list[int] = []
    seen: list[int] = []

    class Counting(PatientServer):
        def accept(self, goal_id: str, goal: object, report: object) -> None:
            inside.append(1)
            seen.append(len(inside))
            inside.pop()
            report(Report(goal_id, "accepted", {}))  # type: ignore[operator]
            report(Report(goal_id, "succeeded", {}))  # type: ignore[operator]

    reports: list[Report] = []
    connector.offer("/a", "", Counting())

    def send(name: str) -> None:
        for number in range(200):
            connector.send_goal("/a", "", {}, goal_id=f"{name}{number}", on_report=reports.append)

    threads = [threading.Thread(target=send, args=(name,)) for name in "abcd"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(seen) == {1}
    assert len(reports) == 1600


class Silent:
    """No server of an action: it has no `cancel`."""

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        """Take it."""


@pytest.mark.parametrize(("server", "given"), [
    (print, ", not <built-in function print>; write print(…)"),
    (None, ", not null"),
    (Silent(), "; it has no cancel"),
    (PatientServer, ">; write PatientServer(…)"),
])  # fmt: skip
def test_what_is_no_server_of_an_action_is_refused_where_it_is_offered(
    connector: LocalConnector, server: Any, given: str
) -> None:
    with pytest.raises(UsageError) as refused:
        connector.offer("/drive", "", server)
    what = "an object with accept(goal_id, goal, report) and cancel(goal_id)"
    assert str(refused.value).startswith(f"the action /drive takes {what}, not ")
    assert str(refused.value).endswith(given)
    connector.offer("/drive", "", PatientServer())


def test_what_is_no_function_serves_no_service(connector: LocalConnector) -> None:
    answer: Any = {"success": True}
    with pytest.raises(UsageError) as refused:
        connector.serve("/horn", "", answer)
    assert str(refused.value) == 'the service /horn takes a function of a request, not {"success": true}'


@pytest.mark.parametrize("is_later", [False, True])
@pytest.mark.parametrize(("answer", "kind"), [(None, "NoneType"), (True, "bool"), ("done", "str"), ([1], "list")])
def test_a_service_that_answers_with_no_fields_has_failed(
    connector: LocalConnector, answer: Any, kind: str, is_later: bool
) -> None:
    later, replies = Future[Any](), list[Reply]()
    connector.serve("/horn", "", lambda request: later if is_later else answer)
    connector.call("/horn", "", {}, on_reply=replies.append)
    if is_later:
        later.set_result(answer)
    (reply,) = replies
    assert (reply.outcome, reply.data) == ("failed", {})
    assert reply.why == f"/horn has answered with {kind}; return a dict of its fields, or {{}}"

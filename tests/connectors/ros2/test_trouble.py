# SPDX-License-Identifier: Apache-2.0
"""Whatever a graph brings: wrong types, NaN, enormous messages, clocks that jump, namesakes, strangers, silence."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.contract import Inbox, PatientServer
from rai_missions.errors import ConnectorError
from tests.connectors.ros2.peer_process import FIBONACCI, RUN, TRIGGER, Peer

STRING, NUMBER, BYTES = "std_msgs/msg/String", "std_msgs/msg/Float64", "std_msgs/msg/UInt8MultiArray"
HEADER, CLOCK = "std_msgs/msg/Header", "rosgraph_msgs/msg/Clock"
Open = Callable[..., Any]


class Warned(logging.Handler):
    """Collects what is logged."""

    def __init__(self) -> None:
        super().__init__()
        self.lines = Inbox[str](30.0)

    def emit(self, record: logging.LogRecord) -> None:
        self.lines(record.getMessage())

    def __enter__(self) -> Warned:
        logging.getLogger("rai_missions.connectors.ros2").addHandler(self)
        return self

    def __exit__(self, *_: object) -> None:
        logging.getLogger("rai_missions.connectors.ros2").removeHandler(self)


def until_listed(connector: Any, service: str) -> None:
    until, tick = time.monotonic() + 30.0, threading.Event()
    while service not in connector.listed("services"):
        assert time.monotonic() < until, f"{service} is not found"
        tick.wait(0.02)


def test_a_topic_of_another_type_is_not_received_and_one_sentence_states_it(open_ros: Open, peer: Peer) -> None:
    with Warned() as warned:
        received = Inbox[Message]()
        open_ros().subscribe("/peer/hasty", NUMBER, received)
        warned.lines.wait(
            lambda reported: (
                "/peer/hasty is published as std_msgs/msg/String, and so not received as the std_msgs/msg/Float64 that "
                "is asked for; mend the type" in reported
            ),
            "the types differ",
        )
    assert received.all == []


def test_a_latched_topic_that_is_read_as_another_is_reported_with_the_remedy(open_ros: Open, peer: Peer) -> None:
    with Warned() as warned:
        received = Inbox[Message]()
        open_ros().subscribe("/peer/latched", STRING, received)
        warned.lines.wait(
            lambda reported: (
                "/peer/latched is latched, and what was published before is not received; add to the connector: "
                '"qos": {"/peer/latched": {"durability": "latched"}}' in reported
            ),
            "it is published once, before",
        )
    assert received.all == []


@pytest.mark.usefixtures("alone")
def test_what_is_no_number_arrives_as_such(open_ros: Open) -> None:
    connector, received = open_ros(), Inbox[Message]()
    connector.subscribe("/number", NUMBER, received)
    for value in (math.nan, math.inf, -math.inf, 1.0):
        connector.publish("/number", NUMBER, {"data": value})
    reported = [message.data["data"] for message in received.wait(lambda all_: len(all_) == 4, "all were published")]
    assert math.isnan(reported[0]) and reported[1:] == [math.inf, -math.inf, 1.0]


@pytest.mark.usefixtures("alone")
def test_empty_and_enormous_messages_arrive_and_the_next_does_too(open_ros: Open) -> None:
    connector, received = open_ros(), Inbox[Message]()
    connector.subscribe("/bytes", BYTES, received)
    for size in (0, 20_000_000, 1):
        connector.publish("/bytes", BYTES, {"data": bytes(size)})
    messages = received.wait(lambda all_: len(all_) == 3, "nothing is too great")
    assert [len(message.data["data"]) for message in messages] == [0, 20_000_000, 1]


@pytest.mark.usefixtures("alone")
def test_the_runs_clock_stamps_what_is_received_however_ros_time_jumps(open_ros: Open) -> None:
    connector, received, clock = open_ros(sim_time=True, now=lambda: 50.0), Inbox[Message](), Inbox[Message]()
    connector.subscribe("/clock", CLOCK, clock)
    connector.subscribe("/stamped", HEADER, received)
    for ros_time, stamp, at in ((100.0, 98.0, 48.0), (10.0, 98.0, 50.0), (10.0, 9.0, 49.0), (1e9, 9.0, 50.0 - 1e9 + 9)):
        comes_to(connector, clock, ros_time)
        reported = len(received.all)
        connector.publish("/stamped", HEADER, {"stamp": stamp})
        messages = received.wait(lambda all_: len(all_) > reported, "it was published")  # noqa: B023 - asked at once
        assert messages[-1].at == pytest.approx(at)


def comes_to(connector: Any, clock: Inbox[Message], ros_time: float) -> None:
    """Have simulated time become so; the node takes it from a subscription of its own."""
    until = time.monotonic() + 30
    while connector._session.runtime.now() != ros_time:
        assert time.monotonic() < until, "the node does not take the time"
        reported = len(clock.all)
        connector.publish("/clock", CLOCK, {"clock": ros_time})
        clock.wait(lambda all_: len(all_) > reported, "time was published")  # noqa: B023 - asked at once


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("name", "rest"),
    [
        ("/legs/0/foot", " from '0/foot' on: topic name token must not start with a number"),
        ("/left leg", " from ' leg' on: topic name must not contain characters other than alphanumerics, "
         "'_', '~', '{', or '}'"),
        ("/left//leg", " from '/leg' on: topic name must not contain repeated '/'"),
        ("", ": topic name must not be empty string"),
    ],
)  # fmt: skip
def test_a_name_that_ros_does_not_take_is_reported_at_once(open_ros: Open, name: str, rest: str) -> None:
    connector, replies, reports = open_ros(), Inbox[Reply](), Inbox[Report]()
    sentence = f"{name!r} is no name in ROS{rest}"
    for use in (
        lambda: connector.subscribe(name, STRING, lambda _message: None),
        lambda: connector.publish(name, STRING, {"data": "x"}),
        lambda: connector.serve(name, TRIGGER, lambda request: request),
        lambda: connector.offer(name, FIBONACCI, PatientServer()),
    ):
        with pytest.raises(ConnectorError) as caught:
            use()
        assert str(caught.value) == sentence
    connector.call(name, TRIGGER, {}, on_reply=replies)
    connector.send_goal(name, FIBONACCI, {}, goal_id="g", on_report=reports)
    assert replies.all == [Reply("failed", {}, sentence)]
    assert reports.all == [Report("g", "rejected", {}, sentence)]


def test_two_nodes_of_one_name_both_work_and_one_sentence_states_it(open_ros: Open) -> None:
    with Warned() as warned:
        first, second, received = open_ros(node="twin"), open_ros(node="twin"), Inbox[Message]()
        first.subscribe("/twins", STRING, received)
        second.subscribe("/twins", STRING, received)
        second.publish("/twins", STRING, {"data": "x"})
        warned.lines.wait(
            lambda reported: (
                "another node is called /twin too: give connector/node another name, or leave it out" in reported
            ),
            "they have one name",
        )
    received.wait(lambda all_: len(all_) >= 1, "both are received")


@pytest.mark.usefixtures("alone")
def test_where_discovery_is_blocked_no_one_is_found_and_every_caller_learns_it(open_ros: Open, peer: Peer) -> None:
    connector, replies, reports = open_ros(discovery_s=0.5), Inbox[Reply](), Inbox[Report]()
    connector.call("/peer/trigger", TRIGGER, {}, on_reply=replies)
    connector.send_goal("/peer/fibonacci", FIBONACCI, {"order": RUN}, goal_id="g", on_report=reports)
    assert replies.wait(bool, "no one is found") == [Reply("unavailable", {}, "no server offers /peer/trigger")]
    assert reports.wait(bool, "no one is found") == [Report("g", "rejected", {}, "no server offers /peer/fibonacci")]


def test_an_action_of_another_type_is_reported_with_its_type(open_ros: Open, peer: Peer) -> None:
    other, reports = "test_msgs/action/NestedMessage", Inbox[Report]()
    connector = open_ros(discovery_s=1.0)
    until_listed(connector, "/peer/trigger")
    connector.send_goal("/peer/fibonacci", other, {}, goal_id="g", on_report=reports)
    why = f"/peer/fibonacci is served as {FIBONACCI}, and not as the {other} that is asked for; mend the type"
    assert reports.wait(bool, "no such server is there") == [Report("g", "rejected", {}, why)]


def test_a_service_of_another_type_is_reported_with_its_type(open_ros: Open, peer: Peer) -> None:
    connector, replies = open_ros(discovery_s=1.0), Inbox[Reply]()
    until_listed(connector, "/peer/trigger")
    connector.call("/peer/trigger", "std_srvs/srv/SetBool", {}, on_reply=replies)
    why = "/peer/trigger is served as std_srvs/srv/Trigger, and not as the std_srvs/srv/SetBool that is asked for"
    assert replies.wait(bool, "it is another") == [Reply("unavailable", {}, f"{why}; mend the type")]


def test_a_call_that_two_strangers_serve_is_answered_once(open_ros: Open) -> None:
    asker, replies, served = open_ros(), Inbox[Reply](), Inbox[str]()
    for name in ("one", "other"):

        def answer(_request: Any, name: str = name) -> dict[str, Any]:
            served(name)
            return {"success": True, "message": name}

        open_ros().serve("/contested", TRIGGER, answer)
    asker.call("/contested", TRIGGER, {}, on_reply=replies)
    replies.wait(bool, "one of them answers")
    asker.call("/contested", TRIGGER, {}, on_reply=replies)
    assert len(replies.wait(lambda all_: len(all_) == 2, "and again")) == 2


def test_a_stranger_who_cancels_everything_cancels_our_goal_and_that_is_reported(open_ros: Open) -> None:
    server, reports, stranger = PatientServer(), Inbox[Report](), Inbox[Reply]()
    connector = open_ros()
    connector.offer("/shared", FIBONACCI, server)
    connector.send_goal("/shared", FIBONACCI, {"order": 1}, goal_id="g", on_report=reports)
    server.asked.wait(bool, "it was sent")
    server.send("g", "accepted")
    reports.wait(bool, "it runs")
    open_ros().call("/shared/_action/cancel_goal", "action_msgs/srv/CancelGoal", {}, on_reply=stranger)
    server.asked.wait(lambda all_: ("cancel", "g") in all_, "a stranger may do that")
    server.send("g", "canceled")
    assert reports.wait(lambda all_: all_[-1].status == "canceled", "it is reported")[-1].goal_id == "g"


def test_a_publisher_that_vanishes_and_comes_back_is_received_again(open_ros: Open, own_peer: Peer) -> None:
    connector, received = open_ros(), Inbox[Message](30.0)
    connector.subscribe(f"/{own_peer.name}/hasty", STRING, received)
    received.wait(bool, "it speaks")
    own_peer.kill()
    with Peer(own_peer.name):
        reported = len(received.all)
        received.wait(lambda all_: len(all_) > reported + 3, "it speaks again")


@pytest.mark.usefixtures("alone")
def test_a_callback_that_does_not_return_keeps_no_one_waiting_for_ever(
    open_ros: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    connector, stuck, release = open_ros(), threading.Event(), threading.Event()

    def hang(_message: Message) -> None:
        stuck.set()
        release.wait(60)

    connector.subscribe("/stuck", STRING, hang)
    connector.publish("/stuck", STRING, {"data": "x"})
    assert stuck.wait(30)
    with monkeypatch.context() as soon:
        soon.setattr("rai_missions.connectors.ros2.node_thread.ANSWER_S", 0.5)
        with pytest.raises(ConnectorError, match="gives no answer: a callback does not return"):
            connector.listed("topics")
    release.set()
    assert "/stuck" in connector.listed("topics")


def test_five_connectors_of_one_process_receive_from_one_another(open_ros: Open) -> None:
    connectors, received = [open_ros() for _ in range(5)], Inbox[Message](30.0)
    for number, connector in enumerate(connectors):
        connector.subscribe(f"/five/n{(number + 1) % 5}", STRING, received)
    for number, connector in enumerate(connectors):
        connector.publish(f"/five/n{number}", STRING, {"data": str(number)})
    received.wait(
        lambda all_: {message.data["data"] for message in all_} == set("01234"), "each receives its neighbour"
    )
    connectors[0].stop()
    reported = len(received.all)
    connectors[3].publish("/five/n3", STRING, {"data": "3"})
    received.wait(lambda all_: len(all_) > reported, "the others continue")

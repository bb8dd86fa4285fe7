# SPDX-License-Identifier: Apache-2.0
"""What the middleware notifies of, and the same connector where it does not."""

from __future__ import annotations

import errno
import os
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message, Reply
from rai_missions.connectors.contract import Inbox, check_connector
from rai_missions.connectors.ros2 import open_connector

STRING, NUMBER, TRIGGER = "std_msgs/msg/String", "std_msgs/msg/Int32", "std_srvs/srv/Trigger"
TOPICS = 4
Open = Callable[..., Any]

pytestmark = pytest.mark.usefixtures("alone")


@pytest.fixture
def unnotified(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine on which there are no notifications."""
    from rai_missions.connectors.ros2 import notifications

    monkeypatch.setattr(notifications.sys, "platform", "freebsd")


@pytest.mark.long
@pytest.mark.usefixtures("unnotified")
def test_without_notifications_it_keeps_the_contract() -> None:
    made: list[Any] = []

    def open_one() -> Any:
        made.append(open_connector({"discovery_s": 2.0}))
        return made[-1]

    check_connector(open_one)
    made[-1].start()
    assert made[-1]._session.runtime._executor._notifications is None, "the wait set was what was tried"
    made[-1].stop()


@pytest.mark.usefixtures("unnotified")
def test_without_notifications_a_loud_topic_silences_no_other(open_ros: Open) -> None:
    from tests.connectors.ros2.test_turns import test_a_loud_topic_does_not_silence_the_one_that_was_subscribed_after_it

    test_a_loud_topic_does_not_silence_the_one_that_was_subscribed_after_it(open_ros)


@pytest.fixture(scope="module")
def numbers(ros: None) -> Any:
    """A connector that listens to topics, with what it has received of each."""
    connector = open_connector({"qos": {f"/notified/t{topic}": {"depth": 1000} for topic in range(TOPICS)}})
    connector.start()
    inboxes = [Inbox[Message]() for _ in range(TOPICS)]
    for topic, inbox in enumerate(inboxes):
        connector.subscribe(f"/notified/t{topic}", NUMBER, inbox)
        connector.publish(f"/notified/t{topic}", NUMBER, {"data": -1})
    for inbox in inboxes:
        inbox.wait(bool, "its publisher has found its reader")
    yield connector, inboxes
    connector.stop()


@given(order=st.lists(st.integers(0, TOPICS - 1), max_size=60))
@settings(max_examples=30)
def test_every_message_of_every_topic_arrives_in_its_order(numbers: Any, order: list[int]) -> None:
    from rai_missions.connectors.ros2 import executor

    connector, inboxes = numbers
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(executor, "SWEEP_S", 1e9)  # no look at everyone helps what is not counted
        check_order(connector, inboxes, order)


def check_order(connector: Any, inboxes: list[Inbox[Message]], order: list[int]) -> None:
    before = [len(inbox.all) for inbox in inboxes]
    for number, topic in enumerate(order):
        connector.publish(f"/notified/t{topic}", NUMBER, {"data": number})
    for topic, inbox in enumerate(inboxes):
        expected = [number for number, each in enumerate(order) if each == topic]
        wanted = before[topic] + len(expected)
        if expected:
            inbox.wait(lambda all_: len(all_) >= wanted, "all arrived")  # noqa: B023 - asked at once
        assert [message.data["data"] for message in inbox.all[before[topic] :]] == expected


def test_where_files_are_shared_every_party_is_looked_at(open_ros: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    from rai_missions.connectors.ros2 import executor, notifications

    monkeypatch.setattr(notifications, "MOST_FILES", 3)
    monkeypatch.setattr(executor, "SWEEP_S", 1e9)
    connector, received = open_ros(), Inbox[Message]()
    for number in range(20):
        connector.subscribe(f"/crowded/t{number}", STRING, received)
        connector.publish(f"/crowded/t{number}", STRING, {"data": str(number)})
    all_of_them = received.wait(lambda all_: len(all_) == 20, "each of them was received")
    for number in range(20):  # all are known: no look at everyone follows any more
        connector.publish(f"/crowded/t{number}", STRING, {"data": str(number)})
    all_of_them = received.wait(lambda all_: len(all_) == 40, "each of them was received again")
    assert Counter(message.topic for message in all_of_them) == {f"/crowded/t{number}": 2 for number in range(20)}
    files = connector._session.runtime._executor._notifications._parties
    assert len(files) == 3 and max(len(parties) for parties in files.values()) > 5


def test_what_no_one_was_notified_of_is_found_by_the_next_sweep(open_ros: Open) -> None:
    connector, received = open_ros(), Inbox[Message]()
    connector.subscribe("/unnoticed", STRING, received)
    connector.publish("/unnoticed", STRING, {"data": "first"})
    received.wait(bool, "it is known")
    runtime = connector._session.runtime

    def lose_notifications() -> None:
        found = runtime._executor._notifications
        for _, sources in found._sources.values():
            for kind, pointer in sources:
                assert found._set[kind](pointer, None, None) == 0

    runtime.ask(lose_notifications, None)
    connector.publish("/unnoticed", STRING, {"data": "second"})
    assert received.wait(lambda all_: len(all_) == 2, "found")[-1].data["data"] == "second"


def test_one_sweep_finds_all_that_no_one_was_notified_of(open_ros: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    from rai_missions.connectors.ros2 import executor

    monkeypatch.setattr(executor, "SWEEP_S", 1e9)
    connector, received = open_ros(qos={"/swept": {"depth": 50}}), Inbox[Message]()
    connector.subscribe("/swept", STRING, received)
    connector.publish("/swept", STRING, {"data": "first"})
    received.wait(bool, "it is known")
    runtime = connector._session.runtime

    def lose_what_was_counted() -> None:
        """As where an entity is found destroyed."""
        spinning = runtime._executor
        spinning._counts.clear()
        while any(spinning._notifications.wait(0.2)):
            spinning._counts.clear()
        spinning._is_sweep_due_at = 0.0

    for number in range(25):
        connector.publish("/swept", STRING, {"data": str(number)})
    runtime.ask(lose_what_was_counted, None)
    received.wait(lambda all_: len(all_) == 26, "all of them were found")


def test_where_no_more_files_can_be_waited_for_others_are_shared_and_none_is_left_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from rai_missions.connectors.ros2.notifications import Notifications

    class FullPoll:
        """An epoll of a system in which no more files may be waited for."""

        def register(self, _file: int, _events: int) -> None:
            raise OSError(errno.ENOSPC, "no space")

    found = Notifications()
    poll, opened = found._poll, len(os.listdir("/proc/self/fd"))
    monkeypatch.setattr(found, "_poll", FullPoll())
    for party in range(3):
        assert found.add(party, [])
    assert {file for file, _ in found._sources.values()} == {found._shared}
    assert len(os.listdir("/proc/self/fd")) == opened
    monkeypatch.setattr(found, "_poll", poll)
    os.eventfd_write(found._shared, 1)
    assert found.wait(0.0) == {0: 1, 1: 1, 2: 1}
    found.close()


def test_a_callback_that_raises_loses_none_of_the_messages_behind_its_own(open_ros: Open) -> None:
    connector, received = open_ros(), []
    done, inbox = Inbox[Message](), Inbox[Message]()
    connector.subscribe("/start", STRING, inbox)
    connector.publish("/start", STRING, {"data": "found"})
    inbox.wait(bool, "found")
    executor = connector._session.runtime._executor

    class Party:
        """Counts as one who has three things to be taken."""

    def take(_party: Party) -> bool:
        received.append(len(received))
        if len(received) == 2:
            raise RuntimeError("broken")
        return True

    def try_it() -> None:
        party = Party()
        executor._takes[party], executor._ranks[party], executor._counts[party] = take, 0, 3

    connector._session.runtime.ask(try_it, None)
    connector.subscribe("/start", STRING, done)
    connector.publish("/start", STRING, {"data": "again"})
    done.wait(bool, "rounds followed")
    assert received == [0, 1, 2]


def test_a_stop_leaves_no_file_and_no_entity_that_notifies(open_ros: Open) -> None:
    def files() -> int:
        return sum(
            "eventfd" in os.readlink(f"/proc/self/fd/{each}") for each in os.listdir("/proc/self/fd") if _is_there(each)
        )

    before, connector, replies = files(), open_ros(), Inbox[Reply]()
    for number in range(5):
        connector.subscribe(f"/left/t{number}", STRING, lambda _message: None)
    connector.serve("/left/call", TRIGGER, lambda _request: {})
    connector.call("/left/call", TRIGGER, {}, on_reply=replies)
    replies.wait(bool, "answered")
    found = connector._session.runtime._executor._notifications
    assert files() >= before + 8, "each party has a file of its own"
    connector.stop()
    assert files() == before and not tuple(found)
    found.ring()  # of no effect: a late thread may still do so


def test_a_topic_that_is_left_is_forgotten_and_one_that_is_joined_again_is_received(open_ros: Open) -> None:
    connector = open_ros()
    found = connector._session.runtime._executor._notifications
    counts = set()
    for turn in range(10):
        received = Inbox[Message]()
        close = connector.subscribe("/coming", STRING, received)
        connector.publish("/coming", STRING, {"data": str(turn)})
        assert received.wait(bool, "received")[-1].data["data"] == str(turn)
        close()
        connector._session.runtime.ask(lambda: None, None)
        connector._session.runtime.ask(lambda: None, None)
        counts.add((len(tuple(found)), len(found._parties)))
    assert len(counts) <= 2, f"nothing grows: {counts}"


def _is_there(number: str) -> bool:
    return os.path.lexists(f"/proc/self/fd/{number}")

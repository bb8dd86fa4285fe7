# SPDX-License-Identifier: Apache-2.0
"""Many who listen to one topic share its reader, and none of them notices."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Close, Message, RawMessage
from rai_missions.connectors.contract import Inbox

STRING = "std_msgs/msg/String"
LATCHED = {"/last": {"durability": "latched", "depth": 2}}
Open = Callable[..., Any]
alone = pytest.mark.usefixtures("alone")


def readers(connector: Any, topic: str) -> int:
    """How many readers of a topic there are on the wire."""
    runtime = connector._session.runtime
    return len(runtime.ask(lambda: runtime.node.get_subscriptions_info_by_topic(topic), []))


def comes_to(connector: Any, topic: str, count: int) -> None:
    tick = threading.Event()
    for _ in range(3000):
        if readers(connector, topic) == count:
            return
        tick.wait(0.01)
    raise AssertionError(f"{topic} has {readers(connector, topic)} readers, not {count}")


def texts(received: list[Message]) -> list[str]:
    return [each.data["data"] for each in received]


def listen(connector: Any, topic: str, *, is_raw: bool = False) -> tuple[Inbox[Message], Close]:
    received = Inbox[Message]()
    if is_raw:
        return received, connector.tap(topic, STRING, received, lambda _raw: None)
    return received, connector.subscribe(topic, STRING, received)


@alone
def test_a_hundred_listeners_of_a_topic_are_one_reader_and_receive_one_message(open_ros: Open) -> None:
    connector = open_ros()
    listeners = [listen(connector, "/shared")[0] for _ in range(100)]
    connector.publish("/shared", STRING, {"data": "x"})
    received = [each.wait(bool, "it was published")[0] for each in listeners]
    assert readers(connector, "/shared") == 1
    assert all(each is received[0] for each in received), "it is converted once"


@alone
def test_a_recorder_has_a_reader_of_the_bytes_next_to_the_other(open_ros: Open) -> None:
    connector, raw = open_ros(), Inbox[RawMessage]()
    plain = [listen(connector, "/shared")[0] for _ in range(3)]
    tapped = Inbox[Message]()
    for _ in range(3):
        connector.tap("/shared", STRING, tapped, raw)
    comes_to(connector, "/shared", 2)
    connector.publish("/shared", STRING, {"data": "x"})
    for each in plain:
        assert texts(each.wait(bool, "it was published")) == ["x"]
    assert texts(tapped.wait(lambda all_: len(all_) == 3, "each tap")) == ["x"] * 3
    assert {each.data for each in raw.wait(lambda all_: len(all_) == 3, "each tap")} == {raw.all[0].data}


@alone
def test_who_leaves_receives_no_more_and_the_others_do_until_the_last_has_left(open_ros: Open) -> None:
    connector = open_ros()
    (first, leave_first), (second, leave_second) = listen(connector, "/shared"), listen(connector, "/shared")
    connector.publish("/shared", STRING, {"data": "one"})
    first.wait(bool, "both listen")
    leave_first()
    leave_first()
    connector.publish("/shared", STRING, {"data": "two"})
    second.wait(lambda all_: len(all_) == 2, "one still listens")
    assert texts(first.all) == ["one"]
    leave_second()
    comes_to(connector, "/shared", 0)
    third, _ = listen(connector, "/shared")
    connector.publish("/shared", STRING, {"data": "three"})
    third.wait(bool, "a topic that was left can be listened to again")


@alone
@pytest.mark.parametrize("is_raw", [False, True])
def test_who_joins_a_latched_topic_late_receives_what_was_published_last(open_ros: Open, is_raw: bool) -> None:
    connector = open_ros(qos=LATCHED)
    first, _ = listen(connector, "/last", is_raw=is_raw)
    for count, text in enumerate(("one", "two", "three"), 1):
        connector.publish("/last", STRING, {"data": text})
        first.wait(lambda all_: len(all_) == count, "it listens")  # noqa: B023 - asked at once
    late, _ = listen(connector, "/last", is_raw=is_raw)
    assert texts(late.wait(lambda all_: len(all_) == 2, "as many as are kept")) == ["two", "three"]
    connector.publish("/last", STRING, {"data": "four"})
    late.wait(lambda all_: len(all_) == 3, "and what is published next")
    assert readers(connector, "/last") == 1
    assert texts(first.all) == ["one", "two", "three", "four"], "no listener receives anything twice"


@alone
def test_who_joins_another_topic_late_receives_nothing_of_before(open_ros: Open) -> None:
    connector = open_ros()
    first, _ = listen(connector, "/shared")
    connector.publish("/shared", STRING, {"data": "one"})
    first.wait(bool, "it listens")
    late, _ = listen(connector, "/shared")
    connector.publish("/shared", STRING, {"data": "two"})
    assert texts(late.wait(bool, "it listens from now on")) == ["two"]


def test_what_a_vanished_publisher_had_published_is_not_delivered_to_a_later_listener(open_ros: Open) -> None:
    connector, other = open_ros(qos=LATCHED), open_ros(qos=LATCHED)
    first, _ = listen(connector, "/last")
    other.publish("/last", STRING, {"data": "one"})
    first.wait(bool, "it is published")
    other.stop()
    runtime, tick = connector._session.runtime, threading.Event()
    while runtime.ask(lambda: runtime.node.get_publishers_info_by_topic("/last"), []):
        tick.wait(0.01)
    late, _ = listen(connector, "/last")
    connector.publish("/last", STRING, {"data": "two"})
    first.wait(lambda all_: len(all_) == 2, "another publishes")
    assert texts(late.wait(bool, "it receives what is published now")) == ["two"]

# SPDX-License-Identifier: Apache-2.0
"""Publishers of two qualities on one topic: each is received, and the worse takes nothing from the better."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox

Open = Callable[..., Any]
STRING = "std_msgs/msg/String"
WORSE = {"/orders": {"reliability": "best_effort"}}


def words(received: Inbox[Message]) -> list[str]:
    return [message.data["data"] for message in received.all]


def reliabilities(node: Any, topic: str) -> list[str]:
    return sorted(each.qos_profile.reliability.name for each in node.get_subscriptions_info_by_topic(topic))


def test_a_best_effort_publisher_degrades_no_other_publisher_on_its_topic(open_ros: Open) -> None:
    ours, good, worse = open_ros(), open_ros(), open_ros(qos=WORSE)
    received: Inbox[Message] = Inbox()
    ours.subscribe("/orders", STRING, received)
    good.publish("/orders", STRING, {"data": "first"})
    received.wait(lambda _all: "first" in words(received), "the reliable one is received")
    worse.publish("/orders", STRING, {"data": "worse"})
    received.wait(lambda _all: "worse" in words(received), "the best-effort one is received too")
    for number in range(9):
        good.publish("/orders", STRING, {"data": str(number)})
    received.wait(lambda _all: "8" in words(received), "all orders")
    assert [each for each in words(received) if each.isdecimal()] == [str(number) for number in range(9)]
    node = ours._session.runtime.node
    found = ours._session.runtime.ask(lambda: reliabilities(node, "/orders"), [])
    assert "RELIABLE" in found, "the reliable publisher is still read reliably"


def test_where_all_publish_with_best_effort_one_reader_is_enough(open_ros: Open) -> None:
    ours, worse = open_ros(), open_ros(qos=WORSE)
    received: Inbox[Message] = Inbox()
    ours.subscribe("/orders", STRING, received)
    worse.publish("/orders", STRING, {"data": "only"})
    received.wait(bool, "it is received")
    assert words(received) == ["only"]


delays = st.none() | st.floats(0.0, 0.04)
messages = st.lists(st.tuples(st.booleans(), delays, st.floats(0.0, 0.04) | st.floats(0.06, 0.3)), max_size=12)


@given(messages)
def test_two_readers_deliver_each_message_once_and_reliable_in_order(
    given_: list[tuple[bool, Any, float]],
) -> None:
    """Published 10 ms apart by a reliable and by a best-effort publisher, whose messages may be lost on their way."""
    from rai_missions.connectors.ros2.mixed import MessageSorter

    queue: list[tuple[float, int, Any]] = []
    now, numbers = [0.0], itertools.count(10_000)
    results: list[int] = []
    mixed = MessageSorter(
        lambda delay_s, work: heapq.heappush(queue, (now[0] + delay_s, next(numbers), work)),
        lambda message, _info: results.append(message),
        lambda: 1,
    )
    arrives = 0.0
    for number, (is_reliable, loose_s, delay_s) in enumerate(given_):
        info = {"source_timestamp": 1 + number, "publication_sequence_number": 7}
        sent = number * 0.01
        if is_reliable:
            arrives = max(arrives, sent + delay_s)
            heapq.heappush(queue, (arrives, number, lambda m=number, i=info: mixed.receive_reliably(m, i)))
        if loose_s is not None:
            heapq.heappush(queue, (sent + loose_s, 1000 + number, lambda m=number, i=info: mixed.receive(m, i)))
    while queue:
        now[0], _, work = heapq.heappop(queue)
        work()
    reached = {number for number, (is_reliable, loose_s, _) in enumerate(given_) if is_reliable or loose_s is not None}
    assert sorted(results) == sorted(reached), "each once"
    reliable = [number for number in results if given_[number][0]]
    if all(delay_s <= 0.04 for _, _, delay_s in given_):  # none was sent again
        assert reliable == sorted(reliable), "in the order in which they were published"

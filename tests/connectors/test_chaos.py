# SPDX-License-Identifier: Apache-2.0
"""A bad connection is as bad as it reports: each thing that it does to what passes, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Reply
from rai_missions.connectors.contract import PatientServer, check_connector
from rai_missions.connectors.local import LocalConnector
from rai_missions.testing import ChaosConnector, Rates

QUIET: dict[str, float] = {"lose": 0, "delay": 0, "repeat": 0, "backdate": 0, "garble": 0}
NUMBER, TRIGGER, ACTION = "std_msgs/msg/Float64", "std_srvs/srv/Trigger", "x/action/X"
MESSAGES = 200


def rates(**words: float) -> Rates:
    return Rates(**{**QUIET, **words})


class Line:
    """A bad connection, and what has been put off on it.

    Args:
        seed: What befalls what follows from it.
        words: The rates, both ways.
    """

    def __init__(self, seed: int = 5, **words: float) -> None:
        self.put_off: list[tuple[float, Callable[[], None]]] = []
        self.local = LocalConnector(now=lambda: 10.0)
        self.chaos = ChaosConnector(
            self.local,
            seed,
            incoming=rates(**words),
            outgoing=rates(**words),
            later=lambda seconds, do: self.put_off.append((seconds, do)),
        )
        self.chaos.start()

    def receive(self, count: int = MESSAGES) -> list[Message]:
        """What arrives of so many messages that are published behind it, without what was put off."""
        received: list[Message] = []
        self.chaos.subscribe("/n", NUMBER, received.append)
        for number in range(count):
            self.local.publish("/n", NUMBER, {"data": float(number)})
        return received

    def let_come(self) -> None:
        """What was put off comes, each when its time has come."""
        for _, do in sorted(self.put_off, key=lambda each: each[0]):
            do()


def numbers(received: list[Message]) -> list[Any]:
    return [message.data["data"] for message in received]


def test_one_to_which_nothing_befalls_keeps_the_contract() -> None:
    check_connector(lambda: ChaosConnector(LocalConnector(), 5, incoming=rates(), outgoing=rates()))


def test_it_loses_some_and_keeps_the_order_of_the_rest() -> None:
    received = numbers(Line(lose=0.3).receive())
    assert 100 < len(received) < 180 and received == sorted(received)


def test_it_repeats_some() -> None:
    received = numbers(Line(repeat=0.3).receive())
    assert sorted(set(received)) == [float(number) for number in range(MESSAGES)]
    assert 230 < len(received) < 290 and max(received.count(number) for number in received) == 2


def test_what_it_delays_is_overtaken_and_comes() -> None:
    line = Line(delay=0.3)
    received = line.receive()
    assert 100 < len(received) < 180
    assert all(0 <= seconds <= 1 for seconds, _ in line.put_off)
    line.let_come()
    assert sorted(numbers(received)) == [float(number) for number in range(MESSAGES)]
    assert numbers(received) != sorted(numbers(received)), "in another order"


def test_what_it_backdates_is_as_it_was_and_up_to_a_second_older() -> None:
    received = Line(backdate=0.3).receive()
    old = [message for message in received if message.at != 10.0]
    assert 30 < len(old) < 90 and all(9.0 <= message.at < 10.0 for message in old)
    assert numbers(received) == [float(number) for number in range(MESSAGES)]


def test_what_it_garbles_is_of_another_type_or_no_number() -> None:
    received = Line(garble=0.3).receive()
    wrong = [each for each in numbers(received) if not isinstance(each, float) or not math.isfinite(each)]
    assert 30 < len(wrong) < 90 and len({repr(each) for each in wrong}) > 5


def test_a_topic_that_it_silences_has_nothing_more_to_state_and_others_have() -> None:
    line = Line(silence=0.05)
    received = numbers(line.receive())
    assert received == [float(number) for number in range(len(received))] and len(received) < MESSAGES
    assert line.receive(1) == [], "for good"
    others: list[Message] = []
    line.chaos.subscribe("/m", NUMBER, others.append)
    line.local.publish("/m", NUMBER, {"data": 1.0})
    assert others


def test_of_what_it_sends_out_the_same_befalls() -> None:
    line = Line(lose=0.3)
    received: list[Message] = []
    line.local.subscribe("/n", NUMBER, received.append)
    for number in range(MESSAGES):
        line.chaos.publish("/n", NUMBER, {"data": float(number)})
    assert 100 < len(received) < 180


def test_a_call_whose_reply_is_lost_has_timed_out_where_a_time_was_set_and_else_never_ends() -> None:
    line, replies = Line(lose=1), list[Reply]()
    line.local.serve("/s", TRIGGER, lambda _: {"success": True})
    line.chaos.call("/s", TRIGGER, {}, on_reply=replies.append, timeout_s=2.0)
    line.chaos.call("/s", TRIGGER, {}, on_reply=replies.append)
    line.let_come()
    assert [reply.outcome for reply in replies] == ["timed_out"]


def test_a_goal_that_it_repeats_is_one_goal_whose_reports_come_twice() -> None:
    line, server, reported = Line(repeat=1), PatientServer(), list[str]()
    line.local.offer("/a", ACTION, server)
    line.chaos.send_goal("/a", ACTION, {}, goal_id="g", on_report=lambda report: reported.append(report.status))
    server.send("g", "accepted")
    assert len(server.goals) == 1 and reported == ["accepted", "accepted"]


@pytest.mark.parametrize("seed", range(3))
def test_what_befalls_follows_from_the_seed(seed: int) -> None:
    words = {"lose": 0.2, "delay": 0.2, "repeat": 0.2, "backdate": 0.2}
    assert Line(seed, **words).receive() == Line(seed, **words).receive() != Line(seed + 1, **words).receive()

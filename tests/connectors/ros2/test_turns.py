# SPDX-License-Identifier: Apache-2.0
"""Every subscription has its turn, however much there is to receive on another."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox

NUMBER, CLOCK = "std_msgs/msg/Int32", "rosgraph_msgs/msg/Clock"
BEFORE, ENOUGH = 50, 500
A_FEW = 20
"""How often what is loud may be received before what is quiet; one turn each would be two or three."""


@pytest.mark.usefixtures("alone")
def test_a_loud_topic_does_not_silence_the_one_that_was_subscribed_after_it(open_ros: Callable[..., Any]) -> None:
    """The listener of what is loud is loud again before it returns, so that it always is the first that is ready."""
    ear, received, over = open_ros(), 0, threading.Event()
    loud_before_quiet: list[int] = []

    def on_loud(_message: Message) -> None:
        nonlocal received
        received += 1
        if received == BEFORE:
            ear.publish("/quiet", NUMBER, {"data": 2})
        if received < ENOUGH:
            ear.publish("/loud", NUMBER, {"data": 1})
        else:
            over.set()

    ear.subscribe("/loud", NUMBER, on_loud)
    ear.subscribe("/quiet", NUMBER, lambda _message: loud_before_quiet.append(received - BEFORE))
    # While a server is looked for, the connector waits for ever other spans of time.
    ear.call("/no_one", "std_srvs/srv/Trigger", {}, on_reply=lambda _reply: None)
    ear.publish("/quiet", NUMBER, {"data": 0})  # its publisher has found its reader once this is received
    while not loud_before_quiet:
        over.wait(0.01)
    loud_before_quiet.clear()
    ear.publish("/loud", NUMBER, {"data": 1})
    assert over.wait(60), f"received {received} times"
    assert loud_before_quiet and loud_before_quiet[0] <= A_FEW


@pytest.mark.usefixtures("alone")
def test_time_does_not_advance_before_what_was_published_until_then_is_received(open_ros: Callable[..., Any]) -> None:
    """A listener that was held up for a while would else take what was published meanwhile for silence."""
    ear, received, stalled, release = open_ros(), Inbox[tuple[str, int]](), threading.Event(), threading.Event()

    def stall(_message: Message) -> None:
        stalled.set()
        release.wait(60)

    def on_time(message: Message) -> None:
        received(("time", int(message.data["clock"]["sec"])))

    ear.subscribe("/clock", CLOCK, on_time)
    ear.subscribe("/number", NUMBER, lambda message: received(("number", message.data["data"])))
    ear.subscribe("/stall", NUMBER, stall)
    for name, type_name, reported in (("/clock", CLOCK, {"clock": 1}), ("/number", NUMBER, {"data": 0})):
        ear.publish(name, type_name, reported)
    received.wait(lambda all_: len(all_) == 2, "both publishers have found their reader")
    publishers = ear._session._publications
    ear.publish("/stall", NUMBER, {"data": 1})
    assert stalled.wait(30)
    # From here the connector's thread is held up: what is published now waits in the readers' queues.
    clock, reported = publishers["/clock"]._publisher, publishers["/number"]._publisher
    time = clock.msg_type()
    time.clock.sec = 2
    clock.publish(time)
    for number in (2, 3, 4):
        reported.publish(reported.msg_type(data=number))
    release.set()
    results = received.wait(lambda all_: ("time", 2) in all_ and ("number", 4) in all_, "all was published")
    assert results[-4:] == [("number", 2), ("number", 3), ("number", 4), ("time", 2)]

# SPDX-License-Identifier: Apache-2.0
"""Every subscription has its turn, however much there is to hear on another."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message

NUMBER = "std_msgs/msg/Int32"
BEFORE, ENOUGH = 50, 500
A_FEW = 20
"""How often what is loud may be heard before what is quiet; one turn each would be two or three."""


@pytest.mark.usefixtures("alone")
def test_a_loud_topic_does_not_silence_the_one_that_was_subscribed_after_it(open_ros: Callable[..., Any]) -> None:
    """Whoever hears what is loud is loud again before it returns, so that it always is the first who is ready."""
    ear, heard, over = open_ros(), 0, threading.Event()
    loud_before_quiet: list[int] = []

    def hear_loud(_message: Message) -> None:
        nonlocal heard
        heard += 1
        if heard == BEFORE:
            ear.publish("/quiet", NUMBER, {"data": 2})
        if heard < ENOUGH:
            ear.publish("/loud", NUMBER, {"data": 1})
        else:
            over.set()

    ear.subscribe("/loud", NUMBER, hear_loud)
    ear.subscribe("/quiet", NUMBER, lambda _message: loud_before_quiet.append(heard - BEFORE))
    # While somebody is looked for, the connector waits for ever other spans of time.
    ear.call("/nobody", "std_srvs/srv/Trigger", {}, answered=lambda _reply: None)
    ear.publish("/quiet", NUMBER, {"data": 0})  # its publisher has found its reader once this is heard
    while not loud_before_quiet:
        over.wait(0.01)
    loud_before_quiet.clear()
    ear.publish("/loud", NUMBER, {"data": 1})
    assert over.wait(60), f"heard {heard} times"
    assert loud_before_quiet and loud_before_quiet[0] <= A_FEW

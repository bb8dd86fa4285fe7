# SPDX-License-Identifier: Apache-2.0
"""Every subscription has its turn, however much there is to hear on another."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Heard


def test_a_loud_topic_does_not_silence_the_one_that_was_subscribed_after_it(open_ros: Callable[..., Any]) -> None:
    robot, ear = open_ros(), open_ros(discovery_s=60.0)
    loud, quiet, over = Heard[Message](30.0), Heard[Message](30.0), threading.Event()

    def hear(message: Message) -> None:
        loud(message)
        over.wait(0.002)  # somebody who takes longer than it takes to be loud again

    ear.subscribe("/loud", "std_msgs/msg/Int32", hear)
    ear.subscribe("/quiet", "std_msgs/msg/Int32", quiet)

    def shout() -> None:
        while not over.wait(0.0005):
            robot.publish("/loud", "std_msgs/msg/Int32", {"data": 1})

    # While somebody is looked for, the connector waits for ever other spans of time.
    ear.call("/nobody", "std_srvs/srv/Trigger", {}, answered=lambda _reply: None)
    shouting = threading.Thread(target=shout)
    shouting.start()
    try:
        loud.wait(lambda heard: len(heard) > 50, "what is loud")
        robot.publish("/quiet", "std_msgs/msg/Int32", {"data": 2})
        quiet.wait(lambda heard: len(heard) == 1, "what is quiet")
    finally:
        over.set()
        shouting.join()

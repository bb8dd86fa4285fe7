# SPDX-License-Identifier: Apache-2.0
"""A map that was published before anyone listened is received, and so is one whose publisher latches nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox

Open = Callable[..., Any]
GRID = "nav_msgs/msg/OccupancyGrid"


def frames(received: Inbox[Message]) -> list[str]:
    return [message.data["header"]["frame_id"] for message in received.all]


def grid(frame: str) -> dict[str, Any]:
    return {"header": {"frame_id": frame}}


def test_a_map_that_was_latched_before_is_received(open_ros: Open) -> None:
    server, ours = open_ros(qos={"/map": {"durability": "latched", "depth": 1}}), open_ros()
    other: Inbox[Message] = Inbox()
    server.subscribe("/map", GRID, other)
    server.publish("/map", GRID, grid("early"))
    other.wait(bool, "it is published")
    received: Inbox[Message] = Inbox()
    ours.subscribe("/map", GRID, received)
    received.wait(bool, "the map from before")
    assert frames(received) == ["early"]


@pytest.mark.parametrize("reliability", ["reliable", "best_effort"])
def test_a_map_whose_publisher_latches_nothing_is_received(open_ros: Open, reliability: str) -> None:
    quality = {"/map": {"durability": "volatile", "reliability": reliability}}
    server, ours = open_ros(qos=quality), open_ros()
    received: Inbox[Message] = Inbox()
    ours.subscribe("/map", GRID, received)
    server.publish("/map", GRID, grid("first"))
    received.wait(bool, "the first")
    server.publish("/map", GRID, grid("second"))
    received.wait(lambda _all: "second" in frames(received), "the second")
    assert frames(received) == ["first", "second"], "and each once"


def test_what_a_profile_states_counts(open_ros: Open) -> None:
    server, ours = open_ros(qos={"/map": {"durability": "latched"}}), open_ros(qos={"/map": {"durability": "volatile"}})
    server.publish("/map", GRID, grid("early"))
    received: Inbox[Message] = Inbox()
    ours.subscribe("/map", GRID, received)
    server.publish("/map", GRID, grid("late"))
    received.wait(lambda _all: "late" in frames(received), "what is published while it listens")

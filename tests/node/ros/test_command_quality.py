# SPDX-License-Identifier: Apache-2.0
"""A client of `~/command` that publishes with best effort is answered, and takes nothing from the others."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from rai_missions.node import MissionNode
from tests.node.scenes import STRING, Client


def test_a_best_effort_client_degrades_no_other(
    open_node: Callable[..., MissionNode], open_client: Callable[[str], Client], open_ros: Callable[..., Any]
) -> None:
    node = open_node("shared")
    client = open_client(node.name.path)
    client.activate()
    assert "no mission is running" in client.command(command="pause")["why"]
    topic = f"{node.name.path}/command"
    worse = open_ros(qos={topic: {"reliability": "best_effort"}})
    worse.publish(topic, STRING, {"data": json.dumps({"id": "worse", "command": "pause"})})
    client.replies.wait(lambda all_: any(each["id"] == "worse" for each in all_), "the best-effort client is answered")
    for _ in range(3):
        assert "no mission is running" in client.command(command="pause")["why"]
    runtime = worse._session.runtime

    def reliabilities() -> list[str]:
        return [each.qos_profile.reliability.name for each in runtime.node.get_subscriptions_info_by_topic(topic)]

    assert "RELIABLE" in runtime.ask(reliabilities, []), "orders of the others are received reliably"
    names = [each["id"] for each in client.replies.all]
    assert len(names) == len(set(names)), "each order is taken once"

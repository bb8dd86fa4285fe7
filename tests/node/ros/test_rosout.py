# SPDX-License-Identifier: Apache-2.0
"""What the mission logs, and what goes wrong meanwhile, can be read on `/rosout`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig
from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox
from rai_missions.mission.mission import Mission
from rai_missions.node import MissionNode
from tests.node.scenes import Client, robot

LOGGING = Mission.model_validate({
    "name": "loud", "initial": "on", "states": {
        "on": {"entry": [{"log": "the lamp is on"}, {"say": "good morning"}],
               "transitions": [{"after_s": 60, "to": "off"}]},
        "off": {"final": "aborted"}},
})  # fmt: skip


@pytest.mark.parametrize("durability", ["latched", "volatile"])
def test_log_lines_are_published_with_their_level(
    domain: int, open_ros: Callable[..., Any], open_client: Callable[[str], Client], durability: str
) -> None:
    ours = open_ros(qos={"/rosout": {"durability": durability, "depth": 1000}})
    received: Inbox[Message] = Inbox(30.0)
    ours.subscribe("/rosout", "rcl_interfaces/msg/Log", received)
    setting = RunConfig(LOGGING, robot({"kind": "ros2", "domain_id": domain, "discovery_s": 1.0}))
    node = MissionNode(setting, "loud")
    node.run()
    try:
        client = open_client(node.name.path)
        client.activate()
        client.start()
        logging.getLogger("rai_missions.runtime.robot_listener").warning("'%s' is odd", "battery")

        def line(text: str) -> Any:
            return next((each.data for each in received.all if each.data["msg"] == text), None)

        received.wait(lambda _all: line("'battery' is odd"), "the warning")
        received.wait(lambda _all: line("speaks: good morning"), "what the mission speaks")
        assert (line("'battery' is odd")["level"], line("the lamp is on")["level"]) == (30, 20)
        assert line("the lamp is on")["name"] == "loud"
        assert len([each for each in received.all if each.data["msg"] == "the lamp is on"]) == 1
    finally:
        node.stop()
    assert not [each for each in logging.getLogger("rai_missions").handlers if type(each).__name__ == "LogLines"]

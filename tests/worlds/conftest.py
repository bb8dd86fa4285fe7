# SPDX-License-Identifier: Apache-2.0
"""An orchard on a connector, and someone who listens to it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import pytest

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world
from rai_missions.worlds.libraries import configure_libraries

configure_libraries()  # before a test loads MuJoCo by itself, which chooses once for the process


class Rig:
    """A world, its connector, and all that was received.

    Args:
        options: Those of `Orchard`.
    """

    def __init__(self, **options: Any) -> None:
        self.world: Any = open_world("orchard", **options)
        self.connector = LocalConnector(now=lambda: self.world.at)
        self.received: list[Message] = []
        self.reports: list[Report] = []
        self.last: dict[str, Message] = {}
        for name in self.topics:
            self.connector.subscribe(f"/tractor1/{name}", "", self._receive)
        self.world.open(self.connector)
        self.connector.start()

    topics: ClassVar = [
        "alleys_driven",
        "at_home",
        "battery",
        "camera_image_color",
        "crossing",
        "obstacle",
        "passed",
        "pose",
        "state",
        "touched_living",
    ]

    def _receive(self, message: Message) -> None:
        self.received.append(message)
        self.last[message.topic.rsplit("/", 1)[1]] = message

    def call(self, service: str) -> dict[str, Any]:
        replies: list[Reply] = []
        self.connector.call(f"/tractor1/{service}", "std_srvs/srv/Trigger", {}, on_reply=replies.append)
        assert replies[0].outcome == "succeeded", replies
        return dict(replies[0].data)

    def send(self, action: str, goal: dict[str, Any], goal_id: str) -> None:
        self.connector.send_goal(action, "", goal, goal_id=goal_id, on_report=self.reports.append)

    def statuses(self, goal_id: str) -> list[str]:
        return [r.status for r in self.reports if r.goal_id == goal_id and r.status != "feedback"]

    def run(self, until: Callable[[], bool], within_s: float) -> bool:
        """Step until something is so; whether it came about in time."""
        end = self.world.at + within_s
        while self.world.at < end:
            self.world.step()
            if until():
                return True
        return False

    def rest(self, seconds: float) -> None:
        self.run(lambda: False, seconds)

    @property
    def state(self) -> str:
        return str(self.call("current_state")["message"]).split(":")[0]

    def data(self, topic: str) -> Any:
        return self.last[topic].data["data"]

    def facts(self, topic: str) -> dict[str, Any]:
        return dict(json.loads(self.data(topic)))

    def to_the_obstacle(self) -> None:
        """Drive until the autonomy hands over, and are."""
        assert self.call("continue")["success"]
        assert self.run(lambda: self.state == "STOPPED", 60.0), "nothing stopped the tractor"
        assert self.run(lambda: abs(self.world.pose.speed) < 0.02, 5.0)


@pytest.fixture
def rig() -> Any:
    """Makes rigs, and closes them."""
    yield from closing(Rig)


def closing(kind: Callable[..., Any]) -> Iterator[Callable[..., Any]]:
    """What makes things of a kind, and closes their worlds at the end."""
    made: list[Any] = []

    def make(**options: Any) -> Any:
        made.append(kind(**options))
        return made[-1]

    yield make
    for one in made:
        one.world.close()

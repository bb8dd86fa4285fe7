# SPDX-License-Identifier: Apache-2.0
"""A server that a run will ask knows the run before it is asked: a reply to a client that it has just met is lost."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.contract import Inbox
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.connectors.ros2.peer_process import FIBONACCI, TRIGGER, Peer


def test_a_run_is_known_to_every_server_that_its_profile_names_before_it_asks_one(
    open_ros: Callable[..., Any], peer: Peer
) -> None:
    begin = f"/{peer.name}"
    robot = Robot.model_validate(
        {
            "name": "expected",
            "services": {"horn": {"service": f"{begin}/trigger", "type": TRIGGER}},
            "actions": {"count": {"action": f"{begin}/fibonacci", "type": FIBONACCI},
                        "hum": {"start": f"{begin}/hum", "cancel": f"{begin}/hush", "succeeded": {"elapsed_s": 1}}},
            "control": {"agent": f"{begin}/give_to/{{by}}"},
            "events": {"go": {"posted": True}},
        }
    )  # fmt: skip
    mission = Mission.model_validate(
        {"format": 1, "name": "expected", "events": ["go"], "initial": "rest",
         "states": {"rest": {"transitions": [{"on": "go", "to": "done"}]}, "done": {"final": "canceled"}}}
    )  # fmt: skip
    connector, other, steps, clock = open_ros(), open_ros(), Inbox[Step](), WallClock()
    runner = Runner(mission, robot=robot, connector=connector, clock=clock, observer=RunObserver(steps))
    thread = threading.Thread(target=runner.run)
    thread.start()
    try:
        steps.wait(bool, "the run begins")
        for name in (
            "trigger",
            "hum",
            "hush",
            "give_to/agent",
            "give_to/operator",
            "fibonacci/_action/send_goal",
            "fibonacci/_action/cancel_goal",
        ):
            until_a_reply_is_awaited(other, f"{begin}/{name}")
        assert len(steps.all) == 1, "nothing was asked"
    finally:
        runner.post(Event("go", clock.now()))
        thread.join(30)


def until_a_reply_is_awaited(other: Any, service: str) -> None:
    """Wait until another node sees that a client reads the service's replies."""
    runtime, tick = other._session.runtime, threading.Event()

    def find() -> list[Any]:
        return list(runtime.node.get_subscriptions_info_by_topic(f"rr{service}Reply", no_mangle=True))

    for _ in range(3000):
        if runtime.ask(find, []):
            return
        tick.wait(0.01)
    raise AssertionError(f"no client awaits a reply of {service}")


def test_what_cannot_be_asked_is_reported_when_it_is_expected_and_stops_no_run(open_ros: Callable[..., Any]) -> None:
    connector, steps = open_ros(), Inbox[Step]()
    robot = Robot.model_validate({"name": "odd", "services": {"horn": {"service": "/horn", "type": "no_msgs/srv/No"}}})
    mission = Mission.model_validate(
        {"format": 1, "name": "odd", "initial": "done", "states": {"done": {"final": "canceled"}}}
    )
    assert Runner(mission, robot=robot, connector=connector, observer=RunObserver(steps)).run().outcome == "canceled"

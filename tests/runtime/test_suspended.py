# SPDX-License-Identifier: Apache-2.0
"""A machine that was suspended: the time in which it slept has passed for facts, timers and the world."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Close, Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import ContinuedClock, WallClock
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

BOOL = "std_msgs/msg/Bool"
ROBOT = Robot.model_validate(
    {"name": "any", "events": {"go": {"posted": True}},
     "blackboard": {"clear": {"topic": "/clear", "type": BOOL, "field": "data"}}}
)  # fmt: skip
GO: list[dict[str, Any]] = [
    {"on": "go", "when": {"key": "clear", "==": True}, "to": "moving"}, {"on": "go", "to": "blind"},
]  # fmt: skip


class Speaking(LocalConnector):
    """Each subscriber receives a message at once."""

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Message], None]) -> Close:
        close = super().subscribe(topic, type_name, on_message)
        self.publish(topic, type_name, {"data": True})
        return close


@pytest.mark.parametrize("slept_s", [0.0, 3600.0])
@pytest.mark.parametrize("after_s", [60.0, 7200.0])
@pytest.mark.parametrize("is_resumed", [False, True])
def test_the_time_of_a_suspension_has_passed(
    monkeypatch: pytest.MonkeyPatch, slept_s: float, after_s: float, *, is_resumed: bool
) -> None:
    """A fact is as old as it is, and a timer that was due meanwhile comes before what is received then."""
    count, slept = time.clock_gettime, [0.0]
    monkeypatch.setattr(time, "clock_gettime", lambda which: count(which) + slept[0] * (which == time.CLOCK_BOOTTIME))
    mission = Mission.model_validate(
        {
            "name": "asleep", "initial": "waiting", "events": ["go"],
            "blackboard": {"clear": {"type": "boolean", "source": "robot", "max_age_s": 30}},
            "states": {
                "waiting": {"transitions": [*GO, {"after_s": after_s, "to": "late"}]},
                "moving": {"final": "canceled"}, "blind": {"final": "aborted"}, "late": {"final": "failed"},
            },
        }
    )  # fmt: skip
    connector, clock, steps = Speaking(), WallClock(), Inbox[Step](10.0)
    connector.start()
    runner = Runner(
        mission,
        robot=ROBOT,
        connector=connector,
        clock=ContinuedClock(clock, 0.0) if is_resumed else clock,
        observer=RunObserver(steps),
    )
    results = list[Result]()
    thread = threading.Thread(target=lambda: results.append(runner.run()))
    thread.start()
    steps.wait(lambda found: found[-1].event.name == "start", "the mission starts")
    slept[0] = slept_s
    runner.post(Event("go"))
    thread.join(10.0)
    assert [each.outcome for each in results] == [
        "canceled" if not slept_s else "failed" if after_s < slept_s else "aborted"
    ]


def test_a_run_has_a_clock_where_the_system_has_none_of_that_name() -> None:
    """macOS counts a suspension in its monotonic clock."""
    program = (
        "import time; del time.CLOCK_BOOTTIME; from rai_missions.runtime.clock import WallClock; WallClock().now()"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

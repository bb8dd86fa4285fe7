# SPDX-License-Identifier: Apache-2.0
"""What the tests of models in processes share: a mission that asks, and the processes that are left."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path
from typing import Any

from rai_missions.connectors.local import LocalConnector
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot

__all__ = ("EXIT_S", "MARK", "PROVIDERS", "ROBOT", "asking", "left_of", "patient", "pause", "talking_robot")

PROVIDERS = Path(__file__).parents[2] / "providers"
MARK = "RAI_MISSIONS_TEST_MARK"
"""A variable by which a process is known to descend from a test."""
EXIT_S = 2.0
"""How long everything may take to end after a mission has."""
STRING = "std_msgs/msg/String"
ROBOT = Robot.model_validate(
    {
        "name": "talking", "connector": {"kind": "local"}, "tools": {"read": ["/*"]},
        "blackboard": {"text": {"topic": "/text", "type": STRING, "field": "data"}},
    }
)  # fmt: skip


def asking(deadline_s: float, attempts: int = 1, **more: Any) -> Mission:
    """A mission that asks a model once; `stayed` is where its answer leads, `left` where none counts."""
    decision = {
        "question": "What now?", "options": {"stay": {}, "leave": {}}, "ask": ["agent"], "attempts": attempts,
        "deadline_s": deadline_s, "fallback": "leave", "budget": {"calls": 3}, **more,
    }  # fmt: skip
    return Mission.model_validate(
        {
            "name": "asking", "initial": "ask",
            "blackboard": {"text": {"type": "string", "source": "robot", "optional": True}},
            "states": {
                "ask": {
                    "decision": decision,
                    "transitions": [{"on": "stay", "to": "stayed"}, {"on": "leave", "to": "left"}],
                },
                "stayed": {"final": "aborted"}, "left": {"final": "canceled"},
            },
        }
    )  # fmt: skip


def talking_robot(topic: str) -> LocalConnector:
    """A robot that has a topic."""
    connector = LocalConnector()
    connector.start()
    connector.publish(topic, STRING, {"data": "hay"})
    return connector


def left_of(mark: str) -> list[str]:
    """The processes that descend from a test, itself left out."""
    wanted, found = f"{MARK}={mark}".encode(), []
    for name in os.listdir("/proc"):
        if not name.isdecimal() or int(name) == os.getpid():
            continue
        try:
            with open(f"/proc/{name}/environ", "rb") as file:
                if wanted not in file.read():
                    continue
            with open(f"/proc/{name}/stat", "rb") as file:
                state = file.read().rpartition(b")")[2].split()[0]
            with open(f"/proc/{name}/cmdline", "rb") as file:
                words = file.read().replace(b"\0", b" ").decode("utf-8", "replace")
        except OSError:
            continue
        if state not in (b"Z", b"X"):
            found.append(f"{name} {words}")
    return found


def pause() -> None:
    """Leave the processor to the process that is waited for."""
    threading.Event().wait(0.01)


def patient(mark: str, within_s: float) -> list[str]:
    """What is left after so many seconds at the most; returns as soon as nothing is."""
    until = time.monotonic() + within_s
    while (found := left_of(mark)) and time.monotonic() < until:
        pause()
    return found

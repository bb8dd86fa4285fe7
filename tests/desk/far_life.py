# SPDX-License-Identifier: Apache-2.0
"""`python -m tests.desk.far_life FD JOURNAL`: a process that runs the mission at a desk of another process.

It begins the run, or resumes the one that the journal holds, and may be killed at any instant. What it asks of the
desk is a line of JSON on a socket, and so is what it receives back: what has come since, and the desk's time.
"""

from __future__ import annotations

import itertools
import json
import socket
import sys
import threading
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rai_missions.connectors.connector import ActionServer, Answer, Close, ConnectorMode, Data, Message, Reply, Report
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.mission.files import load
from rai_missions.profile import load_profile
from rai_missions.runtime.runner import Runner
from tests.replay.deaths import has_begun
from tests.replay.mortal import Fate, live

__all__ = ("FarConnector", "FarLand")

DESK_MISSIONS = Path(__file__).parents[2] / "missions" / "desk"


class FarConnector:
    """The client's end of a connector that is in another process; a `Connector` without servers of its own."""

    modes: frozenset[ConnectorMode] = frozenset({"topics", "services", "actions"})

    def __init__(self, wire: socket.socket) -> None:
        self._lines = wire.makefile("rw", encoding="utf-8")
        self._lock, self._numbers = threading.Lock(), itertools.count()
        self._receivers: dict[int, Callable[..., None]] = {}
        self._came: deque[tuple[int, Any]] = deque()
        self.at = 0.0
        self.running = False

    def ask(self, what: str, **words: Any) -> Any:
        """Have something done at the desk, and take in what has come from there."""
        with self._lock:
            self._lines.write(json.dumps({"do": what, **words}) + "\n")
            self._lines.flush()
            line = self._lines.readline()
            if not line:
                raise SystemExit("the desk is gone")
            reply = json.loads(line)
            self.at = reply["at"]
            self._came.extend((number, given) for number, given in reply["came"])
        while self._came:
            number, given = self._came.popleft()
            if number in self._receivers:
                self._receivers[number](given)
        return reply["value"]

    def _listen(self, receive: Callable[..., None]) -> int:
        number = next(self._numbers)
        self._receivers[number] = receive
        return number

    def start(self) -> None:
        self.running = True

    def stop(self) -> None:
        self.running = False

    def listed(self, mode: ConnectorMode) -> Mapping[str, str]:
        found: dict[str, str] = self.ask("listed", mode=mode)
        return found

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Message], None]) -> Close:
        number = self._listen(lambda given: on_message(Message(*given)))
        self.ask("subscribe", number=number, topic=topic, type_name=type_name)
        return lambda: self._receivers.pop(number, None) and None

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        self.ask("publish", topic=topic, type_name=type_name, message=message)

    def call(
        self,
        service: str,
        type_name: str,
        request: Data,
        *,
        on_reply: Callable[[Reply], None],
        timeout_s: float | None = None,
    ) -> None:
        number = self._listen(lambda given: on_reply(Reply(*given)))
        self.ask("call", number=number, service=service, type_name=type_name, request=request)

    def send_goal(
        self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: Callable[[Report], None]
    ) -> None:
        number = self._listen(lambda given: on_report(Report(*given)))
        self.ask("send_goal", number=number, action=action, type_name=type_name, goal=goal, goal_id=goal_id)

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: Callable[[Report], None]) -> None:
        number = self._listen(lambda given: on_report(Report(*given)))
        self.ask("find_goal", number=number, action=action, type_name=type_name, goal_id=goal_id)

    def cancel_goal(self, goal_id: str) -> None:
        self.ask("cancel_goal", goal_id=goal_id)

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        raise NotImplementedError("a mission serves nothing at a desk")

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        raise NotImplementedError("a mission offers nothing at a desk")


class FarLand:
    """The desk in the other process, as a run steps it: its time moves when the run waits."""

    keeps_time = False

    def __init__(self, wire: socket.socket) -> None:
        self.connector = FarConnector(wire)
        self.connector.start()
        hello = self.connector.ask("hello")
        self.period_s, self.request = hello["period_s"], hello["request"]
        self.runner: Runner | None = None

    @property
    def at(self) -> float:
        return self.connector.at

    def step(self) -> None:
        self.connector.ask("step")

    def look(self, step: Step) -> None:
        """The mission ends by itself."""


def main() -> int:
    wire, journal = socket.socket(fileno=int(sys.argv[1])), Path(sys.argv[2])
    land: Any = FarLand(wire)
    if not has_begun(journal):
        for left in (journal, journal.with_name(f"{journal.name}-wal")):
            left.unlink(missing_ok=True)
    mission, robot = load(DESK_MISSIONS / "arrange.json"), load_profile(DESK_MISSIONS / "robot.sim.json")
    keys = mission.blackboard
    asked = {**keys, "request": keys["request"].model_copy(update={"initial": land.request})}
    try:
        live(journal, land, mission.model_copy(update={"blackboard": asked}), robot, {}, Fate())
    except UsageError as fault:
        if "has ended" not in str(fault):
            raise
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

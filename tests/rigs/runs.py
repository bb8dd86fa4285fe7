# SPDX-License-Identifier: Apache-2.0
"""A small robot on an in-process connector, a stage that plays what happens to it, and a mission to run on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import Clock, SimulatedClock
from rai_missions.runtime.runner import Result, Runner

__all__ = ("Book", "Rig", "Server", "Stage", "mission", "robot")

Json = dict[str, Any]
KEYS: Json = {
    "there": {"type": "boolean", "source": "robot", "optional": True},
    "battery": {"type": "number", "source": "robot", "max_age_s": 2, "optional": True},
    "speed": {"type": "number", "source": "argument", "initial": 1.0},
    "count": {"type": "integer", "source": "mission", "initial": 0},
}
ROBOT: Json = {
    "name": "tried",
    "blackboard": {
        "there": {"topic": "/there", "type": "std_msgs/msg/Bool"},
        "battery": {"topic": "/battery", "type": "sensor_msgs/msg/BatteryState", "field": "percentage"},
    },
    "events": {name: {"posted": True} for name in ("go", "again", "stop_now")},
    "actions": {
        "move": {"action": "/move", "type": "x/action/Move", "uses": ["base"]},
        "turn": {"action": "/turn", "type": "x/action/Turn", "uses": ["base"]},
        "drive": {"start": "/drive", "cancel": "/halt", "succeeded": {"key": "there", "==": True}, "uses": ["base"]},
    },
    "services": {"horn": {"service": "/horn", "type": "std_srvs/srv/Trigger"}},
    "topics": {"lamp": {"topic": "/lamp", "type": "std_msgs/msg/Bool"}},
}


class Stage:
    """A world of scripted moments.

    Args:
        moments: When → what happens then.
    """

    period_s = 0.1

    def __init__(self, moments: Mapping[float, Callable[[], object]] | None = None) -> None:
        self._moments = sorted((moments or {}).items())
        self.steps = 0
        self.each: Callable[[], object] = lambda: None

    @property
    def at(self) -> float:
        return round(self.steps * self.period_s, 6)

    def play(self, moments: Mapping[float, Callable[[], object]]) -> None:
        self._moments = sorted([*self._moments, *moments.items()], key=lambda moment: moment[0])

    def step(self) -> None:
        self.steps += 1
        self.each()
        while self._moments and self._moments[0][0] <= self.at:
            self._moments.pop(0)[1]()


class Server:
    """An action's server that says what it is told to, at once or when the test does.

    Args:
        at_once: What it reports of each goal as it comes.
        on_cancel: What it reports of each cancel.
    """

    def __init__(self, *at_once: str, on_cancel: tuple[str, ...] = ("canceled",)) -> None:
        self.at_once, self.on_cancel = at_once, on_cancel
        self.goals: list[str] = []
        self.given: list[Mapping[str, Any]] = []
        self.canceled: list[str] = []
        self._report: dict[str, Callable[[Report], None]] = {}

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        self.goals.append(goal_id)
        self.given.append(goal)
        self._report[goal_id] = report
        for said in self.at_once:
            self.say(said)

    def cancel(self, goal_id: str) -> None:
        self.canceled.append(goal_id)
        for said in self.on_cancel:
            self.say(said, self.goals.index(goal_id))

    def say(self, said: Any, which: int = -1, **data: Any) -> None:
        """Report of a goal, the last one by default."""
        goal_id = self.goals[which]
        self._report[goal_id](Report(goal_id, said, data))


class Book:
    """A journal in memory, whose disk is full from a row on.

    Args:
        rows: How many rows it holds.
    """

    path = Path("memory")

    def __init__(self, rows: int = 10**9) -> None:
        self._room = rows
        self.steps: list[Step] = []
        self.quiet: list[Any] = []
        self.notes: list[str] = []
        self.on_write: Callable[[Step], None] = lambda step: None

    def write(self, step: Step, *, since: float, quiet: Any = ()) -> int:
        self.on_write(step)
        if len(self.steps) >= self._room:
            raise ConnectorError("the disk is full")
        self.steps.append(step)
        self.quiet += quiet
        return len(self.steps)

    def confirm(self, number: int, how: str) -> int:
        return len(self.steps)

    def note(self, text: str, data: Any = None) -> int:
        self.notes.append(text)
        return 0


def mission(states: Json, **words: Any) -> Mission:
    """A mission of these states; they and the words are as JSON has them."""
    given = {"name": "tried", "initial": next(iter(states)), "blackboard": KEYS, "events": ["go", "again", "stop_now"]}
    return Mission.model_validate({**given, "states": states, **words})


def robot(**words: Any) -> Robot:
    return Robot.model_validate({**ROBOT, **words})


class Rig:
    """A runner on a small robot, and all that came of it.

    Args:
        given: The mission, or its states as JSON has them.
        moments: When, on the simulated clock → what happens then.
        words: What `Runner` takes.
    """

    def __init__(
        self, given: Mission | Json, moments: Mapping[float, Callable[[], object]] | None = None, **words: Any
    ) -> None:
        self.stage = Stage(moments)
        self.clock: Clock = words.pop("clock", None) or SimulatedClock(self.stage)
        self.connector: Any = words.pop("connector", None) or LocalConnector(now=lambda: self.clock.now())
        self.move, self.turn = Server("accepted"), Server("accepted")
        self.called: list[tuple[float, str]] = []
        self.steps: list[Step] = []
        self.book: Any = words.pop("journal", None) or Book()
        self.serve()
        self.runner = Runner(
            given if isinstance(given, Mission) else mission(given),
            robot=words.pop("robot", None) or robot(),
            connector=self.connector,
            clock=self.clock,
            journal=self.book,
            on_step=words.pop("on_step", self.steps.append),
            **words,
        )

    def serve(self) -> None:
        for service in ("/horn", "/drive", "/halt"):
            self.connector.serve(service, "std_srvs/srv/Trigger", lambda _, name=service: self._answer(name))
        self.connector.offer("/move", "x/action/Move", self.move)
        self.connector.offer("/turn", "x/action/Turn", self.turn)

    def _answer(self, service: str) -> Json:
        self.called.append((self.clock.now(), service))
        return {"success": True, "message": ""}

    def run(self) -> Result:
        return self.runner.run()

    def post(self, name: str, **data: Any) -> None:
        self.runner.post(Event(name, self.clock.now(), data))

    def publish(self, topic: str, **data: Any) -> None:
        kinds = {"/there": "std_msgs/msg/Bool", "/battery": "sensor_msgs/msg/BatteryState"}
        self.connector.publish(topic, kinds[topic], data)

    @property
    def entered(self) -> list[str]:
        return [name for step in self.steps for name in step.entered]

    def stale(self) -> list[Step]:
        """The journal's steps whose event came too late."""
        return [step for step in self.book.steps if step.why.startswith("stale")]

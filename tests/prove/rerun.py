# SPDX-License-Identifier: Apache-2.0
"""What a journal holds, brought about again: by a robot, people and a clock, for a run of the same mission.

Rule: the run is reached as any other, by messages, reports, answers and orders; nothing is put into its chart.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Data, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.decision import Question
from rai_missions.engine.step import CallService, StartGoal, Step
from rai_missions.event import Event
from rai_missions.journal import StepRow
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.goals import id_of_goal
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.connectors.ros2.alike import HeldClock

__all__ = ("Rerun", "moved")

ACTIONS = ("drive", "turn", "composed", "lift")
LOOK_S, LOOKS = 0.0005, 10_000


class Happened(NamedTuple):
    """One thing that happened in the run of a journal."""

    at: float
    kind: str
    name: str
    data: Any
    number: int = 0


def moved(steps: Iterable[Step]) -> list[Any]:
    """Each step that led somewhere, as what it did."""
    did = [([(m.trigger, m.exited, m.entered) for m in step.moves], step.outcome) for step in steps]
    return [each for each in did if each[0] or each[1]]


class Rerun:
    """A run of a mission in which happens what a journal has.

    Args:
        mission: The journal's.
        rows: The journal's steps.
    """

    def __init__(self, mission: Mission, rows: Iterable[StepRow]) -> None:
        self._keys, self._clock, self.steps = mission.blackboard, HeldClock(), list[Step]()
        self._happened = list(_happened(rows))
        self._goals = dict[str, Callable[[Report], None]]()
        self._calls, self._asked = list[Future[Data]](), dict[int, Callable[[Mapping[str, Any]], None]]()
        self._connector = connector = LocalConnector(now=self._clock.now)
        connector.start()
        for action in ACTIONS:
            connector.offer(f"/{action}", "x/action/X", self)
        connector.serve("/horn", "std_srvs/srv/Trigger", self._horn)
        begun = next(at for at, each in enumerate(self._happened) if (each.kind, each.name) == ("command", "start"))
        self._before, self._after = self._happened[:begun], self._happened[begun + 1 :]
        given = {each.name: each.data for each in self._before if self._keys[each.name].source == "argument"}
        robot = profile(mission)
        self._runner = Runner(
            mission,
            robot=robot,
            connector=connector,
            clock=self._clock,
            answerers=dict.fromkeys(("agent", "operator", "rules"), self),
            begin=NewRun(given, run="run", waits=True),
            observer=RunObserver(self.steps.append),
        )
        self._thread = threading.Thread(target=self._runner.run)

    # -- the robot, and who answers -----------------------------------------------------------------------------------

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        self._goals[goal_id] = report

    def cancel(self, goal_id: str) -> None:
        """What it comes to is in the journal."""

    def _horn(self, request: Data) -> Future[Data]:
        self._calls.append(Future())
        return self._calls[-1]

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self._asked[question.number] = answer

    def withdraw(self, number: int) -> None:
        """It may answer nevertheless."""

    # -- the run ------------------------------------------------------------------------------------------------------

    def play(self) -> None:
        """Have it all happen, one after the other, and end the run."""
        self._thread.start()
        self._settle()
        for each in self._before:
            self._happen(each)
        self._runner.start({})
        self._settle()
        for each in self._after:
            if each.at > self._clock.now():
                self._clock.advance(each.at - self._clock.now())
                self._settle()
            self._happen(each)
        self._end()

    def _settle(self) -> None:
        pause = threading.Event()
        for _ in range(LOOKS):
            if self._clock.is_idle or not self._thread.is_alive():
                return
            pause.wait(LOOK_S)

    def _happen(self, happened: Happened) -> None:
        _, kind, name, data, number = happened
        effects = [effect for step in self.steps for effect in step.effects]
        starts = {effect.number: effect.owner for effect in effects if isinstance(effect, StartGoal)}
        calls = [effect.number for effect in effects if isinstance(effect, CallService)]
        if kind == "write" and self._keys[name].source == "robot":
            self._connector.publish(f"/{name}", "std_msgs/msg/String", {"data": json.dumps(data)})
        elif kind == "event":
            self._runner.post(Event(name, self._clock.now(), dict(data)))
        elif kind == "command":
            getattr(self._runner, name)()
        elif kind == "proposal" and number in self._asked:
            self._asked[number](dict(data))
        elif number in starts:
            goal_id = id_of_goal("run", number, starts[number])
            self._goals[goal_id](Report(goal_id, name if kind == "result" else kind, data))  # type: ignore[arg-type]
        elif number in calls:
            self._calls[calls.index(number)].set_result({"success": name == "succeeded", "message": "", **data})
        self._settle()

    def _end(self) -> None:
        self._runner.kill()
        for goal_id, report in list(self._goals.items()):
            report(Report(goal_id, "failed", {}))
        for _ in range(LOOKS):
            if not self._thread.is_alive():
                break
            self._clock.advance(10.0)
            self._thread.join(LOOK_S)
        assert not self._thread.is_alive(), "the run does not end"


def _happened(rows: Iterable[StepRow]) -> Iterator[Happened]:
    for row in rows:
        for name, value, at in row.before:
            yield Happened(at, "write", name, value)
        event = row.step.event
        data = event.data["value"] if event.kind == "write" else event.data
        yield Happened(event.at, event.kind, event.name, data, event.number)


def profile(mission: Mission) -> Robot:
    """A robot on which each action excludes the others, as in a proof without a profile."""
    sensed = [name for name, key in mission.blackboard.items() if key.source == "robot"]
    return Robot.model_validate(
        {
            "name": "any",
            "actions": {name: {"action": f"/{name}", "type": "x/action/X"} for name in ACTIONS},
            "blackboard": {name: {"topic": f"/{name}", "type": "std_msgs/msg/String", "json": True} for name in sensed},
            "services": {"horn": {"service": "/horn", "type": "std_srvs/srv/Trigger"}},
            "topics": {"lamp": {"topic": "/lamp", "type": "std_msgs/msg/String"}},
            "events": {name: {"posted": True} for name in mission.events},
        }
    )

# SPDX-License-Identifier: Apache-2.0
"""The rig for runs: a small robot on an in-process connector, its servers, its world, and who answers its mission.

Rule: nothing here waits; time is the test's.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.clock import Clock, SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.rigs.journals import MemoryJournal

__all__ = (
    "KEYS", "ROBOT", "ManualClock", "ManualServer", "Plan", "PlannedServer", "ReplyingAnswerer", "Rig", "ScriptedWorld",
    "asking", "by_hand", "mission", "robot",
)  # fmt: skip

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


class ScriptedWorld:
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


class ManualServer:
    """An action's server that reports what a test wants, at once or when the test calls it.

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
        for each in self.at_once:
            self.report(each)

    def cancel(self, goal_id: str) -> None:
        self.canceled.append(goal_id)
        for each in self.on_cancel:
            self.report(each, self.goals.index(goal_id))

    def report(self, what: Any, which: int = -1, **data: Any) -> None:
        """Report of a goal, the last one by default."""
        goal_id = self.goals[which]
        self._report[goal_id](Report(goal_id, what, data))


class Plan(NamedTuple):
    """What an action's server does with one goal; seconds after what they follow, None for never."""

    accepts: float | None = 0.0
    rejects: bool = False
    ends: float | None = None
    end: str = "succeeded"
    cancels: float | None = 0.0
    """How long the end takes after a cancel that is not refused."""
    refuses: bool = False
    raises: bool = False
    """It raises where a cancel arrives."""
    twice: bool = False
    """It reports everything twice."""
    dies: float | None = None
    """When its process is gone, counted from the goal's arrival; for servers that have a process or node to lose."""
    vanishes: bool = False
    """The service that starts a composed action does so, and its server is gone before it replies."""


class PlannedServer:
    """An action's server that keeps to its plans, one a goal in turn, and knows which goals it is executing.

    Args:
        call_later: Calls something after so many seconds; at once where there are none.
        now: Seconds on the clock of the test.
        plans: Its plans.
    """

    def __init__(
        self, call_later: Callable[[float, Callable[[], object]], object], now: Callable[[], float], *plans: Plan
    ) -> None:
        self._call_later, self._now, self._plans = call_later, now, plans
        self._lock = threading.Lock()
        self._mine: dict[str, tuple[Plan, Callable[[Report], None]]] = {}
        self.executing: set[str] = set()
        self.over: dict[str, float] = {}
        """Goals of which it has reported an end, and when."""

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        plan = self._plans[len(self._mine) % len(self._plans)]
        self._mine[goal_id] = (plan, report)
        self._after(plan.accepts, lambda: self._decide(goal_id, plan))

    def cancel(self, goal_id: str) -> None:
        plan, _ = self._mine[goal_id]
        if plan.raises:
            raise RuntimeError("no brakes")
        if plan.refuses:
            self.report(goal_id, "cancel_rejected")
        else:
            self._after(plan.cancels, lambda: self.end(goal_id, "canceled"))

    def obeys(self, goal_id: str) -> bool:
        """Whether the goal ends once its cancel arrives."""
        plan, _ = self._mine[goal_id]
        return not plan.refuses and not plan.raises and plan.cancels is not None

    def end(self, goal_id: str, how: str) -> None:
        """End a goal, once."""
        with self._lock:
            is_new = goal_id not in self.over
            self.executing.discard(goal_id)
            self.over.setdefault(goal_id, self._now())
        if is_new:
            self.report(goal_id, how)

    def report(self, goal_id: str, what: Any) -> None:
        plan, report = self._mine[goal_id]
        for _ in range(1 + plan.twice):
            report(Report(goal_id, what, {}))

    def _decide(self, goal_id: str, plan: Plan) -> None:
        if plan.rejects:
            self.end(goal_id, "rejected")
            return
        self.executing.add(goal_id)
        self.report(goal_id, "accepted")
        self._after(plan.ends, lambda: self.end(goal_id, plan.end))

    def _after(self, seconds: float | None, do: Callable[[], object]) -> None:
        if seconds is not None:
            self._call_later(seconds, do)


class ReplyingAnswerer:
    """Answers each question at once, or never.

    Args:
        reply: What it answers to a question: an option's name, a whole answer, or None for nothing at all.
    """

    def __init__(self, reply: str | Callable[[Question], str | Mapping[str, Any] | None]) -> None:
        self._reply = (lambda question: reply) if isinstance(reply, str) else reply
        self.asked: list[Question] = []

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.asked.append(question)
        reply = self._reply(question)
        if reply is not None:
            answer({"option": reply} if isinstance(reply, str) else reply)

    def withdraw(self, number: int) -> None:
        """It answers at once or never: there is nothing to stop."""


class ManualClock:
    """A clock that a test sets.

    Args:
        waits: Whether a wait moves it to its end; else nothing may wait for it.
    """

    def __init__(self, *, waits: bool = False) -> None:
        self.at, self._waits = 0.0, waits

    def now(self) -> float:
        return self.at

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        assert self._waits, "nothing waits in these tests"
        self.at = until

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """It is set by hand."""


def asking(**words: Any) -> Json:
    """The states of a mission that asks the agent for left or right; the words are those of its decision."""
    options = {"left": {}, "right": {}}
    decision = {"question": "Which?", "options": options, "ask": ["agent"], "fallback": "right", **words}
    return {
        "asking": {
            "decision": decision,
            "transitions": [{"on": "left", "to": "over"}, {"on": "right", "to": "lost"}],
        },
        "over": {"final": "aborted"},
        "lost": {"final": "failed"},
    }


def mission(states: Json, **words: Any) -> Mission:
    """A mission of these states; they and the words are as JSON has them."""
    given = {"name": "tried", "initial": next(iter(states)), "blackboard": KEYS, "events": ["go", "again", "stop_now"]}
    return Mission.model_validate({**given, "states": states, **words})


def robot(**words: Any) -> Robot:
    return Robot.model_validate({**ROBOT, **words})


def by_hand(chart: Chart, **words: Any) -> Runner:
    """A runner of a chart that the test steps itself; the runner takes no event.

    Args:
        chart: The run's.
        words: What else `Runner` takes.
    """
    return Runner(chart.mission, begin=Resumption(chart, InFlight(), None, 0.0, 0, "run"), **words)


class Rig:
    """A runner on a small robot, and all that came of it.

    Args:
        given: The mission, or its states as JSON has them.
        moments: When, on the simulated clock → what happens then.
        words: What `Runner` and `NewRun` take.
    """

    def __init__(
        self, given: Mission | Json, moments: Mapping[float, Callable[[], object]] | None = None, **words: Any
    ) -> None:
        self.stage = ScriptedWorld(moments)
        self.clock: Clock = words.pop("clock", None) or SimulatedClock(self.stage)
        self.connector: Any = words.pop("connector", None) or LocalConnector(now=lambda: self.clock.now())
        self.move, self.turn = ManualServer("accepted"), ManualServer("accepted")
        self.called: list[tuple[float, str]] = []
        self.answer: Json = {"success": True, "message": ""}
        """What each service replies."""
        self.steps: list[Step] = []
        self.on_step: Callable[[Step], object] = words.pop("on_step", self.steps.append)
        self.book: Any = words.pop("journal", None) or MemoryJournal()
        self.serve()
        self.runner = Runner(
            given if isinstance(given, Mission) else mission(given),
            robot=words.pop("robot", None) or robot(),
            connector=self.connector,
            clock=self.clock,
            journal=self.book,
            answerers=words.pop("answerers", None),
            observer=RunObserver(lambda step: self.on_step(step), words.pop("on_status", None)),
            begin=words.pop("begin", None) or NewRun(**words),
        )

    def serve(self) -> None:
        for service in ("/horn", "/drive", "/halt"):
            self.connector.serve(service, "std_srvs/srv/Trigger", lambda _, name=service: self._answer(name))
        self.connector.offer("/move", "x/action/Move", self.move)
        self.connector.offer("/turn", "x/action/Turn", self.turn)

    def _answer(self, service: str) -> Json:
        self.called.append((self.clock.now(), service))
        return self.answer

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

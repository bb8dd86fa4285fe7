# SPDX-License-Identifier: Apache-2.0
"""One mission over one connector, whose robot does what a script has it do, one act after the other.

Rule: the run's clock is the script's, and an act begins once the one before has had all its consequences. So two plays
of one script over two connectors differ in ids and in the words of a reason alone.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Connector, Data, Message, Report
from rai_missions.connectors.contract import Inbox
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner

__all__ = ("COMMANDS", "POSTED", "REPORTS", "Act", "Count", "HeldClock", "Pair", "Play")

ACTION, SERVICE = "test_msgs/action/NestedMessage", "test_msgs/srv/BasicTypes"
MESSAGE, TRIGGER = "test_msgs/msg/BasicTypes", "std_srvs/srv/Trigger"
SIDES = ("left", "right")
POSTED = ("go_left", "go_right", "again_left", "again_right", "halt", "talk")
COMMANDS = ("pause", "resume", "stop", "cancel")
REPORTS = ("accepted", "rejected", "feedback", "succeeded", "failed", "canceled")
WORDS = ("why", "stamp", "owner")
"""Fields of events that may differ."""
WITHIN_S, LOOK_S = 10.0, 0.002
LAST_S, LAST_TIMES = 10.0, 200


class HeldClock:
    """Time that moves when the test moves it."""

    def __init__(self) -> None:
        self._at, self._mailbox, self._is_waiting = 0.0, Mailbox(), False

    def now(self) -> float:
        return self._at

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        self._mailbox = mailbox
        if mailbox.empty and self._at < until:
            self._is_waiting = True
            mailbox.wait(None)
            self._is_waiting = False

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """The test moves it."""

    def advance(self, seconds: float) -> None:
        self._at += seconds
        self._mailbox.wake()

    @property
    def is_idle(self) -> bool:
        """The run waits, for an event or an instant."""
        return self._is_waiting and self._mailbox.empty


class Act(NamedTuple):
    """One act of a script."""

    what: str
    which: int = 0
    """The goal or call that it is about, in the order in which they came to the robot."""
    data: Mapping[str, Any] = {}


class Count(NamedTuple):
    """How much has happened: the run's steps, and what the robot was asked for."""

    steps: int
    asked: int


class Pair(NamedTuple):
    """Both ends of a way; in one process they may be one connector."""

    run: Connector
    robot: Connector


class Play:
    """A run of the mission and its robot.

    Args:
        name: The name of the robot; its topics, services and actions are named below it.
        ends: The two connectors, started.
        sent: What the mission sends: `goal` and `request`.
        actions: Whether actions have a server; else they are composed of services.
    """

    def __init__(self, name: str, ends: Pair, sent: Data, *, actions: bool) -> None:
        self._name, self._ends = name, ends
        self._clock, self._goals, self._calls = HeldClock(), list[tuple[str, Callable[[Report], None]]](), list[_Call]()
        self._refuses = False
        self.steps, self.asked = Inbox[Step](WITHIN_S), Inbox[tuple[Any, ...]](WITHIN_S)
        self._closes = list(self._serve(actions=actions))
        self._runner = Runner(
            mission(actions=actions),
            robot=profile(name, actions=actions),
            connector=ends.run,
            clock=self._clock,
            observer=RunObserver(self.steps),
            begin=NewRun({"sent": sent}),
        )
        self._thread = threading.Thread(target=self._runner.run)

    def _serve(self, *, actions: bool) -> Iterable[Callable[[], None]]:
        robot, name = self._ends.robot, self._name
        if actions:
            yield robot.offer(f"{name}/move", ACTION, self)
        for service, kind in (("start", TRIGGER), ("halt", TRIGGER), ("ask", SERVICE)):
            yield robot.serve(f"{name}/{service}", kind, partial(self._call, service))
        yield robot.serve(f"{name}/ping", TRIGGER, lambda _: {"success": True, "message": ""})
        yield robot.subscribe(f"{name}/lamp", MESSAGE, self._light)

    # -- the robot ----------------------------------------------------------------------------------------------------

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        self._goals.append((goal_id, report))
        self.asked(("goal", len(self._goals) - 1, goal))

    def cancel(self, goal_id: str) -> None:
        which = [each for each, _ in self._goals].index(goal_id)
        self.asked(("cancel", which))
        if self._refuses:
            self._report("cancel_rejected", which, {})

    def _report(self, status: Any, which: int, data: Data) -> None:
        if which < len(self._goals):
            goal_id, report = self._goals[which]
            report(Report(goal_id, status, data))

    def _call(self, service: str, request: Data) -> Future[Data]:
        self._calls.append(_Call(service, Future()))
        self.asked((service, len(self._calls) - 1, request))
        return self._calls[-1].answer

    def _light(self, message: Message) -> None:
        self.asked(("lamp", message.data))

    # -- the script ---------------------------------------------------------------------------------------------------

    def begin(self, least: Count) -> Count:
        """Start the run; what it listens to is known to the robot then. Argument and result as `do` has them."""
        self._thread.start()
        self.settle(least)
        replies = Inbox[Any](WITHIN_S)
        self._ends.run.call(f"{self._name}/ping", TRIGGER, {}, on_reply=replies, timeout_s=WITHIN_S)
        replies.wait(bool, "the robot answers")
        return self.settle(least)

    def do(self, act: Act, least: Count) -> Count:
        """Have something done, and wait for its consequences; how much has happened.

        Args:
            act: What.
            least: How much has to happen.
        """
        what, which, data = act
        if what in REPORTS:
            self._report(what, which, data)
        elif what in ("reply", "fail"):
            self._answer(which, data, fails=what == "fail")
        elif what in ("seen", "alarm"):
            self._ends.robot.publish(f"{self._name}/{what}", MESSAGE, data)
        elif what == "time":
            self._clock.advance(data["s"])
        elif what == "refuses":
            self._refuses = not self._refuses
        elif what in COMMANDS:
            getattr(self._runner, what)()
        else:
            self._runner.post(Event(what, self._clock.now(), dict(data)))
        return self.settle(least)

    def _answer(self, which: int, data: Data, *, fails: bool) -> None:
        """Answer a call; ROS has no word for the failure of one whose response has no field for it."""
        call = self._calls[which] if which < len(self._calls) else None
        if call is None or call.answer.done():
            return
        if not fails:
            call.answer.set_result(data["typed" if call.service == "ask" else "trigger"])
        elif call.service != "ask":
            call.answer.set_exception(ValueError("no motor"))

    def settle(self, least: Count) -> Count:
        """Wait until the run has nothing left to do, and so much has happened or too long was waited for it."""
        pause = threading.Event()
        for _ in range(int(WITHIN_S / LOOK_S)):
            is_idle = self._clock.is_idle or not self._thread.is_alive()
            count = Count(len(self.steps.all), len(self.asked.all))
            if is_idle and count.steps >= least.steps and count.asked >= least.asked:
                return count
            pause.wait(LOOK_S)
        return Count(len(self.steps.all), len(self.asked.all))

    def end(self) -> None:
        """End the run, whatever its goals do."""
        self._runner.kill()
        self._refuses = False
        for _ in range(LAST_TIMES):
            if not self._thread.is_alive():
                break
            for which in range(len(self._goals)):
                self._report("failed", which, {})
            self._clock.advance(LAST_S)
            self._thread.join(LOOK_S)
        self._thread.join(WITHIN_S)
        assert not self._thread.is_alive(), "the run does not end"
        for close in self._closes:
            close()

    def story(self) -> list[Any]:
        """What the run's steps have in common over all connectors; a refusal of the same cancel counts once."""
        facts = [_facts(step) for step in self.steps.all]
        return [each for at, each in enumerate(facts) if each[0] != "refused" or each not in facts[:at]]

    def requests(self) -> list[Any]:
        """What the robot was asked for, as text; another cancel of a goal is none, and neither is the order of ways."""
        return sorted({repr(each) for each in self.asked.all})


class _Call(NamedTuple):
    service: str
    answer: Future[Data]


def _facts(step: Step) -> tuple[Any, ...]:
    event = step.event
    data = {name: value for name, value in event.data.items() if name not in WORDS and event.name != "rejected"}
    moves = [(move.exited, move.entered) for move in step.moves]
    return (event.kind, event.name, event.number, data, moves, step.writes, step.outcome, step.ignored)


def mission(*, actions: bool) -> Mission:
    """`left` and `right` pursue goals on one action; `talk` publishes and calls."""
    ends = ["succeeded", "failed", "rejected", "timed_out"]

    def moving(side: str) -> dict[str, Any]:
        leave = [
            {"on": [*ends, "canceled"], "to": f"{side}_rest"},
            {"on": "halt", "to": f"{side}_rest"},
            {"on": f"again_{side}", "to": f"{side}_moving"},
        ]
        goal = {"goal": {"from": "sent.goal"}, "result": {"got": "nested_field"}} if actions else {}
        return {"action": f"move_{side}", **goal, "timeout_s": 30, "cancel_s": 5, "transitions": leave}

    regions = {
        side: {
            "initial": f"{side}_rest",
            "states": {
                f"{side}_rest": {"transitions": [{"on": f"go_{side}", "to": f"{side}_moving"}]},
                f"{side}_moving": moving(side),
            },
        }
        for side in SIDES
    }
    asking = {
        "call": "ask", "request": {"from": "sent.request"}, "timeout_s": 30, "result": {"answer": "string_value"},
        "entry": [{"publish": "lamp", "message": {"from": "sent.goal.nested_field"}}],
        "transitions": [{"on": [*ends, "halt"], "to": "silent"}],
    }  # fmt: skip
    silent = {"transitions": [{"on": "talk", "to": "asking"}]}
    regions["talk"] = {"initial": "silent", "states": {"silent": silent, "asking": asking}}
    kept = {name: {"type": kind, "source": "mission", "optional": True} for name, kind in KEPT.items()}
    seen = {name: {"type": kind, "source": "robot", "optional": True} for name, kind in SEEN.items()}
    return Mission.model_validate(
        {
            "format": 1, "name": "alike", "version": "1.0.0", "initial": "work",
            "blackboard": {"sent": {"type": "object", "source": "argument"}, **kept, **seen},
            "events": {name: {} for name in (*POSTED, "alarm")},
            "states": {"work": {"parallel": regions}},
            "transitions": [{"on": "alarm", "do": [{"set": "noted", "from": "event.int32_value"}]}],
        }
    )  # fmt: skip


KEPT = {"got": "object", "answer": "string", "noted": "integer"}
SEEN = {"seen": "object", "there": "boolean"}


def profile(name: str, *, actions: bool) -> Robot:
    """The robot of a play."""
    composed = {"start": f"{name}/start", "cancel": f"{name}/halt", "succeeded": {"key": "there", "==": True}}
    move = {"action": f"{name}/move", "type": ACTION} if actions else composed
    seen = {"topic": f"{name}/seen", "type": MESSAGE}
    alarm = {"alarm": {"topic": f"{name}/alarm", "type": MESSAGE}}
    return Robot.model_validate(
        {
            "name": "alike",
            "blackboard": {"seen": seen, "there": {**seen, "field": "bool_value"}},
            "events": {**{each: {"posted": True} for each in POSTED}, **alarm},
            "actions": {f"move_{side}": {**move, "uses": [side]} for side in SIDES},
            "services": {"ask": {"service": f"{name}/ask", "type": SERVICE}},
            "topics": {"lamp": {"topic": f"{name}/lamp", "type": MESSAGE}},
        }
    )

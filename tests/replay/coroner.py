# SPDX-License-Identifier: Apache-2.0
"""Looks into each death: at what instant it came, and whether the next process is where the last one was."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Close, Data, Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Ask, CallService, StartGoal, Step
from rai_missions.journal import StepRow
from rai_missions.journal.in_flight import needs_confirmation
from rai_missions.mission.mission import Mission
from rai_missions.replay.open_run import OpenedRun
from rai_missions.runtime.goals import id_of_goal
from rai_missions.runtime.runner import Runner
from tests.replay.farm import Farm
from tests.replay.mortal import Coroner, Fate, Land

__all__ = ("INSTANTS", "Inquest", "LatchingConnector", "SlowAnswerer", "Steady")

CARRIED_OUT = ("send_goal", "call", "publish", "ask")
INSTANTS = (
    "between a step's row and its effects", "done and not confirmed", "in a transition", "in a decision",
    "goal sent and not accepted", "goal running", "goal finished and unread", "timer pending", "in a tree",
    "in a parallel region", "in the resume itself", "before the start", "paused",
)  # fmt: skip


class LatchingConnector(LocalConnector):
    """Reports anyone who begins to listen what was reported last, as of now: it is still so."""

    def __init__(self, now: Callable[[], float]) -> None:
        super().__init__(now)
        self._last: dict[str, Data] = {}

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        self._last[topic] = message
        super().publish(topic, type_name, message)

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Message], None]) -> Close:
        close = super().subscribe(topic, type_name, on_message)
        if topic in self._last:
            on_message(Message(topic, self._last[topic], self._now()))
        return close


class Steady(Farm):
    """Surroundings in which a death costs the run no time: its clock is still, and all that is so is reported at once.

    So the run continues as if nothing had been, and must end as it would have.
    """

    keeps_time = True
    connector_type: type[LocalConnector] = LatchingConnector


class SlowAnswerer:
    """Answers every question with the same option, so long after it was first asked.

    Args:
        option: Its name.
        land: Whose time it takes.
        thinks_s: How much of it.
    """

    def __init__(self, option: str, land: Land, thinks_s: float) -> None:
        self._option, self._land, self._thinks_s = option, land, thinks_s
        self._since: dict[int, float] = {}
        self._open: dict[int, Callable[[Mapping[str, Any]], None]] = {}
        self.asked: set[int] = set()
        land.also.append(self.think)

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.asked.add(question.number)
        self._since.setdefault(question.number, self._land.at)
        self._open[question.number] = answer
        self.think()

    def think(self) -> None:
        ready = [number for number in self._open if self._since[number] + self._thinks_s <= self._land.at]
        for number in ready:
            self._open.pop(number)({"option": self._option})

    def withdraw(self, number: int) -> None:
        self._open.pop(number, None)


class Inquest(Coroner):
    """What the deaths of one run have shown.

    Args:
        mission: The mission of the run.
        land: Where it runs.
        answerers: Who is asked.
    """

    def __init__(self, mission: Mission, land: Land, answerers: Mapping[str, SlowAnswerer]) -> None:
        self._land, self._answerers = land, answerers
        words = {name: state.word for _, name, state in mission.walk()}
        self._trees = {name for name, word in words.items() if word == "tree"}
        self._parallels = {name for name, word in words.items() if word == "parallel"}
        self.kills: Counter[str] = Counter()
        """Instant → how many deaths came at one."""
        self.deaths = 0
        self.repeatable: Counter[str] = Counter()
        """Service → how many of its calls were in doubt when a process took the run up."""
        self._saved: Any = None
        self._rows: list[str] = []
        self._continuing = False
        self._asked: frozenset[int] = frozenset()
        self.received: frozenset[Any] = frozenset()
        """Which events that have an id are in the journal."""

    def wrote(self, runner: Runner) -> None:
        self._saved = runner.view.snapshot()

    def found(self, taken: OpenedRun) -> None:
        rows = [digest for *_, digest in taken.record.raw()]
        assert rows[: len(self._rows)] == self._rows, "what was written stays as it is"
        self._rows, self._continuing = rows, True
        self.received = frozenset(step.event.data.get("id") for step in taken.record.steps())
        chart, under = taken.resumption.chart, taken.resumption.under
        if self._saved is not None:
            assert chart.snapshot() == self._saved, "the run is where it was"
        goals = {self.goal_id(each) for each in under.open.values() if isinstance(each, StartGoal)}
        ended = {goal_id for goal_id, _ in self._land.ended}
        self.kills["goal finished and unread"] += bool(goals & ended)
        in_doubt = {id(each): each for each in (*under.open.values(), *under.unconfirmed)}
        self.repeatable.update(each.service for each in in_doubt.values() if isinstance(each, CallService))
        self._asked = frozenset(number for number, each in under.open.items() if isinstance(each, Ask))

    def goal_id(self, start: StartGoal) -> str:
        return id_of_goal("run", start.number, start.owner)

    def look(self, runner: Runner, step: Step) -> None:
        """A step has been done."""
        if step.event.kind == "command" and step.event.name == "take_up":
            self._continuing = False
            for each in self._answerers.values():
                each.asked.clear()
            self._asked &= runner.view.awaited
        elif not self._continuing and self._asked:
            asked = frozenset[int]().union(*(each.asked for each in self._answerers.values()))
            assert self._asked <= asked, "the question is asked again"
            self._asked = frozenset()

    def instants(self, runner: Runner, what: str, given: tuple[Any, ...], *, is_done: bool) -> frozenset[str]:
        """At which of the instants a process is that is about to do something, or has just done it."""
        chart = runner.view
        step = given[0] if what == "write" else None
        unaccepted = self._land.unaccepted.keys()
        is_so = {
            "between a step's row and its effects": (step is not None and is_done and needs_confirmation(step))
            or (what in CARRIED_OUT and not is_done),
            "done and not confirmed": (what in CARRIED_OUT and is_done) or (what == "confirm" and not is_done),
            "in a transition": step is not None and bool(step.moves),
            "in a decision": runner.view.thinking,
            "goal sent and not accepted": bool(unaccepted),
            "goal running": any(goal_id not in unaccepted for goal_id in self._land.running),
            "timer pending": bool(chart.snapshot()["_timers"]),
            "in a tree": bool(chart.active & self._trees),
            "in a parallel region": bool(chart.active & self._parallels),
            "in the resume itself": self._continuing,
            "before the start": chart.mode == "ready",
            "paused": chart.mode == "paused",
        }
        return frozenset(name for name, so in is_so.items() if so)

    def died(self, runner: Runner, fate: Fate) -> None:
        self.deaths += 1
        self.kills.update(self.instants(runner, *fate.doing, is_done=fate.is_done))
        self._continuing = False


def steps_of(rows: list[Any]) -> list[Step]:
    """The steps among a journal's rows."""
    return [row.step for row in rows if isinstance(row, StepRow)]

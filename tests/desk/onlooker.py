# SPDX-License-Identifier: Apache-2.0
"""A witness at a desk while runs that drive its arm are killed: what was held, what fell, what became of each goal.

Rule: it reads the truth and what passes between the arm's servers and their client, and changes neither.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.connectors.connector import ENDS, ActionServer, Close, Connector, Data, Report
from rai_missions.connectors.wrapper import ConnectorWrapper
from rai_missions.engine.step import StartGoal
from rai_missions.worlds.desk.truth import DeskTruth
from rai_missions.worlds.desk.world import Desk
from tests.desk.plain_judge import unmet
from tests.rigs.journals import assert_whole, steps_of

__all__ = ("DeskVerdict", "Onlooker", "plain_goal")

FALL_M = 0.015
"""What loses less height between the fingers and where it rests was set down."""


@dataclass
class GoalRecord:
    """What a server of the arm knows of one goal."""

    action: str
    asked: int = 0
    """How often it was asked to pursue it."""
    begun: float = 0.0
    end: str = ""
    over: float = float("inf")
    why: str = ""


class Fall(NamedTuple):
    """A thing that left the fingers with nothing below it."""

    thing: str
    at: float
    is_reported: bool
    """The goal of that moment, or the next one, did not succeed."""


class DeskVerdict(NamedTuple):
    """How a run ended, and what is so."""

    outcome: str | None
    why: str
    unmet: tuple[str, ...]
    """What is not so of what was asked for, by the truth at the last picture that the mission used."""
    held: str
    falls: tuple[Fall, ...]
    twice: tuple[str, ...]
    """Goals that a server was asked for more than once."""
    busy: tuple[str, ...]
    """Goals that were rejected because the arm pursued another one."""
    unread: tuple[str, ...]
    """Goals that a server knows, and that are no goals of the journal."""

    @property
    def faults(self) -> list[str]:
        """What must never be, whatever happens on the desk."""
        found = [f"{goal}: asked for twice" for goal in self.twice]
        found += [f"{goal}: rejected, the arm was busy" for goal in self.busy]
        found += [f"{goal}: not in the journal" for goal in self.unread]
        found += [
            f"{fall.thing} was dropped at {fall.at:.2f} s, unreported" for fall in self.falls if not fall.is_reported
        ]
        if self.outcome == "succeeded":
            found += [f"claimed: {each}" for each in self.unmet]
        return found


class Watched(ActionServer):
    """A server, and a record of its goals."""

    def __init__(self, action: str, server: ActionServer, onlooker: Onlooker) -> None:
        self._action, self._server, self._onlooker = action, server, onlooker

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        record = self._onlooker.goals.setdefault(goal_id, GoalRecord(self._action, begun=self._onlooker.world.at))
        record.asked += 1

        def on_report(each: Report) -> None:
            if each.status in ENDS and not record.end:
                record.end, record.over, record.why = each.status, self._onlooker.world.at, each.why
            report(each)

        self._server.accept(goal_id, goal, on_report)

    def cancel(self, goal_id: str) -> None:
        self._server.cancel(goal_id)


class Front(ConnectorWrapper):
    """The connector on which a desk is opened, watched."""

    def __init__(self, inner: Connector, onlooker: Onlooker) -> None:
        super().__init__(inner)
        self._onlooker = onlooker

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        return self.inner.offer(action, type_name, Watched(action, server, self._onlooker))

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        if topic == "/desk/objects":
            self._onlooker.looks += 1
        self.inner.publish(topic, type_name, message)


@dataclass
class Onlooker:
    """The world's truth at each look, and the goals of its arm. Steps the world."""

    world: Desk
    goals: dict[str, GoalRecord] = field(default_factory=dict)
    looks: int = 0
    is_alone: bool = False
    """No run lives."""
    drops: list[tuple[str, float]] = field(default_factory=list)
    truth: DeskTruth = field(init=False)
    seen: DeskTruth = field(init=False)
    """At the last look that a run could use."""
    _hand: str = ""
    _let_go: tuple[float, float] | None = None
    """Height and time at which the thing in the hand lost the fingers, with nothing below it."""

    def __post_init__(self) -> None:
        self.truth = self.seen = self.first = self.world.truth()
        self.period_s = self.world.period_s

    def front(self, connector: Connector) -> Connector:
        """Where the world is to be opened."""
        return Front(connector, self)

    @property
    def at(self) -> float:
        return self.world.at

    def step(self) -> None:
        looks = self.looks
        self.world.step()
        self.truth = self.world.truth()
        if self.looks > looks and not self.is_alone:
            self.seen = self.truth
        self._watch_hand(self.truth)

    def _watch_hand(self, truth: DeskTruth) -> None:
        if truth.held:
            self._hand, self._let_go = truth.held, None
        elif self._hand:
            thing = truth.things[self._hand]
            below = {"desk", *truth.things} - {self._hand}
            is_carried = any(truth.touch(self._hand, other) for other in below)
            if not is_carried and self._let_go is None:
                self._let_go = thing.z, truth.at
            if is_carried and thing.at_rest:
                if self._let_go is not None and self._let_go[0] - thing.z > FALL_M:
                    self.drops.append((self._hand, self._let_go[1]))
                self._hand, self._let_go = "", None

    def verdict(self, journal: Path, goal: Sequence[Mapping[str, Any]]) -> DeskVerdict:
        """Judge a run that has ended.

        Args:
            journal: Where it was written.
            goal: What was asked for, over the scene's names.
        """
        again, steps = assert_whole(journal), steps_of(journal)
        started = sum(isinstance(each, StartGoal) for step in steps for each in step.effects)
        return DeskVerdict(
            again.outcome,
            again.why,
            tuple(unmet(plain_goal(goal, self.first), self.seen)),
            self.seen.held,
            tuple(Fall(name, at, self._is_reported(at)) for name, at in self.drops),
            tuple(name for name, each in self.goals.items() if each.asked > 1),
            tuple(name for name, each in self.goals.items() if "busy" in each.why),
            tuple(self.goals)[started:],
        )

    def _is_reported(self, at: float) -> bool:
        ends = [each.end for each in self.goals.values() if each.over >= at]
        return (bool(ends) and ends[0] != "succeeded") or (len(ends) > 1 and ends[1] != "succeeded")


def plain_goal(goal: Sequence[Mapping[str, Any]], truth: DeskTruth) -> list[Mapping[str, Any]]:
    """A goal in which a swap is the places that the two had at first."""
    found: list[Mapping[str, Any]] = []
    for each in goal:
        if "swapped" not in each:
            found.append(each)
            continue
        for name, place in zip(each["swapped"], reversed(each["swapped"]), strict=True):
            found.append({"at": name, "x": truth.things[place].x, "y": truth.things[place].y})
    return found

# SPDX-License-Identifier: Apache-2.0
"""Everything that can happen to a mission in a state: what it is told, what is known, the operator's orders, and time.

Rule: what is listed here is all that a proof is about; nothing else is assumed of robot, model, person or clock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import TreeMachine
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove.instrumented_chart import NOW
from rai_missions.prove.nondeterminism import OpenFields
from rai_missions.prove.parts import parts
from rai_missions.prove.stimulus import Stimulus
from rai_missions.prove.time_env import TimeEnvironment
from rai_missions.states.effects import Call

__all__ = ("RESUME", "Environment")

RESUME = "the operator resumes"


class Environment(TimeEnvironment):
    """A chart to which anything can happen."""

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None) -> None:
        super().__init__(mission, ticker, terms=terms)
        runs = any(state.word in ("action", "call", "tree") for _, _, state in mission.walk())
        told = bool(self._fleeting or self.predicates) or self.own_fade
        self.pause_matters = runs or told or bool(self._needed) or any(True for _ in parts(mission, Call))
        """Something can change while the mission is paused; else it goes on as if nothing had been."""

    def happenings(self) -> Iterator[Stimulus]:
        """Everything that can happen now but a cancel and an emergency stop."""
        if self.mode == "paused":
            yield from self._meanwhile()
        elif self.mode in ("running", "canceling"):
            yield from self.times()
            yield from self.machine_times()
            yield from self.answers()
            yield from self.reports()
            yield from self.events()
            yield from self._writes()
            yield from self._handovers()
            if self.mode == "running" and self.pause_matters and not self.is_calm:
                yield Stimulus("the operator pauses", "command", self.ordering("pause"))

    def _meanwhile(self) -> Iterator[Stimulus]:
        """What can happen while the mission is paused; what would wait for it to go on can come just as well then."""
        yield from self.orphans()
        yield from self.leftovers()
        yield from self._writes()
        yield Stimulus(RESUME, "event", self._go_on)

    def _go_on(self) -> None:
        """Control may have changed hands meanwhile: then it did before anything starts again."""
        self.is_going_on = True
        if self.here:
            found = self.choices.choose(1 + len(self.holds))
            if found:
                self.take(self.holds[found - 1])
            assert self.holder
            assert self.found is not None
            self._control(self.found)
        self.ordering("resume")()
        self.is_going_on = False

    def begin(self) -> None:
        """The mission starts, whoever has control."""
        self.let_go()
        self.leave_open()
        step = self.start(NOW)
        self.moves, self.looked = list(step.moves), list(step.guards)

    def ordering(self, command: str) -> Callable[[], None]:
        """The operator's order to `pause`, `resume` or `cancel`, or to stop at once (`kill`)."""
        return self._hear(Event(command, NOW, {"by": "operator"}, "command"))

    def _handovers(self) -> Iterator[Stimulus]:
        """A handover is acknowledged, what runs loses control, or the operator takes it and gives it back."""
        for who in sorted(self.waited_for):
            yield self._handover(f"control is with {who}", who, "mission")
        if self.is_calm or not self.here:
            return
        if self.is_held:
            for who in self.others:
                yield self._handover(f"the operator gives control back to {who}", who, "mission")
        elif self.is_in_hand:
            for who in [who for who in self.others if who != self._holder]:
                yield self._handover(f"control is with {who}", who, "robot")
        for who in [who for who in self.holds if who != self.held_by]:
            words = "the operator takes control" if who == "operator" else "control is taken, and with nobody"
            yield self._handover(words, who, "operator")

    def _handover(self, words: str, who: str, by: str) -> Stimulus:
        return Stimulus(words, "robot" if by != "operator" else "command", self._hear(_control(who, by)))

    # -- what is known --------------------------------------------------------------------------------------------

    def _writes(self) -> Iterator[Stimulus]:
        """What is listened for becomes each other thing that it can be."""
        for key in sorted(self.listening):
            now = self.board.known(key)
            known = self.board.is_known(key)
            for value in self._others(key, now):
                if known and value == (None if now is None else now.value):
                    continue
                if value is None:
                    yield Stimulus(
                        f"{key} goes stale", "write", self.elapse(self._forget_it(key), beyond=key), stale=key
                    )
                else:
                    yield Stimulus(f"{key} is {_said(value)}", "write", self._say(key, value))
        for key, written in self.mission.blackboard.items():
            if written.max_age_s is not None and written.source != "robot" and self.board.known(key) is not None:
                gone = self.elapse(self._forget_it(key), beyond=key)
                yield Stimulus(f"{key} goes stale", "write", gone, stale=key)
        live = self._live() if self.mode != "paused" else ()
        restless = [name for name, machine, _ in live if isinstance(machine, TreeMachine)]
        if restless or self.predicates:
            yield Stimulus("something is said again", "write", lambda: self.time_passes(*restless))

    def _others(self, key: str, now: Any) -> Iterator[Any]:
        """What it can be next; of an object the fields alone that somebody looks at."""
        if not self.values.shape(key):
            yield from self.values.of(key)
            return
        if None in self.values.of(key):
            yield None
        if now is None:
            yield self._shapes[key].fresh({})
            return
        known = list(now.value)
        for mixture in product(*(self.values.part(key, field) for field in known)):
            yield self._shapes[key].fresh(dict(zip(known, mixture, strict=True)))

    def _say(self, key: str, value: Any) -> Callable[[], None]:
        def happen() -> None:
            made = value.fresh() if isinstance(value, OpenFields) else value
            self._handle(Event(key, NOW, {"value": made}, "write"))

        return happen

    def _forget_it(self, key: str) -> Callable[[], None]:
        def change() -> None:
            self._wavering.pop(key, None)
            self.board.put(key, None)

        return change


def _control(who: str, by: str) -> Event:
    return Event(who, NOW, {"by": by}, "control")


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)

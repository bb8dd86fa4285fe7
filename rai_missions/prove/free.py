# SPDX-License-Identifier: Apache-2.0
"""Everything that can happen to a mission in a state: what it is told, what is known, and time.

Rule: what is listed here is all that a proof is about; nothing else is assumed of robot, model, person or clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import product
from typing import Any

from rai_missions.event import Event
from rai_missions.mission import Mission
from rai_missions.prove.choices import OpenFields
from rai_missions.prove.happening import Happening
from rai_missions.prove.told import Told, owned
from rai_missions.prove.watched import NOW
from rai_missions.states.asking import Asking
from rai_missions.states.tending import Tended, Tending, TendingMachine
from rai_missions.states.terms import Terms
from rai_missions.states.ticker import Trees

__all__ = ("Free",)

LONG_AGO = 0.0


class Free(Told):
    """A chart to which anything can happen."""

    def happenings(self) -> Iterator[Happening]:
        """Everything that can happen now but the operator's commands."""
        if self.mode not in ("running", "canceling"):
            return
        yield from self._times()
        yield from self._machine_times()
        yield from self.answers()
        yield from self.reports()
        yield from self.events()
        yield from self._writes()
        yield from self._handovers()

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: Terms | None = None) -> None:
        super().__init__(mission, ticker, terms=terms)
        keys = mission.blackboard.items()
        self._passing = frozenset(name for name, key in keys if key.source == "robot" and key.max_age_s is not None)
        """What a robot must say again and again."""

    def begin(self) -> None:
        """The mission starts."""
        step = self.start(NOW)
        self.moves, self.looked = list(step.moves), list(step.guards)

    def order(self, command: str) -> None:
        """The operator cancels the mission (`cancel`), or stops it at once (`kill`)."""
        self._handle(Event(command, NOW, {"by": "operator"}, "command"))

    # -- what is known --------------------------------------------------------------------------------------------

    def _writes(self) -> Iterator[Happening]:
        """What is listened for becomes each other thing that it can be."""
        for key in sorted(self.listening):
            now = self.board.known(key)
            known = self.board.is_known(key)
            for value in self._others(key, now):
                if known and value == (None if now is None else now.value):
                    continue
                if value is None:
                    yield Happening(
                        f"{key} goes stale", "write", self._elapse(self._forget_it(key), beyond=key), stale=key
                    )
                else:
                    yield Happening(f"{key} is {_said(value)}", "write", self._say(key, value))
        for key, written in self.mission.blackboard.items():
            if written.max_age_s is not None and written.source != "robot" and self.board.known(key) is not None:
                gone = self._elapse(self._forget_it(key), beyond=key)
                yield Happening(f"{key} goes stale", "write", gone, stale=key)
        restless = [name for name, machine, _ in self._live() if isinstance(machine, TendingMachine)]
        if restless or self.predicates:
            yield Happening("something is said again", "write", lambda: self.time_passes(*restless))

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

    def _handovers(self) -> Iterator[Happening]:
        """A handover that was asked for is acknowledged."""
        wanted = {self._graph.nodes[name].control for name in self._pending}
        for who in sorted(each for each in wanted if each is not None and each != self.holder):
            event = Event(who, NOW, {"by": "mission"}, "control")
            yield Happening(f"control is with {who}", "robot", self._hear(event))

    # -- time -----------------------------------------------------------------------------------------------------

    def time_passes(self, *woken: str) -> None:
        """What has run out takes effect; the machines of these states are told that time has passed."""
        self._due = frozenset(woken)
        self._instant()

    def _elapse(self, change: Callable[[], None], *woken: str, beyond: str = "") -> Callable[[], None]:
        """Time passes until something has run out; what is known may go stale at the same instant.

        Args:
            change: What has run out.
            woken: The states whose machines are told.
            beyond: Only keys that come after this: that those before it go stale too is told of them.
        """

        def happen() -> None:
            before = self._waver(beyond)
            change()
            self.time_passes(*woken)
            gone = [key for key in before if key not in self._wavering and self.board.known(key) is None]
            for key in self._wavering:
                self.board.put(key, before[key])
            self._wavering.clear()
            if gone and self.mode != "ended":
                self.time_passes(*self._readers(gone))

        return happen

    def _waver(self, beyond: str) -> dict[str, Any]:
        """Have every key that can go stale do so at this instant or not, when somebody looks."""
        before: dict[str, Any] = {}
        for key, entry in list(self.board.entries()):
            if entry is not None and key > beyond and key in self._passing:
                before[key] = entry
                self._wavering[key] = entry.value
                self.board.pop(key)
        return before

    def _readers(self, keys: Iterable[str]) -> list[str]:
        """The states whose machines want to hear of these."""
        wanted = {*keys, "*"}
        return [name for name, machine, state in self._live() if not machine.reads(state).isdisjoint(wanted)]

    def _times(self) -> Iterator[Happening]:
        """Each thing that waits for time gets it, in any order."""
        for key in sorted(self._timers, key=str):
            kind, which = key
            words = {"after": f"the time of row {which} has come", "timeout": f"the time of '{which}' is over"}
            told = words.get(kind, f"'{self._timers[key].name}' is due")
            yield Happening(told, "time", self._elapse(self._ring(key)))
        for name, until in list(self._pending.items()):
            if until != math.inf:
                yield Happening(f"no handover for '{name}' in time", "time", self._elapse(self._late(name)))
        for name in list(self._settling):
            yield Happening(f"'{name}' has not settled", "time", self._elapse(self._unsettled(name)))
        if self._final is not None and not self._settling:
            yield Happening("time passes at the end", "time", self._elapse(lambda: None))
        if self._cancel_by != math.inf:
            yield Happening("the cancel takes too long", "time", self._elapse(self._too_long))
        yield from self._orphans()
        yield from self._ages()

    def _orphans(self) -> Iterator[Happening]:
        for goal in self.remaining:
            if goal.phase != "orphaned":
                told = f"'{goal.action}' never confirms its end"
                yield Happening(told, "time", self._elapse(self._orphan(goal.number)))

    def _ages(self) -> Iterator[Happening]:
        for name in self.aging:
            told = f"'{name or 'the mission'}' has lasted {self.next_age(name):g} s"
            yield Happening(told, "time", self._elapse(self._aged(name), *self._running))
        for memory, since in list(self.view.held.items()):
            if since == NOW:
                yield Happening(f"{memory} has held for long enough", "time", self._elapse(self._mature(memory)))

    def _machine_times(self) -> Iterator[Happening]:
        for name, path, state in list(self.inner()):
            owner, tree = owned(name, path), self._running[name]
            if path is not None and tree.leaves[path].deadline != math.inf:
                over = self._elapse(self._leaf_over(name, path), name)
                yield Happening(f"the time of '{owner}' is over", "time", over)
            wake = self._machine_of(name, path).wake_at(state, self.view)
            told = f"time passes for '{owner}'"
            if isinstance(state, Asking) and state.deadline != math.inf:
                wake, told = state.deadline, f"the deadline of '{owner}' has come"
            if NOW < wake < math.inf:
                yield Happening(told, "time", self._elapse(self._let_pass(name, path, wake), name))
        for name, state in list(self._running.items()):
            if isinstance(state, Tending) and NOW < state.wake < math.inf:
                yield Happening(f"time passes for '{name}'", "time", self._elapse(self._grow(name), name))

    def _machine_of(self, name: str, path: str | None) -> Any:
        machine: Any = self._machines[name]
        return machine if path is None else machine.limbs[path].machine

    def _ring(self, key: Any) -> Callable[[], None]:
        def change() -> None:
            self._timers[key] = self._timers[key]._replace(due=NOW)

        return change

    def _late(self, name: str) -> Callable[[], None]:
        return lambda: self._pending.update({name: NOW})

    def _unsettled(self, name: str) -> Callable[[], None]:
        return lambda: self._settling.update({name: NOW})

    def _too_long(self) -> None:
        self._cancel_by = NOW

    def _orphan(self, number: int) -> Callable[[], None]:
        def change() -> None:
            goals = self._ledger.goals
            goals[number] = goals[number]._replace(until=NOW)

        return change

    def _aged(self, name: str) -> Callable[[], None]:
        age = self.next_age(name)
        assert age is not None
        return lambda: self.grow_old(name, age)

    def _mature(self, memory: str) -> Callable[[], None]:
        return lambda: self.view.held.update({memory: LONG_AGO})

    def _leaf_over(self, name: str, path: str) -> Callable[[], None]:
        def change() -> None:
            tree = self._running[name]
            leaves = {**tree.leaves, path: Tended(tree.leaves[path].state, NOW)}
            self._running[name] = tree._replace(leaves=leaves)

        return change

    def _let_pass(self, name: str, path: str | None, wake: float) -> Callable[[], None]:
        """So much time passes for one machine alone."""

        def change() -> None:
            machine, state = self._machine_of(name, path), self._running[name]
            if path is None:
                self._running[name] = machine.shifted(state, NOW - wake)
                return
            tended = state.leaves[path]
            leaves = {**state.leaves, path: Tended(machine.shifted(tended.state, NOW - wake), tended.deadline)}
            self._running[name] = state._replace(leaves=leaves)

        return change

    def _grow(self, name: str) -> Callable[[], None]:
        """So much time passes for a tree that its own next instant comes; its leaves' time is another affair."""

        def change() -> None:
            state, machine = self._running[name], self._machines[name]
            assert isinstance(machine, TendingMachine)
            tree = machine.ticker.shifted(state.tree, NOW - state.wake)
            self._running[name] = state._replace(tree=tree, wake=NOW)

        return change


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)

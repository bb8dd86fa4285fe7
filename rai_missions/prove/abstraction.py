# SPDX-License-Identifier: Apache-2.0
"""A chart between two steps: what nobody listens to is forgotten, what waits for time waits as long as ever.

Rule: forgetting gives more runs, never fewer. A key that is forgotten can be anything when somebody looks again; only
one that what waits does not look at, being as it is, is forgotten, since its change changes nothing now.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from rai_missions.engine.activities.action import GoalActivity, GoalMachine
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import limit_of
from rai_missions.engine.configuration import Configuration
from rai_missions.engine.nodes import Condition, Node
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.state import Timer
from rai_missions.guards.elapsed import Elapsed
from rai_missions.guards.guard import View
from rai_missions.guards.held import Held
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.prove.activity_key import SOON, rested, told_timer
from rai_missions.prove.control_env import ControlEnvironment
from rai_missions.prove.instrumented_chart import NOW
from rai_missions.prove.liveness import Later, Live
from rai_missions.prove.nondeterminism import OpenFields
from rai_missions.prove.parts import guards_in, writes_in
from rai_missions.states.compound import Each

__all__ = ("PURSUED", "Abstraction")

REMEMBERED = 4096
"""Of so many configurations it is remembered what they wait for."""
MANY = 2
"""So many alike stand for any number more."""
PURSUED = ("sent", "running")
"""The phases of a goal that its state still pursues."""


class Abstraction(ControlEnvironment):
    """A chart that comes to rest after each step."""

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None) -> None:
        super().__init__(mission, ticker, terms=terms)
        idle = frozenset(mission.blackboard) - self.values.learned.compared - self._fleeting
        self._reopened = idle & self.open_keys
        """Keys that any value does for, and that no guard looks at."""
        self._idle = idle - self.open_keys - self.values.learned.gone_over
        copies = {each.set for each in writes_in(mission) if each.source is not None}
        answers = {name for name, key in mission.blackboard.items() if key.source == "answer"}
        self._given = self.open_keys | self.facts | copies | answers
        """Keys under which a list may stand that the mission has not written itself."""
        timed = [*guards_in(mission), *guards_in(self.terms.succeeded), *guards_in(self.terms.failed)]
        ages = [each.elapsed_s if isinstance(each, Elapsed) else each.for_s if isinstance(each, Held) else 0.0
                for each in timed]  # fmt: skip
        self._longest_s = max(ages, default=0.0)
        """The longest that any guard looks back."""
        self._full = self.values.saturating()
        self._waiting: dict[tuple[int, ...], tuple[Condition, ...]] = {}
        rows = [*mission.transitions, *(row for _, _, state in mission.walk() for row in state.transitions)]
        self._every = frozenset(mission.blackboard)
        self._live_on = Live(mission, self._graph, self.terms)
        self._remainders: dict[tuple[str, tuple[int, ...]], tuple[str, ...]] = {}
        self._hears_of_orphans = any("orphaned" in row.on for row in rows)
        self._hears_of_calls = any("call_failed" in row.on for row in rows)
        self.hears_of_doubt = any("uncertain" in row.on for row in rows)
        """Some row is about what nobody can tell whether it was done."""

    def settle(self) -> None:
        """Forget what nobody looks at, and put every timer that runs to the same distance."""
        if self.mode == "ended":
            return
        self.let_go()
        self._listening = self._sensed()
        self._forget()
        self._wait()
        self._cap()
        self.view.event = {}

    @property
    def restless(self) -> list[str]:
        """The states whose trees rest only because they have gone round as often as a step allows."""
        return [name for name, state in self._running.items() if limit_of(state) == "writes"]

    @property
    def listening(self) -> frozenset[str]:
        """The keys whose change may change something."""
        return self._listening

    # -- what is looked at ----------------------------------------------------------------------------------------

    def _sensed(self) -> frozenset[str]:
        """The keys that what waits for something looks at, being as it is; no other can change anything now."""
        board, looked = self.board, self.board.looked
        looked.clear()
        for key in self._shapes:
            entry = board.known(key)
            if entry is not None:
                if not isinstance(entry.value, OpenFields):  # a robot has just said it
                    entry = Stamped(self._shapes[key].fresh(entry.value), NOW)
                    board.put(key, entry)
                entry.value.looked.clear()
        for condition in self._watching():
            self._look(condition)
        for _, machine, state in self._awake() if self.mode != "paused" else ():
            if isinstance(machine, GoalMachine) and not self.predicates:
                _sense(machine, state, self.view)
            else:
                looked |= machine.reads(state)
        return frozenset(looked) & self._fleeting

    def _watching(self) -> Iterable[Condition]:
        """The guards that may do something without an event."""
        if self.mode == "paused":
            yield from (condition for _, condition in self._invariants)
            return
        if self._final is not None:
            yield from [self._final.requires] if self._final.requires is not None else []
        else:
            config = self._config
            waiting = self._waiting.get(config.key)
            if waiting is None:
                if len(self._waiting) >= REMEMBERED:
                    self._waiting.clear()
                waiting = self._waiting[config.key] = tuple(_waiting(config))
            yield from waiting if not self._frozen else self._waiting_free(config)
        for name in self._settling:
            if self._final is None and self._is_held(self._graph.nodes[name]):
                continue
            requires = self._graph.nodes[name].requires
            assert requires is not None
            yield requires
        yield from (condition for _, condition in self._invariants)

    def _waiting_free(self, config: Configuration) -> Iterable[Condition]:
        """The guards of the transitions of free states that need no event, or count for how long they are true."""
        yield from (row.condition for chain in self._free(config.eventless) for row in chain if row.condition)
        for node in sorted(config.nodes, key=lambda node: node.index):
            if not self._is_held(node):
                yield from (row.condition for row in node.rows if row.condition and row.condition.holds)

    def _look(self, condition: Condition) -> None:
        if self.predicates:  # they may say something else the next time
            self.board.looked |= condition.reads
            return
        condition.test(self.view)
        for test in condition.holds.values():
            test(self.view)

    def _forget(self) -> None:
        board = self.board
        for key in self._fleeting - self._listening:
            board.pop(key, None)
        for key in self._shapes:
            entry = board.known(key)
            if entry is not None:
                for field in entry.value.keys() - entry.value.looked if not self.predicates else ():
                    del entry.value[field]
        for key in self._reopened:
            board.pop(key, None)
        for key, (low, high) in self._full.items():
            entry = board.known(key)
            if entry is not None and not low <= entry.value <= high:
                board.put(key, Stamped(min(max(entry.value, low), high), NOW))

    # -- what waits -----------------------------------------------------------------------------------------------

    def _wait(self) -> None:
        timers = self._timers
        for key, timer in timers.items():
            if timer.due != SOON:
                timers[key] = timer._replace(due=SOON)
        for waiting in (self._pending, self._settling):
            for name, until in waiting.items():
                if until != math.inf:
                    waiting[name] = SOON
        self._cancel_by = SOON if self._cancel_by != math.inf else math.inf
        goals = self._ledger.goals
        for number, goal in goals.items():
            if goal.until != math.inf:
                goals[number] = goal._replace(until=SOON)
        for name, state in self._running.items():
            self._running[name] = rested(state, self._machines[name], self._longest_s)
        for name, (items, index) in self._rounds.items():
            if index:
                self._rounds[name] = (items[index:], 0)

    # -- what there may be any number of --------------------------------------------------------------------------

    def remainder(self, goal: Goal) -> tuple[Any, ...] | None:
        """All that makes a difference of a goal that nobody pursues any more; None where none is left."""
        if self._hears_of_orphans:
            return (goal.phase == "orphaned", goal.action)
        place = (goal.action, self._config.key)
        rivals = self._remainders.get(place)
        if rivals is None:
            rivals = tuple(sorted(each for each in self.later.starts if self.terms.conflict(goal.action, each)))
            self._remainders[place] = rivals
        return (goal.phase == "orphaned", *rivals) if rivals else None

    @property
    def pursued(self) -> list[Goal]:
        """The goals whose end a state waits for."""
        return [goal for goal in self._ledger.goals.values() if goal.phase in PURSUED]

    @property
    def remaining(self) -> list[Goal]:
        """The goals that nobody pursues and that make a difference yet, one for all that are alike."""
        goals = [goal for goal in self._ledger.goals.values() if goal.phase not in PURSUED]
        alike = {rest: goal for goal in reversed(goals) if (rest := self.remainder(goal)) is not None}
        return list(alike.values())

    @property
    def later(self) -> Later:
        """What makes a difference from here on."""
        later = self._live_on.after(self._config)
        return later if not self.predicates else later._replace(keys=self._every)

    def _alike(self) -> dict[tuple[Any, ...], list[Any]]:
        """What cannot be told from its like: kind and words → its keys."""
        alike: dict[tuple[Any, ...], list[Any]] = {}
        for key, timer in self._timers.items():
            if isinstance(key[1], int):
                alike.setdefault(("timer", *told_timer(key, timer)), []).append(key)
        for number, service in self._calls.items():
            alike.setdefault(("call", service), []).append(number)
        for number, goal in self._ledger.goals.items():
            if goal.phase not in PURSUED and (rest := self.remainder(goal)) is not None:
                alike.setdefault(("goal", *rest), []).append(number)
        return alike

    def _cap(self) -> None:
        if not self._hears_of_calls:
            self._calls.clear()  # whatever they come to, nobody hears of it
        if len(self._timers) + len(self._calls) + len(self._ledger.goals) <= MANY:
            return
        for (kind, *_), keys in self._alike().items():
            store: Any = {"timer": self._timers, "call": self._calls, "goal": self._ledger.goals}[kind]
            for key in keys[MANY:]:
                del store[key]

    def make(self, happens: Callable[[], None]) -> None:
        """Let something happen; what it did can be read until the next."""
        self._clear()
        self.ticks, self.turned, self.begun = 0, set(), {}
        several = len(self._timers) + len(self._calls) + len(self._ledger.goals) >= MANY
        before = {words: keys for words, keys in self._alike().items() if len(keys) >= MANY} if several else {}
        happens()
        self.seq += 1
        if before and self.mode != "ended":
            self._replenish(before)

    def _replenish(self, before: dict[tuple[Any, ...], list[Any]]) -> None:
        """Where there were many, there may be as many still."""
        now = Counter({words: len(keys) for words, keys in self._alike().items()})
        for words in before:
            if now[words] == MANY - 1 and self.choices.choose(2):
                self._add_another(words)

    def _add_another(self, words: tuple[Any, ...]) -> None:
        key = self._alike()[words][0]
        if words[0] == "timer":
            self._order += 1
            self._timers["raise", self._order] = Timer(SOON, self._order, *self._timers[key][2:])
        elif words[0] == "call":
            self._calls[self.next_number()] = self._calls[key]
        else:
            number = self.next_number()
            self._ledger.goals[number] = self._ledger.goals[key]._replace(number=number)

    def _next_round(self, node: Node) -> None:
        """A list that the surroundings gave may be longer than was thought, where it has two items or more."""
        items, index = self._rounds[node.name]
        assert isinstance(node.state, Each)
        path = node.state.each
        is_given = path.split(".")[0] in self._given
        if 0 < index == len(items) - 1 and is_given and self.choices.choose(2):
            self._rounds[node.name] = ((*items, self.choices.pick(self.values.item(path))), index)
        super()._next_round(node)


def _waiting(config: Configuration) -> Iterator[Condition]:
    """The guards of rows that need no event, and those that count for how long they have been true."""
    yield from (row.condition for chain in config.eventless for row in chain if row.condition is not None)
    nodes = sorted(config.nodes, key=lambda node: node.index)
    conditions = (row.condition for node in nodes for row in node.rows)
    yield from (condition for condition in conditions if condition is not None and condition.holds)


def _sense(machine: GoalMachine, state: GoalActivity, view: View) -> None:
    """Look as the machine does while it waits."""
    if state.phase == "settling" and machine.achieved is not None:
        machine.achieved(view)
    elif state.phase == "running":
        for test in (machine.succeeded, machine.failed):
            if test is not None:
                test(view)

# SPDX-License-Identifier: Apache-2.0
"""A chart that is put into any of its states again, and knows two states from which the same can happen.

Rule: time stands still: a timer has run out or it has not, a state is old enough for a guard or it is not yet.
"""

from __future__ import annotations

import hashlib
import marshal
import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.configuration import Configuration
from rai_missions.engine.nodes import Node
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.guards.elapsed import Elapsed
from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction import PURSUED, Abstraction
from rai_missions.prove.activity_key import plain, told, told_timer
from rai_missions.prove.branches import Groups
from rai_missions.prove.control_env import kept_words
from rai_missions.prove.instrumented_chart import NOW
from rai_missions.prove.loops import Loop
from rai_missions.prove.parts import guards_in, parts
from rai_missions.states.tree.leaves import ActionLeaf

__all__ = ("Own", "State", "StateCodec")

State = tuple[Any, ...]
"""All that a chart remembers but the mission's own keys, to put it back."""
Own = Mapping[str, Any]
"""The mission's own keys and what stands under them."""
NONE: dict[Any, Any] = {}
A_LITTLE_S = 1e-3
"""A state is older than a guard asks for by so much, lest a sum of floats falls short."""


class StateCodec(Abstraction):
    """A chart whose states are saved, loaded and compared."""

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None) -> None:
        super().__init__(mission, ticker, terms=terms)
        self._levels = self._thresholds()
        self._quick = False
        self._atomic, self._last = self._config.atomic, self._config
        self.own_keys = self._every - self.open_keys
        """The keys that only the mission, answers and results write."""
        self.own_fade = any(mission.blackboard[key].max_age_s is not None for key in self.own_keys)
        """Some of them grow stale."""
        self._own_order: dict[frozenset[str], tuple[str, ...]] = {}
        self.groups: dict[str, Groups] = {}
        """State → the groups of its tree's waits and timeouts, where there are several: see `branches`."""
        self.loops: tuple[Loop, ...] = ()
        """The loops of which a few rounds may stand for all."""

    # -- ages -----------------------------------------------------------------------------------------------------

    def _thresholds(self) -> dict[str, tuple[float, ...]]:
        """State → the ages that guards ask for, ascending; empty for the mission itself."""
        found = {"": _ages([self.mission.transitions, self.mission.invariants])}
        for _, name, state in self.mission.walk():
            inner = set(type(state).model_fields) & {"states", "parallel"}
            own = [getattr(state, field) for field in type(state).model_fields if field not in inner]
            actions = {getattr(state, "action", ""), *(leaf.action for leaf in parts(own, ActionLeaf))}
            by_profile = [
                guards[action]
                for guards in (self.terms.succeeded, self.terms.failed)
                for action in actions & set(guards)
            ]
            found[name] = tuple(sorted({*_ages(own), *_ages(by_profile)}))
        return {name: ages for name, ages in found.items() if ages}

    def next_age(self, state: str) -> float | None:
        """The next age of a state that a guard asks for, in seconds."""
        age = NOW - self.view.entered.get(state, NOW)
        return next((each for each in self._levels.get(state, ()) if each > age), None)

    def grow_old(self, state: str, age: float) -> None:
        """A state has been active for so many seconds."""
        self.view.entered[state] = NOW - age - A_LITTLE_S

    @property
    def aging(self) -> list[str]:
        """The active states whose age can make a difference yet."""
        return [name for name in self._levels if name in self.view.entered and self.next_age(name) is not None]

    # -- what becomes of it ---------------------------------------------------------------------------------------

    @property
    def loose(self) -> list[str]:
        """The actions that run though nobody has told them to end."""
        return [goal.action for goal in self._ledger.goals.values() if goal.phase in PURSUED]

    def save(self) -> State:
        """What `load` puts back."""
        view = self.view
        return (
            self._config.atomic, self.mode, self._holder, self.outcome, self.why, self._final, self._number,
            self._order, _kept(self._memory), _kept(self._timers), _kept(self._running), _kept(self._pending),
            _kept(self._rounds), _kept(self._settling), _kept(self._calls), _kept(self._ledger.goals), self._unknown,
            self._cancel_by, _kept(view.entered), _kept(view.held), view.answer, self._known_of_robot(),
            self._listening, self._suspended, self.taken, self._frozen, self._laid_by, self._kept, self._queue,
            _kept(self.groups),
        )  # fmt: skip

    def _known_of_robot(self) -> dict[str, Any]:
        return {key: entry for key, entry in self.board.entries() if key not in self.own_keys}

    def own(self) -> dict[str, Any]:
        """What stands under the mission's own keys."""
        return {key: entry for key, entry in self.board.entries() if key in self.own_keys}

    def load(self, state: State, own: Own) -> None:
        """Be in a state again."""
        view = self.view
        (
            atomic, self.mode, self._holder, self.outcome, self.why, self._final, self._number, self._order,
            memory, timers, running, pending, rounds, settling, calls, goals, self._unknown, self._cancel_by,
            entered, held, view.answer, board, self._listening, self._suspended, self.taken, self._frozen,
            self._laid_by, self._kept, self._queue, groups,
        ) = state  # fmt: skip
        self._config = self._configured(atomic)
        self._memory, self._timers, self._running = memory.copy(), timers.copy(), running.copy()
        self._pending, self._rounds, self._settling = pending.copy(), rounds.copy(), settling.copy()
        self.groups = groups.copy()
        self._calls, self._ledger.goals, self._ledger.changed = calls.copy(), goals.copy(), False
        view.entered, view.held, view.event = entered.copy(), held.copy(), {}
        view.active = self._config.active
        self.board.refill(board, own)
        self.cause, self.false_invariant = "", ""
        self._quick, self._due, self._asked = False, frozenset(), ""
        self.leave_open()
        self._wavering.clear()

    def _configured(self, atomic: tuple[Node, ...]) -> Configuration:
        """The configuration of these states; saved states do not hold it, lest all there are be kept."""
        if atomic is not self._atomic:
            self._atomic = atomic
            self._last = self._graph.configuration(atomic) if atomic else self._graph.empty
        return self._last

    def core(self) -> bytes:
        """The same for two states that differ in the mission's own keys alone: 16 bytes."""
        return _digest((self._told_run(), self._told_goals(), self._told_facts()))

    def telling(self) -> tuple[str, ...]:
        """The mission's own keys that make a difference from here on."""
        keys = self.later.keys
        found = self._own_order.get(keys)
        if found is None:
            found = self._own_order[keys] = tuple(sorted(keys & self.own_keys))
        return found

    def key(self, core: bytes, own: Own, telling: tuple[str, ...]) -> bytes:
        """The same for two states from which the same can happen: 16 bytes."""
        if not telling:
            return core
        idle = self._idle
        entries = ((name, own.get(name)) for name in telling)
        return _digest((core, [None if entry is None else name in idle or entry[0] for name, entry in entries]))

    # -- rounds of loops ------------------------------------------------------------------------------------------

    def levels(self) -> tuple[tuple[Loop, int, bytes], ...]:
        """Each loop that runs, how many of its rounds have ended, and the core but for this number."""
        found = []
        for loop in self.loops:
            ended = self._rounds_of(loop)
            if ended is not None:
                running = self._running
                self._running = {**running, loop.state: _counting(running[loop.state], loop, None)}
                found.append((loop, ended, self.core()))
                self._running = running
        return tuple(found)

    def _rounds_of(self, loop: Loop) -> int | None:
        """How many rounds of a loop have ended; None where it does not run."""
        state = self._running.get(loop.state)
        memory = state.tree.nodes.get(loop.path, NONE) if state is not None else NONE
        return memory.get(loop.word, 0) if memory.get("status") == "running" else None

    def uncounted(self) -> bytes:
        """The same for two states that differ in the rounds of loops alone."""
        running = self._running
        for loop in self.loops:
            if self._rounds_of(loop) is not None:
                self._running = {**self._running, loop.state: _counting(self._running[loop.state], loop, None)}
        key = self.key(self.core(), self.own(), self.telling()) if self.outcome is None else b""
        self._running = running
        return key

    def go_round(self, loop: Loop, more: int) -> None:
        """So many more rounds of a loop have ended; nothing where it does not run."""
        ended = self._rounds_of(loop)
        if ended is not None:
            self._running[loop.state] = _counting(self._running[loop.state], loop, ended + more)

    # -- what tells states apart ----------------------------------------------------------------------------------

    def _told_run(self) -> tuple[Any, ...]:
        timers, recalls = self._timers, self.later.recalls
        return (
            self._config.key, self.mode, self._holder, self._suspended, self._final.index if self._final else -1,
            [(at, [node.index for node in nodes]) for at, nodes in sorted(self._memory.items()) if at in recalls],
            sorted([told_timer(key, timer) for key, timer in timers.items()]) if timers else (),
            [(name, until == math.inf) for name, until in sorted(self._pending.items())],
            [(name, str(each)) for name, each in sorted(self._rounds.items())] if self._rounds else (),
            list(self._settling), sorted(self._unknown), self._cancel_by == math.inf,
            (self._laid_by, self.taken, [kept_words(each) for each in self._kept]) if self._frozen else (),
            [kept_words(each) for each in self._queue],
            [(name, [sorted(each) for each in found]) for name, found in sorted(self.groups.items())],
        )  # fmt: skip

    def _told_goals(self) -> tuple[Any, ...]:
        """What runs, in the order in which it hears of things; of other goals, in whose way they stand."""
        goals = self._ledger.goals.values() if self._ledger.goals else ()
        return (
            [(name, told(state)) for name, state in self._running.items()],
            sorted(self._calls.values()),
            sorted([(goal.owner, goal.action, goal.phase) for goal in goals if goal.phase in PURSUED]),
            sorted(
                [rest for goal in goals if goal.phase not in PURSUED and (rest := self.remainder(goal)) is not None]
            ),
        )

    def _told_facts(self) -> tuple[Any, ...]:
        view, idle, kept = self.view, self._idle, self.later.keys
        own = self.own_keys
        board = sorted([entry for entry in self.board.entries() if entry[0] in kept and entry[0] not in own])
        return (
            [(name, self.next_age(name)) for name in self._levels if name in view.entered],
            [(memory, since == NOW) for memory, since in sorted(view.held.items())],
            sorted(view.answer.items()) if view.answer else (),
            [(n, None if entry is None else n in idle or plain(entry[0])) for n, entry in board],
        )


def _counting(state: Any, loop: Loop, ended: int | None) -> Any:
    """A tree's state with another number of rounds of a loop; without one where there is none."""
    memory = {word: value for word, value in state.tree.nodes[loop.path].items() if word != loop.word}
    if ended is not None:
        memory[loop.word] = ended
    return state._replace(tree=state.tree._replace(nodes={**state.tree.nodes, loop.path: memory}))


def _digest(parts: tuple[Any, ...]) -> bytes:
    try:
        said = marshal.dumps(parts, 2)
    except ValueError:  # a picture, a mapping of some kind
        said = repr(parts).encode()
    return hashlib.blake2b(said, digest_size=16).digest()


def _kept(store: dict[Any, Any]) -> dict[Any, Any]:
    """A copy; most are empty, and share one."""
    return dict(store) if store else NONE


def _ages(part: Any) -> tuple[float, ...]:
    return tuple(sorted({each.elapsed_s for each in guards_in(part) if isinstance(each, Elapsed)}))

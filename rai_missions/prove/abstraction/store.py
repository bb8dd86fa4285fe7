# SPDX-License-Identifier: Apache-2.0
"""What few steps look at: the mission's own keys, the lists it goes over, and the goals that no state pursues any more.

Rule: a step happens alike in every store that answers alike what the step has asked of it. So stores are kept apart
from the rest of a state, each distinct one is one object, and each question is answered once for each.
"""

from __future__ import annotations

import hashlib
import marshal
import math
from collections import Counter
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from itertools import count
from typing import Any, NamedTuple

from rai_missions.engine.activities.goal_ledger import Goal, obstruction
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.keys import Stamped
from rai_missions.prove.abstraction.open_rounds import PREFIX
from rai_missions.prove.analysis.counts import Bounds, clamped, with_counts

__all__ = (
    "ALL_GOALS",
    "LEFT",
    "MANY",
    "ObstructionQuery",
    "Rivals",
    "Store",
    "StoreChange",
    "StoreQuery",
    "Stores",
    "fingerprint",
    "first_alike",
)  # fmt: skip

MANY = 2
"""How many alike goals represent any number more."""
LEFT = 1_000_000_000
"""From here on the goals of a store are numbered, in each state that it is put back into."""
NONE: Bounds = {}
REMEMBERED = 50_000
"""Stores, changes and answers that are remembered; past that all are forgotten."""


class ObstructionQuery(NamedTuple):
    """Asks whether goals are in the way of an action."""

    action: str


ALL_GOALS = "every goal", ()
"""Asks for all that makes a difference of the goals."""


class Store:
    """The mission's own keys, the lists that are gone over, and the goals that nothing pursues: equal ones are one.

    Args:
        number: Its own.
        keys: Key, or name of a list, → entry.
        goals: In the order in which they were given up; how they are numbered makes no difference.
        counters: Keys that a step counts on from any value.
    """

    __slots__ = ("board", "goals", "keys", "ledger", "number", "rounds")

    def __init__(
        self, number: int, keys: Mapping[str, Any], goals: tuple[Goal, ...], counters: Collection[str] = ()
    ) -> None:
        self.number, self.keys, self.goals = number, keys, goals
        self.rounds = {key.removeprefix(PREFIX): entry[0] for key, entry in keys.items() if key.startswith(PREFIX)}
        """State → the list that it goes over, as a step has it."""
        board = {key: entry for key, entry in keys.items() if not key.startswith(PREFIX)} if self.rounds else keys
        self.board = with_counts(board, counters) if counters else board
        """The keys as a step has them."""
        self.ledger = {LEFT + at: goal._replace(number=LEFT + at) for at, goal in enumerate(goals)}
        """The goals as a run has them."""


class StoreChange(NamedTuple):
    """What a step does to a store."""

    number: int
    written: Mapping[str, Any]
    added: Mapping[str, int]
    """Key → what is added to its number."""
    goals: tuple[Goal, ...]
    """The goals that were given up; all that are left, where the step has asked for every goal."""
    is_absolute: bool
    rivals: Rivals
    """Of each goal what makes a difference afterwards."""
    kept: Kept
    """Of each key what may be read of it afterwards; None where that is nothing."""
    question: StoreQuery
    """Asks for all that makes a difference afterwards."""


Rivals = Callable[[Goal], tuple[Any, ...] | None]
"""All that makes a difference of a goal that nothing pursues; None where that is nothing."""


Kept = Callable[[str, Any], Any]
"""What may be read later of the entry of a key."""


class StoreQuery:
    """Parts of a store that are asked for together; an answer is 16 bytes, none where nothing is asked."""

    __slots__ = ("_answers", "_parts")

    def __init__(self, parts: Iterable[Callable[[Store], Any]]) -> None:
        self._parts = tuple(parts)
        self._answers: dict[int, bytes] = {}

    def of(self, store: Store) -> bytes:
        """The answer of a store, equal for two stores that answer alike."""
        if not self._parts:
            return b""
        found = self._answers.get(store.number)
        if found is None:
            if len(self._answers) >= REMEMBERED:
                self._answers.clear()
            found = self._answers[store.number] = fingerprint([part(store) for part in self._parts])
        return found


class Stores:
    """Every store that was met, and what is asked of them.

    Args:
        facts: Which actions exclude each other.
        classes: Key of which some values make no difference to any guard → what distinguishes the others.
        counters: Of these the ones that a step counts on from any value.
        bounds: Key → the bounds past which no guard distinguishes its values.
        idle: Keys whose value makes no difference, wherever it is copied.
    """

    def __init__(
        self,
        facts: RobotFacts,
        classes: Mapping[str, Callable[[Any], Any]],
        counters: Collection[str] = (),
        bounds: Bounds = NONE,
        idle: Collection[str] = (),
    ) -> None:
        self._facts, self._bounds, self._idle = facts, bounds, frozenset(idle)
        self._classes = {**classes, **dict.fromkeys(self._idle, _is_there)}
        self.counters = frozenset(counters)
        self._numbers = count()
        self._found: dict[bytes, Store] = {}
        self._changes: dict[bytes, StoreChange] = {}
        self._after: dict[tuple[int, int], tuple[Store, bytes]] = {}
        """Numbers of a store and a change → the store afterwards, and what its question finds there."""
        self._questions: dict[frozenset[Any], StoreQuery] = {}

    @property
    def known(self) -> Collection[Store]:
        """The stores that were met, as far as they are remembered."""
        return self._found.values()

    def store(self, keys: Mapping[str, Any], goals: tuple[Goal, ...]) -> Store:
        """The one of these."""
        entries = [(key, tuple(entry)) for key, entry in sorted(keys.items()) if entry is not None]
        mark = fingerprint((entries, _plain(goals)))
        found = self._found.get(mark)
        if found is None:
            if len(self._found) >= REMEMBERED:
                self._found.clear()
                self._after.clear()
            found = self._found[mark] = Store(next(self._numbers), keys, goals, self.counters)
        return found

    def change(
        self,
        written: Mapping[str, Any],
        added: Mapping[str, int],
        goals: tuple[Goal, ...],
        rivals: Rivals,
        kept: Kept,
        question: StoreQuery,
        *,
        is_absolute: bool,
    ) -> StoreChange:
        """The one that does this.

        Args:
            written: Key → its new entry; None for one that went stale.
            added: Key → what is added to its number.
            goals: Those that were given up, or all that are left.
            rivals: Of each goal what makes a difference afterwards.
            kept: Of each key what may be read of it afterwards.
            question: Asks for all that makes a difference afterwards; the same wherever `kept` is.
            is_absolute: No other goals are left.
        """
        entries = [(key, entry and tuple(entry)) for key, entry in sorted(written.items())]
        mark = fingerprint((entries, sorted(added.items()), _plain(goals), is_absolute, id(rivals), id(kept)))
        found = self._changes.get(mark)
        if found is None:
            if len(self._changes) >= REMEMBERED:
                self._changes.clear()
            found = self._changes[mark] = StoreChange(
                next(self._numbers), written, added, goals, is_absolute, rivals, kept, question
            )
        return found

    def after(self, store: Store, change: StoreChange) -> tuple[Store, bytes]:
        """What becomes of a store by a change, and all that makes a difference of it then."""
        place = store.number, change.number
        found = self._after.get(place)
        if found is not None:
            return found
        new = store
        if change.written or change.added or change.goals or store.goals or store.keys:
            goals = change.goals if change.is_absolute else (*store.goals, *change.goals)
            keys = {**store.keys, **change.written}
            for key, more in change.added.items():
                value, at = keys[key]
                keys[key] = Stamped(clamped(self._bounds, key, value + more), at)
            keys = {key: entry for key, each in keys.items() if each and (entry := change.kept(key, each)) is not None}
            new = self.store(keys, first_alike(goals, change.rivals))
        found = self._after[place] = new, change.question.of(new)
        return found

    # -- what is asked --------------------------------------------------------------------------------------------

    def looked_at(
        self, keys: Iterable[str], written: Container[str], counted: Iterable[tuple[str, int]] = ()
    ) -> Iterator[Any]:
        """What is asked by looking at keys: of one that is written as well its value, which may be added to.

        Args:
            keys: They.
            written: The keys that were written.
            counted: Numbers that were counted, and what had been added to each when it was looked at.
        """
        yield from counted
        numbers = {key for key, _ in counted}
        for key in keys:
            if key not in numbers:
                is_alike = key in self._idle or (key in self._classes and key not in written)
                yield (key,) if is_alike else key

    def question(self, asked: Iterable[Any]) -> StoreQuery:
        """The one that asks for these: keys, keys in classes, obstructions, every goal."""
        place = frozenset(asked)
        found = self._questions.get(place)
        if found is None:
            found = self._questions[place] = StoreQuery([self._part(each) for each in sorted(place, key=repr)])
        return found

    def _part(self, asked: Any) -> Callable[[Store], Any]:
        if asked == ALL_GOALS:
            return lambda store: _plain(store.goals)
        if isinstance(asked, ObstructionQuery):
            facts, action = self._facts, asked.action
            return lambda store: obstruction(store.ledger, facts, action)
        if isinstance(asked, tuple):
            key, *added = asked
            class_of = self._classes[key]
            if added and added[0]:
                return lambda store: class_of(_more(value_of(store.keys, key), added[0]))
            return lambda store: class_of(value_of(store.keys, key))
        return lambda store: value_of(store.keys, asked)


def first_alike(goals: Iterable[Goal], rivals: Rivals) -> tuple[Goal, ...]:
    """The goals that make a difference; of many alike as many as represent any number."""
    found, many = list[Goal](), Counter[tuple[Any, ...]]()
    for goal in goals:
        alike = rivals(goal)
        if alike is not None and many[alike] < MANY:
            many[alike] += 1
            found.append(goal)
    return tuple(found)


def value_of(keys: Mapping[str, Any], key: str) -> Any:
    """The value of a key; None for nothing."""
    entry = keys.get(key)
    return None if entry is None else entry.value


def _is_there(value: Any) -> bool:
    return value is not None


def _more(value: Any, added: int) -> Any:
    return value + added if type(value) is int else value


def fingerprint(parts: Any) -> bytes:
    """16 bytes that differ wherever values do."""
    try:
        mark = marshal.dumps(parts, 2)
    except ValueError:  # a picture, a mapping of some kind
        mark = repr(parts).encode()
    return hashlib.blake2b(mark, digest_size=16).digest()


def _plain(goals: Iterable[Goal]) -> list[tuple[Any, ...]]:
    return [
        (each.owner, each.action, each.phase, each.until == math.inf, each.is_refused, each.is_lost) for each in goals
    ]

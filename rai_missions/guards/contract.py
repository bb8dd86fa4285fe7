# SPDX-License-Identifier: Apache-2.0
"""What every guard must do, as a function that a kind's tests call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rai_missions.guards.guard import Guard, Site
from rai_missions.guards.purity import impurity
from rai_missions.keys import Key, Stamped

__all__ = ("check_guard",)


class _View:
    """A moment in which nothing but the blackboard is known."""

    def __init__(self, facts: Mapping[str, Any], at: float) -> None:
        self.at, self.board = at, {name: Stamped(value, at) for name, value in facts.items()}
        self.active: frozenset[str] = frozenset()
        self.entered: Mapping[str, float] = {"": 0.0}
        self.held: Mapping[str, float] = {}
        self.event: Mapping[str, Any] = {}
        self.answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> None:
        return None


def check_guard(guard: Guard, keys: Mapping[str, Key], facts: Iterable[Mapping[str, Any]]) -> None:
    """Hold a guard to the contract of `Guard`.

    Args:
        guard: One of the kind.
        keys: The keys that it reads, and others.
        facts: Blackboards that make it true, false and unknown.

    Raises:
        AssertionError: A promise is broken; the text has which.
    """
    kind = type(guard)
    why = impurity(kind) if kind in Guard.foreign else ""
    assert not why, f"'{guard.word}' is no pure guard: {why}"
    assert kind.model_validate(guard.written()) == guard, f"'{guard.word}' is not what it is written as"
    assert guard.words().strip() and "\n" not in guard.words(), f"'{guard.word}' has no words, or more than a line"
    first, second = Site("/when", keys), Site("/when", keys)
    tests, site = (guard.compile(first), guard.compile(second)), first
    named = {path.partition(".")[0] for each in guard.walk() for path in each.paths()}
    assert site.reads - {"*"} <= named, f"'{guard.word}' reads what none of its fields names: {site.reads - named}"
    for number, known in enumerate(facts):
        view = _View(known, float(number))
        before = dict(view.board)
        values = [test(view) for test in (*tests, *tests)]
        assert all(value is values[0] for value in values), f"'{guard.word}' differs from look to look: {values}"
        assert values[0] in (True, False, None), f"'{guard.word}' is neither true, false nor unknown: {values[0]!r}"
        assert view.board == before, f"'{guard.word}' changes the blackboard"
    if guard.fades and named and named <= keys.keys():
        missing = tests[0](_View({}, 0.0))
        assert missing is None, f"'{guard.word}' is {missing} while nothing is known; or set `fades = False`"

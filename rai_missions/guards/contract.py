# SPDX-License-Identifier: Apache-2.0
"""What every guard must do, as a function that a kind's tests call."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rai_missions.errors import UsageError, article
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site
from rai_missions.keys import Key, Stamped
from rai_missions.model import TaggedModel
from rai_missions.redaction import clipped, shown

__all__ = ("check_guard", "check_kind")


class _View:
    """A moment in which nothing but the blackboard is known."""

    def __init__(self, facts: Mapping[str, Any], at: float) -> None:
        self.at, self.board = at, {name: Stamped(value, at) for name, value in facts.items()}
        self.active: frozenset[str] = frozenset()
        self.entered: Mapping[str, float] = {"": 0.0}
        self.true_since: Mapping[str, float] = {}
        self.event: Mapping[str, Any] = {}
        self.answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> None:
        return None

    def note(self, text: str) -> None:
        return None


def check_kind(part: TaggedModel, sort: str, lines: Callable[[], Iterable[str]]) -> None:
    """Hold one of a kind to what kinds of every sort promise: pure code, the form it is written in, words.

    Args:
        part: One of the kind.
        sort: What it is, for the text: `guard` or `activity`.
        lines: Its words, called once its code is known to be pure.

    Raises:
        AssertionError: A promise is broken; the text names it.
        UsageError: It is none of a kind.
    """
    given: object = part
    if not isinstance(given, TaggedModel):
        raise UsageError(f"to its contract is held one {sort}, made by its class, and not {shown(given, by=clipped)}")
    kind = type(part)
    why = kind.admit(kind) if kind in kind.foreign else ""
    assert not why, f"'{part.word}' may not be used as {article(sort)}: {why}"
    assert kind.model_validate(part.written()) == part, f"'{part.word}' is not what it is written as"
    assert all(line.strip() and "\n" not in line for line in lines()), (
        f"'{part.word}' has no words, or more than a line"
    )


def check_guard(guard: Guard, keys: Mapping[str, Key], facts: Iterable[Mapping[str, Any]]) -> None:
    """Hold a guard to the contract of `Guard`.

    Args:
        guard: One of the kind.
        keys: The keys that it reads, and others.
        facts: Blackboards that make it true, false and unknown.

    Raises:
        AssertionError: A promise is broken, or the facts make no difference to the guard; the text has which.
        UsageError: There are no facts.
    """
    check_kind(guard, "guard", lambda: (guard.words(),))
    boards = [*facts]
    if not boards:
        raise UsageError("a guard is held to its contract on facts: give blackboards on which it is true and false")
    first, second = Site("/when", keys), Site("/when", keys)
    tests, site = (guard.compile(first), guard.compile(second)), first
    named = {path.partition(".")[0] for each in guard.walk() for path in each.paths()}
    assert site.reads - {"*"} <= named, f"'{guard.word}' reads what none of its fields names: {site.reads - named}"
    seen = {tests[0](_View({}, 0.0))}
    for number, known in enumerate(boards):
        view = _View(known, float(number))
        before = dict(view.board)
        values = [test(view) for test in (*tests, *tests)]
        assert all(value is values[0] for value in values), f"'{guard.word}' differs from look to look: {values}"
        assert values[0] in (True, False, None), f"'{guard.word}' is neither true, false nor unknown: {values[0]!r}"
        assert view.board == before, f"'{guard.word}' changes the blackboard"
        seen.add(values[0])
    assert len(seen) > 1, f"'{guard.word}' is {values[0]} whatever is known; give facts on which it is another"
    if guard.fades and named and named <= keys.keys():
        missing = tests[0](_View({}, 0.0))
        assert missing is None, f"'{guard.word}' is {missing} while nothing is known; or set `fades = False`"

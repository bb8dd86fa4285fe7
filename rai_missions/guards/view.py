# SPDX-License-Identifier: Apache-2.0
"""What a guard sees of a run, and where it is compiled.

Rule: a guard reads a `View` and nothing else. What is missing or stale makes it unknown (Kleene's three-valued logic).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, Protocol

from rai_missions.keys import Blackboard, Key

__all__ = ("Instant", "Operand", "Site", "Test", "Truth", "View", "as_counted", "concerns", "presence")

Truth = bool | None
"""True, False, or None: unknown."""


class View(Protocol):
    """All that a guard may see."""

    @property
    def at(self) -> float:
        """Now, in seconds on the run's clock."""

    @property
    def board(self) -> Blackboard: ...

    @property
    def active(self) -> frozenset[str]:
        """The active states, ancestors included."""

    @property
    def entered(self) -> Mapping[str, float]:
        """State → when it was last entered, for the states whose age a guard asks for."""

    @property
    def true_since(self) -> Mapping[str, float]:
        """Held guard → since when its inner guard has been true without a break."""

    @property
    def event(self) -> Mapping[str, Any]:
        """The payload of the event in hand."""

    @property
    def answer(self) -> Mapping[str, Any]:
        """The parameters of the option in hand."""

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate of the user's program."""

    def note(self, text: str) -> None:
        """Have the step note what went wrong in code that is not ours."""


def presence(state: str) -> str:
    """The word among watched keys for whether a state is active; no key begins so."""
    return f"#in {state}"


def concerns(watched: Collection[str], changed: Collection[str]) -> bool:
    """Whether a change is one by which a guard is woken; `*` watches every key."""
    return not frozenset(watched).isdisjoint(changed) or (
        "*" in watched and any(not name.startswith("#") for name in changed)
    )


Test = Callable[[View], Truth]
Instant = Callable[[View], float]
"""The next instant after now at which a guard may change without an event; infinity for never."""


class Site:
    """Where a guard is compiled: what it may refer to, and what it is found to depend on.

    Args:
        place: The JSON pointer of the guard; makes the names of its memories.
        keys: The mission's keys.
        state: The state whose transition or rule it is; `elapsed_s` counts from its entry. Empty for the mission's own.
    """

    def __init__(self, place: str, keys: Mapping[str, Key], state: str = "") -> None:
        self.place, self.keys, self.state = place, keys, state
        self.reads: set[str] = set()
        """The keys it looks at."""
        self.instants: list[Instant] = []
        self.held_guards: dict[str, Test] = {}
        """Memory → the inner guard of a `held`."""
        self.clocked: set[str] = set()
        """The states whose entry time it needs."""
        self.named: set[str] = set()
        self.states: set[str] = set()
        """The states whose activity it asks for."""
        self.passing = False
        """It looks at the event or the answer in hand."""
        self.counts: Truth = None
        """Which value of the guard in hand counts: its two others make no difference there. None: each counts."""

    def set_counts(self, counts: Truth) -> None:
        """Note which value counts of the guard that is compiled next; see `counts`."""
        self.counts = counts

    def asked(self, guard: Any, test: Test) -> Test:
        """How a guard that is compiled here is asked, `counts` of it being noted: by its test, but in a proof."""
        return test

    @property
    def watched(self) -> frozenset[str]:
        """What may change the guard, time excepted: keys (`*` for every key), and states by their `presence`.

        Whatever waits for a guard is woken by these and by `instants`, and by nothing else.
        """
        return frozenset(self.reads).union(map(presence, self.states))


def as_counted(value: Truth, counts: Truth) -> Truth:
    """A value where only one counts: this one, or the other for both that do not."""
    return value if counts is None else (value is counts) is counts


class Operand:
    """Where a comparison takes a value from: a key, a field within one, the event or the answer in hand.

    Args:
        path: `key`, `key.field`, `event.field` or `answer.name`.
        site: Learns which key is read and when it goes stale.
    """

    def __init__(self, path: str, site: Site) -> None:
        self.key, *self.fields = path.split(".")
        self.passing = self.key if self.key in ("event", "answer") and self.key not in site.keys else ""
        key = None if self.passing else site.keys.get(self.key)
        self.max_age_s = key.max_age_s if key else None
        if self.passing:
            site.passing = True
        else:
            site.reads.add(self.key)
            if self.max_age_s is not None:
                site.instants.append(self.goes_stale)

    def goes_stale(self, view: View) -> float:
        entry = view.board.get(self.key)
        return math.inf if entry is None or self.max_age_s is None else entry.at + self.max_age_s

    def read(self, view: View) -> Any:
        """The value, or None: never received, stale, or no such field."""
        if self.passing:
            value: Any = view.event if self.passing == "event" else view.answer
        else:
            entry = view.board.get(self.key)
            if entry is None or (self.max_age_s is not None and view.at >= entry.at + self.max_age_s):
                return None
            value = entry.value
        for field in self.fields:
            if not isinstance(value, Mapping):
                return None
            value = value.get(field)
        return value

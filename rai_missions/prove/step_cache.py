# SPDX-License-Identifier: Apache-2.0
"""What came of a happening, to be repeated wherever it can only go the same way.

Rule: a way is repeated where the store answers what the way has asked of it as it did then, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, NamedTuple, TypeVar

from rai_missions.prove.loops import Loop
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.state_key import SavedState
from rai_missions.prove.stimulus import HappeningKind
from rai_missions.prove.store import Store, StoreChange, StoreQuery

__all__ = ("Arrival", "CachedStep", "CaseTable", "StepCache", "StepOutcome", "joined")


class Arrival(NamedTuple):
    """What one step came to, but for what it left alone of the store."""

    way: Edge
    kind: HappeningKind
    has_moved: bool
    """A transition was taken, a round of a tree's loop has ended that took time, or a tree's wait has begun."""
    ended: tuple[str, str] | None
    """Outcome and why; None where the mission continues."""
    core: bytes = b""
    """That of the state afterwards; of an end what distinguishes it from others."""
    state: SavedState | None = None
    change: StoreChange | None = None
    mode: str = ""
    levels: tuple[tuple[Loop, int, bytes], ...] = ()
    """Loops that run, how many of their rounds have ended, and the core but for this."""
    kept: frozenset[str] | None = None
    """Where time passes and the robot is silent: what waits for time on, and not from the beginning."""
    is_of_goal: bool = False
    """It came of a report, or the silence, of a goal that nothing pursues."""

    @property
    def likeness(self) -> tuple[object, ...]:
        """The same for arrivals that lead alike from a state."""
        change = self.change.number if self.change is not None else self.ended
        return self.core, change, self.kind, self.has_moved, self.kept, self.is_of_goal


class StepOutcome(NamedTuple):
    """One way in which a happening can go, as it was made."""

    arrival: Arrival | None
    """None where it goes against what is assumed of the robot."""
    asked: frozenset[object]
    """What it has asked of the store: see `Stores.question`."""
    after: tuple[int, ...] | None
    """What is to be chosen for the next way; None after the last."""


class CachedStep(NamedTuple):
    """All that one happening can come to."""

    arrivals: list[Arrival]
    steps: int
    asked: frozenset[object]


def joined(courses: Iterable[CachedStep]) -> CachedStep:
    """All that several happenings can come to; of arrivals that lead alike the first."""
    arrivals, steps, asked = dict[object, Arrival](), 0, set[object]()
    for course in courses:
        steps += course.steps
        asked |= course.asked
        for each in course.arrivals:
            arrivals.setdefault(each.likeness, each)
    return CachedStep(list(arrivals.values()), steps, frozenset(asked))


Kind = TypeVar("Kind")

MOST_KNOWN = 1_000
"""What is remembered of one happening, or of one way of it; a counter without end would fill the memory."""


class CaseTable(Generic[Kind]):
    """What happens where certain questions have certain answers."""

    __slots__ = ("_by_question", "_many")

    def __init__(self) -> None:
        self._by_question: dict[StoreQuery, dict[bytes, Kind]] = {}
        self._many = 0

    def add(self, question: StoreQuery, store: Store, what: Kind) -> None:
        """Remember it, unless much is known already."""
        if self._many < MOST_KNOWN:
            self._by_question.setdefault(question, {})[question.of(store)] = what
            self._many += 1

    def find(self, store: Store) -> Kind | None:
        """What happens with this store, if it is known."""
        for question, found in self._by_question.items():
            what = found.get(question.of(store))
            if what is not None:
                return what
        return None


class StepCache:
    """What has come of one happening, whatever the store was."""

    __slots__ = ("ways", "whole")

    def __init__(self) -> None:
        self.whole = CaseTable[CachedStep]()
        """All that it came to."""
        self.ways: dict[tuple[int, ...], CaseTable[StepOutcome]] = {}
        """What is chosen before the first alternative always is → the ways that went so."""

# SPDX-License-Identifier: Apache-2.0
"""What came of a happening, to be repeated wherever it can only go the same way.

Rule: a way is repeated where the store answers what the way has asked of it as it did then, and where each part of the
state that it could look at is the same, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Generic, NamedTuple, Protocol, TypeVar

from rai_missions.prove.abstraction.state_key import SavedState
from rai_missions.prove.abstraction.store import Store, StoreChange, StoreQuery
from rai_missions.prove.analysis.loops import Loop
from rai_missions.prove.exploration.region_parts import Part, PartedState
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.stimulus import StimulusKind

__all__ = (
    "NOTHING",
    "WHOLE",
    "Arrival",
    "CachedStep",
    "CaseTable",
    "PartsView",
    "ReadsChange",
    "StepCache",
    "StepFootprint",
    "StepOutcome",
    "both",
    "joined",
)  # fmt: skip


class PartsView(NamedTuple):
    """A state taken apart, as far as it is asked whether a step can be repeated there."""

    numbers: tuple[int, ...]
    parts: Sequence[Part]


class ReadsChange(NamedTuple):
    """A step after which other things may be read later."""

    changed: tuple[tuple[int, Part], ...]
    """The groups whose parts it changed, and these."""
    reads: frozenset[str]
    """What may be read later on account of all parts."""

    def fits(self, view: PartsView) -> bool:
        """Whether the same may be read later where the step is made in another state."""
        parts = [*view.parts]
        for group, part in self.changed:
            parts[group] = part
        return frozenset[str]().union(*(part.reads for part in parts)) == self.reads


class StepFootprint(NamedTuple):
    """Where a step goes the same way."""

    needs: tuple[int, ...] = ()
    """The groups whose parts it could look at, ascending."""
    wakes: int = 0
    """What it could wake the others by, as bits: see `Regions.tokens`."""
    leaves: bool = False
    """It leaves the parallel state: nothing may happen then in the others."""
    turns: tuple[ReadsChange, ...] = ()

    def covers(self, view: PartsView) -> bool:
        """Whether it goes the same way in a state in which all that it needs is the same."""
        if self.wakes or self.leaves:
            for group, part in enumerate(view.parts):
                if group not in self.needs and (self.wakes & part.wakes or (self.leaves and not part.is_quiet)):
                    return False
        return all(turn.fits(view) for turn in self.turns)


NOTHING = StepFootprint()
"""The footprint of a step in a state that is not taken apart."""


class Arrival(NamedTuple):
    """What one step came to, but for what it left alone of the store."""

    way: Edge
    kind: StimulusKind
    has_moved: bool
    """A transition was taken, a round of a tree's loop has ended that took time, or a tree's wait has begun."""
    ended: tuple[str, str] | None
    """Outcome and why; None where the mission continues."""
    run_key: bytes = b""
    """What `StateCodec.run_key` is of the state afterwards; of an end what distinguishes it from others."""
    state: SavedState | None = None
    change: StoreChange | None = None
    mode: str = ""
    levels: tuple[tuple[Loop, int, bytes], ...] = ()
    """Loops that run, how many of their rounds have ended, and the key of the run but for this."""
    kept: frozenset[str] | None = None
    """Where time passes and the robot is silent: what waits for time on, and not from the beginning."""
    is_of_goal: bool = False
    """It came of a report, or the silence, of a goal that nothing pursues."""
    parted: PartedState | None = None
    """The state afterwards where it is taken apart; `run_key` is empty then."""
    changed: tuple[tuple[int, int], ...] | None = None
    """The groups whose parts it has changed, and the numbers of these; None where it has left the parallel state."""
    needs: tuple[int, ...] = ()
    """The groups that it rests on."""

    @property
    def likeness(self) -> tuple[object, ...]:
        """What arrivals are compared by: equal for those that lead alike from a state."""
        change = self.change.number if self.change is not None else self.ended
        return self.run_key, change, self.kind, self.has_moved, self.kept, self.is_of_goal, self.parted, self.needs


class StepOutcome(NamedTuple):
    """One way in which a happening can go, as it was made."""

    arrival: Arrival | None
    """None where it goes against what is assumed of the robot."""
    asked: frozenset[object]
    """What it has asked of the store: see `Stores.question`."""
    after: tuple[int, ...] | None
    """What is to be chosen for the next way; None after the last."""
    footprint: StepFootprint = NOTHING


class CachedStep(NamedTuple):
    """All that one happening can come to."""

    arrivals: list[Arrival]
    steps: int
    asked: frozenset[object]
    footprint: StepFootprint = NOTHING


def joined(cached_steps: Iterable[CachedStep]) -> CachedStep:
    """All that several happenings can come to; of arrivals that lead alike the first."""
    arrivals, steps, asked, footprint = dict[object, Arrival](), 0, set[object](), NOTHING
    for cached in cached_steps:
        steps += cached.steps
        asked |= cached.asked
        footprint = both(footprint, cached.footprint)
        for each in cached.arrivals:
            arrivals.setdefault(each.likeness, each)
    return CachedStep(list(arrivals.values()), steps, frozenset(asked), footprint)


def both(one: StepFootprint, other: StepFootprint) -> StepFootprint:
    """Where each of two steps goes the same way."""
    if one is NOTHING or other is NOTHING:
        return other if one is NOTHING else one
    needs = tuple(sorted({*one.needs, *other.needs}))
    return StepFootprint(needs, one.wakes | other.wakes, one.leaves or other.leaves, (*one.turns, *other.turns))


class Reusable(Protocol):
    """What can be repeated in some states."""

    @property
    def footprint(self) -> StepFootprint: ...


Kind = TypeVar("Kind", bound=Reusable)

MOST_KNOWN = 1_000
"""What is remembered of one happening, or of one way of it; a counter without end would fill the memory."""
WHOLE = PartsView((), ())
"""A state that is not taken apart."""


class CaseTable(Generic[Kind]):
    """What happens where certain questions have certain answers."""

    __slots__ = ("_by_question", "_many")

    def __init__(self) -> None:
        self._by_question: dict[tuple[StoreQuery, tuple[int, ...]], dict[object, list[Kind]]] = {}
        self._many = 0

    def add(self, question: StoreQuery, store: Store, what: Kind, view: PartsView = WHOLE) -> None:
        """Remember it, unless much is known already."""
        if self._many < MOST_KNOWN:
            needs = what.footprint.needs
            answer = question.of(store), tuple([view.numbers[group] for group in needs])
            self._by_question.setdefault((question, needs), {}).setdefault(answer, []).append(what)
            self._many += 1

    def find(self, store: Store, view: PartsView = WHOLE) -> Kind | None:
        """What happens with this store, if it is known."""
        for (question, needs), found in self._by_question.items():
            for what in found.get((question.of(store), tuple([view.numbers[group] for group in needs])), ()):
                footprint = what.footprint
                if footprint is NOTHING or footprint.covers(view):
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

# SPDX-License-Identifier: Apache-2.0
"""What each part of a state can do, as it is noted to be put together for every state that has the part.

Rule: what half of the parts can do is put together once for all states that have this half, where it rests on no part
of the other half and wakes none there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple

from rai_missions.prove.abstraction.store import Store, StoreChange, StoreQuery
from rai_missions.prove.exploration.part_codes import BITS
from rai_missions.prove.exploration.region_parts import Part, PartedState
from rai_missions.prove.exploration.step_cache import Arrival, CachedStep, CaseTable, StepCache
from rai_missions.prove.exploration.step_maker import StepCase

__all__ = (
    "ENDED",
    "KEPT",
    "LOUD",
    "OUTER",
    "TREES",
    "Course",
    "GroupCases",
    "Half",
    "Halves",
    "NotedArrival",
    "PartEntry",
)

LOUD, KEPT, TREES, ENDED = 1, 2, 4, 8
"""Some part is not quiet, runs what a pause leaves as it is, runs a tree, has come to its end."""
SUMMARY = 4
"""The bits of a summary below those of what parts wait for."""
MOVE, CHANGE, END, OTHER = range(4)
"""What an arrival does: change parts alone, or frame or store too; end the mission; all else."""
OUTER = KEPT | TREES
"""What of it decides what can happen around all parts."""


class NotedArrival(NamedTuple):
    """What came of a step, prepared for every state in which it happens."""

    kind: int
    shift: int
    """The difference that its parts make to the code of a state."""
    change: StoreChange | None
    arrival: Arrival


class Course:
    """All that what happens on account of one part, or around all, can come to.

    Args:
        step: That.
        parted: A state in which it happens.
        widest: The most parts that a state of the mission has.
    """

    __slots__ = ("footprint", "noted", "step", "steps", "wakes")

    def __init__(self, step: CachedStep, parted: PartedState, widest: int) -> None:
        self.step, self.footprint, self.steps = step, step.footprint, step.steps
        self.wakes = self.footprint.wakes << SUMMARY | self.footprint.leaves * LOUD
        """Where one of these is in the summary of a state, another part may be woken, or not be quiet."""
        found = (_noted(arrival, parted, widest) for arrival in step.arrivals)
        self.noted = [each for each in found if each is not None]

    def rests_on(self, group: int) -> bool:
        """Whether it looks at one part alone, and changes no other."""
        footprint = self.footprint
        changed = (each for turn in footprint.turns for each, _ in turn.changed)
        return footprint.needs in ((), (group,)) and all(each == group for each in changed)


def _noted(arrival: Arrival, parted: PartedState, widest: int) -> NotedArrival | None:
    """What came of a step, as it is noted in a state; None where it changes nothing."""
    target, change, changed, kind = arrival.parted, arrival.change, arrival.changed, arrival.kind
    if arrival.ended is not None and kind != "time":
        return NotedArrival(END, 0, change, arrival)
    if target is None or changed is None or change is None or kind in ("time", "command"):
        return NotedArrival(OTHER, 0, change, arrival)
    shift = sum((part - parted.parts[group]) << BITS * (widest - 1 - group) for group, part in changed)
    is_kept = not (change.written or change.added or change.goals or change.is_absolute)
    if target.frame != parted.frame or not is_kept:
        return NotedArrival(CHANGE, shift, change, arrival)
    return NotedArrival(MOVE, shift, change, arrival) if changed else None


class GroupCases:
    """What can happen on account of one part, or of the frame.

    Args:
        cases: The cases to distinguish.
        group: The part's group, or in place of it `OUTSIDE` or `OF_GOALS`.
    """

    __slots__ = ("caches", "group", "joined", "waits", "words")

    def __init__(self, cases: Sequence[StepCase], group: int) -> None:
        self.group, self.caches = group, [StepCache() for _ in cases]
        self.words = frozenset(each.happening.words for each in cases if each.happening.kind == "time")
        """What of it waits for time."""
        self.waits = bool(self.words)
        self.joined = CaseTable[Course]()
        """All that it comes to."""


class PartEntry:
    """A part in a frame, with what can happen on its account.

    Args:
        part: As it was numbered.
    """

    __slots__ = ("cases", "last", "part", "summary")

    def __init__(self, part: Part) -> None:
        self.part = part
        kept, trees = part.runs
        self.summary = part.wakes << SUMMARY | (not part.is_quiet) * LOUD | kept * KEPT | trees * TREES
        self.summary |= part.is_ended * ENDED
        self.cases: GroupCases | None = None
        """What can happen on its account; `last` where all others have come to their ends."""
        self.last: GroupCases | None = None

    def have(self, cases: GroupCases, *, is_last: bool) -> None:
        """Note what can happen on account of the part."""
        if is_last:
            self.last = cases
        else:
            self.cases = cases


class Half:
    """Parts of states that are next to each other, and what can happen on their account.

    Args:
        entries: The parts.
        first: The group of the first one.
        found: What can happen on account of each, and what it comes to.
    """

    __slots__ = ("is_own", "noted", "open", "reads", "steps", "summary", "turns", "waits", "wakes", "words")

    def __init__(self, entries: Sequence[PartEntry], first: int, found: Sequence[tuple[GroupCases, Course]]) -> None:
        self.is_own = all(course.rests_on(cases.group) for cases, course in found)
        """Each rests on its own part."""
        self.noted = [each for _, course in found for each in course.noted]
        self.steps = sum(course.steps for _, course in found)
        self.words = [cases.words for cases, _ in found]
        """What of it waits for time, part by part."""
        self.waits = any(self.words)
        self.summary = reduce(or_, (entry.summary for entry in entries), 0)
        self.open = sum(not entry.summary & ENDED for entry in entries)
        """How many of the parts have not come to their ends."""
        self.wakes = reduce(or_, (course.wakes for _, course in found), 0)
        parts = [entry.part for entry in entries]
        self.reads = _reads(parts)
        """What may be read later on account of these parts."""
        self.turns: list[tuple[frozenset[str], frozenset[str]]] = []
        """Of each step after which other things may be read later: what is read of these parts, and of all."""
        for turn in (turn for _, course in found for turn in course.footprint.turns):
            after = {first + place: part for place, part in enumerate(parts)} | dict(turn.changed)
            self.turns.append((_reads(after.values()), turn.reads))

    def fits(self, reads: frozenset[str]) -> bool:
        """Whether the same may be read later after its steps where the other half reads these."""
        return all(own | reads == every for own, every in self.turns)


def _reads(parts: Iterable[Part]) -> frozenset[str]:
    return frozenset[str]().union(*(part.reads for part in parts))


class Halves:
    """What is known of halves of states: by their code, and by what the store answers that their steps ask."""

    __slots__ = ("_cases",)

    def __init__(self) -> None:
        self._cases: dict[int, list[tuple[StoreQuery, dict[bytes, Half]]]] = {}

    def find(self, code: int, store: Store) -> Half | None:
        """The one with a code, with a store; None where it is not known."""
        for question, known in self._cases.get(code, ()):
            found = known.get(question.of(store))
            if found is not None:
                return found
        return None

    def add(self, code: int, question: StoreQuery, store: Store, half: Half) -> None:
        """Remember it wherever the store answers a question so."""
        cases = self._cases.setdefault(code, [])
        for other, known in cases:
            if other is question:
                known[question.of(store)] = half
                return
        cases.append((question, {question.of(store): half}))

# SPDX-License-Identifier: Apache-2.0
"""How a state that is taken apart is left: what each of its parts can do was made once, and is put together.

Rule: of each part, and of the frame, it is known what can happen there; it is the same in every state that has them. A
state is put together as a run, and a step made in it, only where none that was made before fits (`StepFootprint`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from operator import or_
from typing import Any, Protocol

from rai_missions.prove.abstraction.state_key import Place
from rai_missions.prove.abstraction.store import ALL_GOALS, Store, Stores
from rai_missions.prove.exploration.findings import Findings
from rai_missions.prove.exploration.part_codes import BITS, PartCodes
from rai_missions.prove.exploration.part_courses import (
    ENDED,
    KEPT,
    LOUD,
    OUTER,
    TREES,
    Course,
    GroupCases,
    Half,
    Halves,
    NotedArrival,
    PartEntry,
)
from rai_missions.prove.exploration.region_parts import PartedState, RegionParts
from rai_missions.prove.exploration.regions import OF_GOALS, OUTSIDE
from rai_missions.prove.exploration.separate_regions import EntangledError, SeparateRegions
from rai_missions.prove.exploration.step_cache import CachedStep, PartsView, StepCache, joined
from rai_missions.prove.exploration.step_maker import StepCase, StepOrigin
from rai_missions.prove.limits import Meter

__all__ = ("PartSteps", "Search")

HalfTable = tuple[Halves, Halves, Halves]
"""First halves, second halves, and what can happen around all parts by what decides it."""
TWO = 2
"""Where fewer parts have not come to their ends, what can happen on account of one rests on the others."""
MOST_HALVES = 50_000
"""Halves of states that are remembered; past that all are forgotten."""


class Search(Protocol):
    """The exploration, as it is seen from a state that is left."""

    meter: Meter
    findings: Findings

    @property
    def is_over(self) -> bool: ...

    def cases(self, number: int, place: Place) -> tuple[list[StepCase], list[StepCase]]: ...

    def cut_off(self, number: int) -> None: ...

    def depth_of(self, number: int) -> int: ...

    def note_parts(
        self, number: int, parts: Sequence[frozenset[str]], outer: frozenset[str], of_goals: frozenset[str]
    ) -> None: ...

    def note_no_waiting(self, number: int) -> None: ...

    def repeat(
        self, noted: Iterable[Sequence[NotedArrival]], steps: int, source: int, store: Store, code: int
    ) -> None: ...

    def again(self, cached: CachedStep, source: int, store: Store, parted: PartedState | None = None) -> None: ...

    def each_way(self, case: StepCase, here: StepOrigin, before: StepCache, view: PartsView) -> CachedStep: ...


class PartSteps:
    """Leaves states that are taken apart.

    Args:
        search: The exploration.
        parts: Takes states apart.
        codes: Has the codes of states.
        stores: The stores of states.
        owner_of: Whose goal, call, question or behaviour has a number in the state that is loaded.
        apart: Notes regions that share nothing, which are explored one at a time; None where all are side by side.
    """

    def __init__(
        self,
        search: Search,
        parts: RegionParts,
        codes: PartCodes,
        stores: Stores,
        owner_of: Callable[[int], str],
        apart: SeparateRegions | None = None,
    ) -> None:
        self._search, self._parts, self._codes, self._stores = search, parts, codes, stores
        self._owner_of, self._apart = owner_of, apart
        self._every_goal = stores.question([ALL_GOALS])
        self._around: dict[Any, GroupCases] = {}
        """StateFrame, with what all parts of a state have in common, → what can happen around them."""
        self._entries: list[list[dict[int, PartEntry]]] = []
        """StateFrame, group, number of a part → it."""
        self._by_frame: dict[int, HalfTable] = {}
        """StateFrame → what is known of halves of states that have it."""
        self._tables: dict[int, HalfTable] = {}
        """How the code of a state begins → the same."""
        self._halves = 0
        self._nothing = frozenset[str]()

    def leave(self, number: int, store: Store, code: int) -> None:
        """Everything that can happen in a state, which has a code among others."""
        if self._apart is not None:
            self._leave_apart(self._apart, number, self._codes.state(code), store, code)
        elif not self._leave_by_halves(number, store, code):
            self._leave_by_parts(number, self._codes.state(code), store, code)

    def _leave_by_halves(self, number: int, store: Store, code: int) -> bool:
        """Leave a state by halves of its parts, where each is known and rests on itself alone; whether that is so."""
        search, width = self._search, self._codes.widest
        if store.goals or width == 1:
            return False
        table = self._tables.get(self._codes.head_of(code))
        if table is None:
            table = self._table(code)
        inner = BITS * (width // 2)
        codes = code >> inner & (1 << BITS * width - inner) - 1, code & (1 << inner) - 1
        one, other = table[0].find(codes[0], store), table[1].find(codes[1], store)
        summary = one.summary | other.summary if one is not None and other is not None else 0
        outer = table[2].find(summary & OUTER, store)
        if one is None or other is None or outer is None:
            self._learn(table, codes, store, code)
            return False
        if not (one.is_own and other.is_own and outer.is_own) or one.open + other.open < TWO:
            return False
        if (one.wakes | other.wakes | outer.wakes) & summary:
            return False
        steps = one.steps + other.steps + outer.steps
        is_alike = (not one.turns or one.fits(other.reads)) and (not other.turns or other.fits(one.reads))
        if not (is_alike and search.meter.has_room(steps)):
            return False
        if one.waits or other.waits or outer.waits:
            search.note_parts(number, [*one.words, *other.words], self._nothing.union(*outer.words), self._nothing)
        else:
            search.note_no_waiting(number)
        search.repeat((one.noted, other.noted, outer.noted), steps, number, store, code)
        return True

    def _table(self, code: int) -> HalfTable:
        """What is known of the halves of states with the frame of one."""
        table = self._by_frame.setdefault(self._codes.state(code).frame, (Halves(), Halves(), Halves()))
        self._tables[self._codes.head_of(code)] = table
        return table

    def _learn(self, table: HalfTable, codes: tuple[int, int], store: Store, code: int) -> None:
        """Note what is known of the halves of a state, and of what can happen around all its parts."""
        if self._halves >= MOST_HALVES:
            self._tables.clear()
            self._by_frame.clear()
            self._halves = 0
        parted, middle = self._codes.state(code), self._codes.widest - self._codes.widest // 2
        entries, view = self._entries_of(parted), self._view(parted)
        around = reduce(or_, (entry.summary for entry in entries)) & OUTER
        for halves, key, first, some, by_group in (
            (table[0], codes[0], 0, entries[:middle], [entry.cases for entry in entries[:middle]]),
            (table[1], codes[1], middle, entries[middle:], [entry.cases for entry in entries[middle:]]),
            (table[2], around, 0, [], [self._around.get((parted.frame, around))]),
        ):
            if halves.find(key, store) is None and (found := self._known(by_group, store, view)) is not None:
                asked = frozenset[object]().union(*(course.step.asked for _, course in found))
                halves.add(key, self._stores.question(asked), store, Half(some, first, found))
                self._halves += 1

    def _leave_by_parts(self, number: int, parted: PartedState, store: Store, code: int) -> None:
        """Leave a state part by part."""
        search, entries = self._search, self._entries_of(parted)
        summary = reduce(or_, (entry.summary for entry in entries))
        by_group = self._cases_of(parted, entries, summary, store)
        found = self._known(by_group, store, self._view(parted))
        steps = sum(course.steps for _, course in found or ())
        if found is None or not search.meter.has_room(steps):
            self._make(number, parted, store)
            return
        if any(each.waits for each, _ in found):
            self._note_waiting(number, by_group)
        else:
            search.note_no_waiting(number)
        search.repeat([course.noted for _, course in found], steps, number, store, code)

    def _known(
        self, by_group: Iterable[GroupCases | None], store: Store, view: PartsView
    ) -> list[tuple[GroupCases, Course]] | None:
        """Each with all that it comes to in a state; None where that is not known of all."""
        found = []
        for each in by_group:
            course = each.joined.find(store, view) if each is not None else None
            if each is None or course is None:
                return None
            found.append((each, course))
        return found

    def _view(self, parted: PartedState) -> PartsView:
        return PartsView(parted.parts, self._parts.of(parted))

    def _entries_of(self, parted: PartedState) -> list[PartEntry]:
        frame, parts = parted
        try:
            return [entries[number] for entries, number in zip(self._entries[frame], parts, strict=True)]
        except LookupError:
            return self._new_entries(parted)

    def _new_entries(self, parted: PartedState) -> list[PartEntry]:
        while len(self._entries) <= parted.frame:
            self._entries.append([{} for _ in self._parts.frames[len(self._entries)].parallel.members])
        of = enumerate(zip(self._entries[parted.frame], parted.parts, strict=True))
        return [entries.setdefault(number, PartEntry(self._parts.of(parted)[group])) for group, (entries, number) in of]

    def _cases_of(
        self, parted: PartedState, entries: Sequence[PartEntry], summary: int, store: Store
    ) -> list[GroupCases | None]:
        """What can happen, as far as known, in each part, in the frame and with the goals that nothing pursues."""
        if summary & ENDED:
            open_ = [group for group, entry in enumerate(entries) if not entry.summary & ENDED]
            by_group = [entry.last if open_ in ([], [group]) else entry.cases for group, entry in enumerate(entries)]
        else:
            by_group = [entry.cases for entry in entries]
        by_group.append(self._around.get((parted.frame, summary & OUTER)))
        if store.goals:
            by_group.append(self._around.get((parted.frame, self._every_goal.of(store))))
        return by_group

    def _note_waiting(self, number: int, by_group: Sequence[GroupCases | None]) -> None:
        """Note what waits for time; none where nothing does."""
        parts = [
            each.words if each is not None else self._nothing for each in by_group if each is None or each.group >= 0
        ]
        outer = [each.words for each in by_group if each is not None and each.group == OUTSIDE]
        goals = [each.words for each in by_group if each is not None and each.group == OF_GOALS]
        self._search.note_parts(number, parts, self._nothing.union(*outer), self._nothing.union(*goals))

    def _leave_apart(self, apart: SeparateRegions, number: int, parted: PartedState, store: Store, code: int) -> None:
        """Leave a state with steps of one group alone, once that has moved."""
        head, depth = self._codes.head_of(code), self._search.depth_of(number)
        groups = [*apart.moved(head, parted.parts), OUTSIDE]
        summary = reduce(or_, (entry.summary for entry in self._entries_of(parted)))
        by_group = self._make(number, parted, store, groups)
        if store.goals or summary & (LOUD | KEPT | TREES | ENDED) or any(each.waits for each in by_group):
            raise EntangledError
        view = self._view(parted)
        outcomes = {each.group: found.step for each in by_group if (found := each.joined.find(store, view)) is not None}
        if not self._search.is_over:
            apart.leave(head, parted, [part.wakes for part in view.parts], depth, outcomes)

    def _make(self, number: int, parted: PartedState, store: Store, scopes: Sequence[int] = ()) -> list[GroupCases]:
        """Make what can happen in a state, where not all of it is known.

        Args:
            number: The state's.
            parted: Its parts.
            store: Its store.
            scopes: Of which groups; none of these: of all, and of all that is around them.

        Returns:
            What can happen on account of each of these.
        """
        view = self._view(parted)
        place = self._parts.place(parted, store)
        entries = self._entries_of(parted)
        summary = reduce(or_, (entry.summary for entry in entries))
        known = self._cases_of(parted, entries, summary, store)
        if None in known:
            self._search.findings.stop(number, place)
        found, others = self._search.cases(number, place)
        by_scope = self._by_scope(parted, [*found, *others])
        every = [*range(len(entries)), OUTSIDE, OF_GOALS]
        waiting = [
            [case for scope in some for case in by_scope[scope] if case.happening.kind == "time"]
            for some in (every[:-1], every[-1:])
        ]
        here = StepOrigin(number, place, waiting[0], waiting[1], parted, view.parts)
        by_group = [each or GroupCases(by_scope[scope], scope) for each, scope in zip(known, every, strict=False)]
        open_ = [group for group, entry in enumerate(entries) if not entry.summary & ENDED]
        for group, (entry, each) in enumerate(zip(entries, by_group, strict=False)):
            entry.have(each, is_last=open_ in ([], [group]))
        self._around[parted.frame, summary & OUTER] = by_group[len(entries)]
        if store.goals:
            self._around[parted.frame, self._every_goal.of(store)] = by_group[-1]
        self._note_waiting(number, by_group)
        made = [each for each in by_group if not scopes or each.group in scopes]
        for each in made:
            self._make_cases(each, by_scope[each.group], here, view)
        return made

    def _make_cases(self, each: GroupCases, cases: Sequence[StepCase], here: StepOrigin, view: PartsView) -> None:
        store, cached_steps = here.place.store, []
        assert here.parted is not None
        for case, cache in zip(cases, each.caches, strict=True):
            if self._search.is_over:
                self._search.cut_off(here.number)
                return
            cached = cache.whole.find(store, view)
            if cached is not None:
                self._search.again(cached, here.number, store, here.parted)
            else:
                cached = self._search.each_way(case, here, cache, view)
            cached_steps.append(cached)
        whole = joined(cached_steps)
        made = Course(whole, here.parted, self._codes.widest)
        each.joined.add(self._stores.question(whole.asked), store, made, view)

    def _by_scope(self, parted: PartedState, cases: Iterable[StepCase]) -> dict[int, list[StepCase]]:
        """What can happen in a state, which is loaded, by the group that it concerns."""
        parallel, found = self._parts.frames[parted.frame].parallel, defaultdict[int, list[StepCase]](list)
        for case in cases:
            owner = self._owner_of(case.happening.number) if case.happening.number else ""
            scope = self._parts.regions.scope(parallel, case.happening, owner)
            found[scope].append(case._replace(scope=scope))
        return found

# SPDX-License-Identifier: Apache-2.0
"""How a state that is taken apart is left: what each of its parts can do was made once, and is put together.

Rule: of each part, and of the frame, it is known what can happen there; it is the same in every state that has them. A
state is put together as a run, and a step made in it, only where none that was made before fits (`StepFootprint`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, Protocol

from rai_missions.prove.limits import Meter
from rai_missions.prove.region_parts import Part, PartNumbers, RegionParts
from rai_missions.prove.regions import OF_GOALS, OUTSIDE
from rai_missions.prove.separate_regions import EntangledError, SeparateRegions
from rai_missions.prove.state_key import Place
from rai_missions.prove.step_cache import Arrival, CachedStep, CaseTable, PartsView, StepCache, joined
from rai_missions.prove.step_maker import StepCase, StepOrigin
from rai_missions.prove.store import ALL_GOALS, Store, StoreChange, Stores

__all__ = ("BITS", "CHANGE", "END", "MOVE", "Course", "PartSteps", "Search")

BITS = 24
"""Of a part's number in the code of a state; there are never so many parts as states."""
LOUD, KEPT, TREES, ENDED = 1, 2, 4, 8
"""Some part is not quiet, runs what a pause leaves as it is, runs a tree, has come to its end."""
SUMMARY = 4
"""So many bits lower than what parts wait for."""
OUTER = KEPT | TREES
"""What of it decides what can happen around all parts."""
MOVE, CHANGE, END, OTHER = range(4)
"""It changes parts alone, or frame or store too; it ends the mission; all else."""
MOST_STORES = 10_000
"""So many stores are remembered for each part; for others it is looked up."""


class NotedArrival(NamedTuple):
    """What came of a step, prepared for every state in which it happens."""

    kind: int
    shift: int
    """The difference that its parts make to the code of a state."""
    frame: int
    change: StoreChange | None
    arrival: Arrival


class Course:
    """All that what happens on account of one part, or around all, can come to.

    Args:
        step: That.
        spot: A state in which it happens.
        widest: The most parts that a state of the mission has.
    """

    __slots__ = ("arrivals", "footprint", "step", "steps", "wakes")

    def __init__(self, step: CachedStep, spot: PartNumbers, widest: int) -> None:
        self.step, self.footprint, self.steps = step, step.footprint, step.steps
        self.wakes = self.footprint.wakes << SUMMARY | self.footprint.leaves * LOUD
        """Where one of these is in the summary of a state, another part may be woken, or not be quiet."""
        found = (_noted(arrival, spot, widest) for arrival in step.arrivals)
        self.arrivals = [each for each in found if each is not None]


def _noted(arrival: Arrival, spot: PartNumbers, widest: int) -> NotedArrival | None:
    """What came of a step, as it is noted in a state; None where it changes nothing."""
    target, change, changed, kind = arrival.spot, arrival.change, arrival.changed, arrival.kind
    if arrival.ended is not None and kind != "time":
        return NotedArrival(END, 0, 0, change, arrival)
    if target is None or changed is None or change is None or kind in ("time", "command"):
        return NotedArrival(OTHER, 0, 0, change, arrival)
    shift = sum((part - spot.parts[group]) << BITS * (widest - 1 - group) for group, part in changed)
    if target.frame != spot.frame or not _is_nothing(change):
        return NotedArrival(CHANGE, shift, target.frame, change, arrival)
    return NotedArrival(MOVE, shift, target.frame, change, arrival) if changed else None


def _is_nothing(change: StoreChange) -> bool:
    return not (change.written or change.added or change.goals or change.is_absolute)


class Share:
    """What can happen on account of one part, or of the frame.

    Args:
        scenes: It.
        group: The part's group, or in place of it `OUTSIDE` or `OF_GOALS`.
    """

    __slots__ = ("by_store", "caches", "group", "joined", "waits", "words")

    def __init__(self, scenes: Sequence[StepCase], group: int) -> None:
        self.group, self.caches = group, [StepCache() for _ in scenes]
        self.words = frozenset(each.happening.words for each in scenes if each.happening.kind == "time")
        """What of it waits for time."""
        self.waits = bool(self.words)
        self.joined = CaseTable[Course]()
        """All that it comes to."""
        self.by_store: dict[int, Course] = {}
        """Number of a store → the same, where it rests on no other part."""

    def course(self, store: Store, view: PartsView) -> Course | None:
        """All that it comes to in a state; None where it is not known."""
        found = self.joined.find(store, view)
        is_own = found is not None and not found.footprint.turns and found.footprint.needs in ((), (self.group,))
        if found is not None and is_own and len(self.by_store) < MOST_STORES:
            self.by_store[store.number] = found
        return found


class Slot:
    """A part in a frame.

    Args:
        part: It.
    """

    __slots__ = ("last", "share", "summary")

    def __init__(self, part: Part) -> None:
        kept, trees = part.runs
        self.summary = part.wakes << SUMMARY | (not part.is_quiet) * LOUD | kept * KEPT | trees * TREES
        self.summary |= part.is_ended * ENDED
        self.share: Share | None = None
        """What can happen on its account; `last` where all others have come to their ends."""
        self.last: Share | None = None

    def have(self, share: Share, *, is_last: bool) -> None:
        """This can happen on its account."""
        if is_last:
            self.last = share
        else:
            self.share = share


class Search(Protocol):
    """The exploration, as it is seen from a state that is left."""

    meter: Meter

    @property
    def widest(self) -> int: ...

    @property
    def is_over(self) -> bool: ...

    def scenes(self, number: int, place: Place) -> tuple[list[StepCase], list[StepCase]]: ...

    def stop(self, number: int, place: Place) -> None: ...

    def cut_off(self, number: int) -> None: ...

    def depth_of(self, number: int) -> int: ...

    def waits(
        self, number: int, parts: Sequence[frozenset[str]], outer: frozenset[str], of_goals: frozenset[str]
    ) -> None: ...

    def waits_for_nothing(self, number: int) -> None: ...

    def repeat(
        self, courses: Iterable[Course], steps: int, source: int, spot: PartNumbers, store: Store, code: int
    ) -> None: ...

    def again(self, course: CachedStep, source: int, store: Store, spot: PartNumbers | None = None) -> None: ...

    def each_way(self, scene: StepCase, here: StepOrigin, before: StepCache, view: PartsView) -> CachedStep: ...


class PartSteps:
    """Leaves states that are taken apart.

    Args:
        search: The exploration.
        parts: Takes states apart.
        stores: The stores of states.
        owner_of: Whose goal, call, question or behaviour has a number in the state that is loaded.
        apart: Notes regions that share nothing, which are explored one at a time; None where all are side by side.
    """

    def __init__(
        self, search: Search, parts: RegionParts, stores: Stores, owner_of: Callable[[int], str],
        apart: SeparateRegions | None = None,
    ) -> None:  # fmt: skip
        self._search, self._parts, self._stores, self._owner_of = search, parts, stores, owner_of
        self._apart = apart
        self._every_goal = stores.question([ALL_GOALS])
        self._shares: dict[Any, Share] = {}
        """StateFrame, with what all parts of a state have in common, → what can happen around them."""
        self._slots: list[list[dict[int, Slot]]] = []
        """StateFrame, group, number of a part → it."""
        self._nothing = frozenset[str]()

    def leave(self, number: int, spot: PartNumbers, store: Store, code: int) -> None:
        """Everything that can happen in a state, which has a code among others."""
        if self._apart is not None:
            self._leave_apart(self._apart, number, spot, store, code)
            return
        slots, summary = self._slots_of(spot), 0
        for slot in slots:
            summary |= slot.summary
        shares, at = self._shares_of(spot, slots, summary, store), store.number
        courses, view, steps, waits = list[Course](), None, 0, False
        for share in shares:
            if share is None:
                self._make(number, spot, store)
                return
            course = share.by_store.get(at)
            if course is None or course.wakes & summary:
                view = view if view is not None else self._view(spot)
                course = share.course(store, view)
                if course is None:
                    self._make(number, spot, store)
                    return
            courses.append(course)
            steps += course.steps
            waits = waits or share.waits
        if not self._search.meter.has_room(steps):
            self._make(number, spot, store)
            return
        if waits:
            self._note_waiting(number, shares)
        else:
            self._search.waits_for_nothing(number)
        self._search.repeat(courses, steps, number, spot, store, code)

    def _view(self, spot: PartNumbers) -> PartsView:
        return PartsView(spot.parts, self._parts.of(spot))

    def _slots_of(self, spot: PartNumbers) -> list[Slot]:
        frame, parts = spot
        try:
            return [slots[number] for slots, number in zip(self._slots[frame], parts, strict=True)]
        except LookupError:
            return self._new_slots(spot)

    def _new_slots(self, spot: PartNumbers) -> list[Slot]:
        while len(self._slots) <= spot.frame:
            self._slots.append([{} for _ in self._parts.frames[len(self._slots)].parallel.members])
        of = enumerate(zip(self._slots[spot.frame], spot.parts, strict=True))
        return [slots.setdefault(number, Slot(self._parts.of(spot)[group])) for group, (slots, number) in of]

    def _shares_of(self, spot: PartNumbers, slots: Sequence[Slot], summary: int, store: Store) -> list[Share | None]:
        """Of each part, of the frame and of the goals that nothing pursues what can happen there, as far as known."""
        if summary & ENDED:
            open_ = [group for group, slot in enumerate(slots) if not slot.summary & ENDED]
            shares = [slot.last if open_ in ([], [group]) else slot.share for group, slot in enumerate(slots)]
        else:
            shares = [slot.share for slot in slots]
        shares.append(self._shares.get((spot.frame, summary & OUTER)))
        if store.goals:
            shares.append(self._shares.get((spot.frame, self._every_goal.of(store))))
        return shares

    def _note_waiting(self, number: int, shares: Sequence[Share | None]) -> None:
        """Note what waits for time; no shares where nothing does."""
        parts = [
            share.words if share is not None else self._nothing for share in shares if share is None or share.group >= 0
        ]
        outer = [share.words for share in shares if share is not None and share.group == OUTSIDE]
        goals = [share.words for share in shares if share is not None and share.group == OF_GOALS]
        self._search.waits(number, parts, self._nothing.union(*outer), self._nothing.union(*goals))

    def _leave_apart(self, apart: SeparateRegions, number: int, spot: PartNumbers, store: Store, code: int) -> None:
        """The same, but steps are made of one group alone once it has moved."""
        head, depth = code >> BITS * self._search.widest, self._search.depth_of(number)
        groups = [*apart.moved(head, spot.parts), OUTSIDE]
        summary = 0
        for slot in self._slots_of(spot):
            summary |= slot.summary
        shares = self._make(number, spot, store, groups)
        if store.goals or summary & (LOUD | KEPT | TREES | ENDED) or any(each.waits for each in shares):
            raise EntangledError
        view = self._view(spot)
        outcomes = {share.group: found.step for share in shares if (found := share.course(store, view)) is not None}
        if not self._search.is_over:
            apart.leave(head, spot, [part.wakes for part in view.parts], depth, outcomes)

    def _make(self, number: int, spot: PartNumbers, store: Store, scopes: Sequence[int] = ()) -> list[Share]:
        """The same where not all of it is known.

        Args:
            number: The state's.
            spot: Its parts.
            store: Its store.
            scopes: Of which groups; none of these: of all, and of all that is around them.

        Returns:
            What can happen on account of each of these.
        """
        view = self._view(spot)
        place = self._parts.place(spot, store)
        slots, summary = self._slots_of(spot), 0
        for slot in slots:
            summary |= slot.summary
        known = self._shares_of(spot, slots, summary, store)
        if None in known:
            self._search.stop(number, place)
        found, others = self._search.scenes(number, place)
        by_scope = self._by_scope(spot, [*found, *others])
        every = [*range(len(slots)), OUTSIDE, OF_GOALS]
        waiting = [[scene for scope in some for scene in by_scope[scope] if scene.happening.kind == "time"]
                   for some in (every[:-1], every[-1:])]  # fmt: skip
        here = StepOrigin(number, place, waiting[0], waiting[1], spot, view.parts)
        shares = [share or Share(by_scope[scope], scope) for share, scope in zip(known, every, strict=False)]
        open_ = [group for group, slot in enumerate(slots) if not slot.summary & ENDED]
        for group, (slot, share) in enumerate(zip(slots, shares, strict=False)):
            slot.have(share, is_last=open_ in ([], [group]))
        self._shares[spot.frame, summary & OUTER] = shares[len(slots)]
        if store.goals:
            self._shares[spot.frame, self._every_goal.of(store)] = shares[-1]
        self._note_waiting(number, shares)
        made = [share for share in shares if not scopes or share.group in scopes]
        for share in made:
            self._make_share(share, by_scope[share.group], here, view)
        return made

    def _make_share(self, share: Share, scenes: Sequence[StepCase], here: StepOrigin, view: PartsView) -> None:
        store, courses = here.place.store, []
        assert here.spot is not None
        for scene, cache in zip(scenes, share.caches, strict=True):
            if self._search.is_over:
                self._search.cut_off(here.number)
                return
            course = cache.whole.find(store, view)
            if course is not None:
                self._search.again(course, here.number, store, here.spot)
            else:
                course = self._search.each_way(scene, here, cache, view)
            courses.append(course)
        whole = joined(courses)
        made = Course(whole, here.spot, self._search.widest)
        share.joined.add(self._stores.question(whole.asked), store, made, view)

    def _by_scope(self, spot: PartNumbers, scenes: Iterable[StepCase]) -> dict[int, list[StepCase]]:
        """What can happen in a state, which is loaded, by the group that it concerns."""
        parallel, found = self._parts.frames[spot.frame].parallel, defaultdict[int, list[StepCase]](list)
        for scene in scenes:
            owner = self._owner_of(scene.happening.number) if scene.happening.number else ""
            scope = self._parts.regions.scope(parallel, scene.happening, owner)
            found[scope].append(scene._replace(scope=scope))
        return found

# SPDX-License-Identifier: Apache-2.0
"""All states that a mission can come into, breadth first, and what is wrong with any of them.

Rule: a step does the same wherever the mission's own keys that it looks at are the same, and is made once for these.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable, Sequence
from itertools import chain
from typing import NamedTuple

from rai_missions.prove.abstraction.activity_key import plain
from rai_missions.prove.abstraction.state_key import Place, SavedState
from rai_missions.prove.abstraction.store import ALL_GOALS, Store
from rai_missions.prove.analysis.loops import Level, Loop
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.findings import Findings
from rai_missions.prove.exploration.part_codes import PartCodes
from rai_missions.prove.exploration.part_courses import CHANGE, END, MOVE, NotedArrival
from rai_missions.prove.exploration.part_steps import PartSteps
from rai_missions.prove.exploration.region_parts import PartedState, RegionParts
from rai_missions.prove.exploration.regions import Regions
from rai_missions.prove.exploration.separate_regions import EntangledError, SeparateRegions, may_be_apart
from rai_missions.prove.exploration.step_cache import (
    NOTHING,
    WHOLE,
    Arrival,
    CachedStep,
    CaseTable,
    PartsView,
    StepCache,
    both,
    joined,
)
from rai_missions.prove.exploration.step_maker import StepCase, StepMaker, StepOrigin
from rai_missions.prove.limits import MOST_STATES, Limits, Meter
from rai_missions.prove.state_graph import REPORTED, Edge, StateGraph
from rai_missions.prove.stimulus import CANCEL, START, Stimulus

__all__ = ("Edge", "Space")

NOW_AND_THEN = 100
MOST_RUNS = 20_000
"""States that are remembered with all that happened in them."""
OnProgress = Callable[[int, int], None]


class RunCases(NamedTuple):
    """What can happen in all states of one run, or on account of the same goals there, and what has come of it."""

    saved: SavedState
    """The first of these states: the others differ from it in their stores alone."""
    cases: Sequence[StepCase]
    timed: Sequence[StepCase]
    """What of it waits for time."""
    caches: Sequence[StepCache]


class KnownRun(NamedTuple):
    """What is known of all states of one run with the same goals that nothing pursues."""

    waiting: int
    """The number of the set of what waits for time."""
    goal_words: frozenset[str]
    """What of it waits on account of these goals."""
    whole: CaseTable[CachedStep]
    """All that everything there comes to."""


class Space(StateGraph):
    """What was explored of a mission.

    Args:
        environment: The mission, and all that can happen to it.
        limits: What it may cost; a number is that of states.
        progress: Receives the number of states found and of states done, now and then.
        wanted: Promises; once each is known to be broken, the search ends. None of these: it continues.
        by_parts: Regions that do not look at each other are explored part by part: the same states, of fewer steps.
        one_by_one: Regions that share nothing are explored one at a time. Where they share something, after all, the
            search ends, and `is_entangled`.
    """

    def __init__(
        self,
        environment: Environment,
        limits: Limits | int = MOST_STATES,
        progress: OnProgress = lambda found, done: None,
        *,
        wanted: Collection[str] = (),
        by_parts: bool = True,
        one_by_one: bool = False,
    ) -> None:
        super().__init__()
        self.environment, self._progress, self._wanted = environment, progress, frozenset(wanted)
        self.meter = Meter(Limits(limits) if isinstance(limits, int) else limits)
        self.findings = Findings(environment, lambda: self.meter.refuted(self.states))
        """What the steps show of the mission."""
        self._by_parts, self._one_by_one = by_parts, one_by_one
        self._apart: SeparateRegions | None = None
        self._codes = PartCodes()
        self.is_entangled = False
        """Regions were explored one at a time, and share something: nothing was found out."""
        self._stores = environment.codec.stores
        self._every_goal = self._stores.question([ALL_GOALS])
        self.fresh = environment.codec.place()
        """Before the start."""
        self._frontier: deque[tuple[int, bytes, SavedState | None, Store, int]] = deque()
        """Number of a state, the key of its run and the state itself, or neither and its code; its store."""
        self._has_stores = False
        """States can differ in their stores alone."""
        self._cases_of: dict[bytes, RunCases] = {}
        """Key of a run, or of one with goals, → what can happen there, and what came of it."""
        self._words_here: Sequence[frozenset[str]] = ()
        """What waits for time in each part of the state that is left, where it is taken apart."""
        self._goal_words = frozenset[str]()
        """What waits for time on account of the goals of the store of the state that is left."""
        self._known: dict[bytes, KnownRun] = {}
        """Key of a run with goals → what is known of all states there."""
        self.ends: dict[int, str] = {}
        """Number of a state → the outcome with which the run has ended in it."""
        self.canceling: set[int] = set()
        self.levels: dict[int, dict[Loop, Level]] = {}
        """Number of a state → how far the loops are there of which a few rounds may represent all."""
        self.steps = 0
        self.made = 0
        """Steps that were really made; the others are repetitions."""
        self.cut: set[int] = set()
        """States out of which some step was not made, or leads where there was no room for it."""
        self.done = 0
        """States out of which every step was made, or as many as there was room for."""

    @property
    def is_whole(self) -> bool:
        """Nothing was left out for want of room."""
        return not self.cut and not self._frontier

    @property
    def covered(self) -> tuple[int, int, int]:
        """States and steps that were explored or are made up of such, and steps of the longest of the shortest ways."""
        if self._apart is None or not self.is_whole:
            return self.states, self.steps, self.depth
        left_out = self._apart.totals()
        return self.states + left_out.states, self.steps + left_out.steps, max(self.depth, left_out.depth)

    @property
    def unfinished(self) -> list[int]:
        """States whose steps were not explored, or not all."""
        return [*self.cut, *(each[0] for each in self._frontier)]

    @property
    def varieties(self) -> dict[str, int]:
        """Key → how many things are known of it in the states that were found, most first; only what differs."""
        found: dict[str, set[str]] = {}
        saved = [*(each.saved for each in self._cases_of.values()), *(each[2] for each in self._frontier if each[2])]
        for board in (*(each.board for each in self._stores.known), *(each.run.board for each in saved)):
            for key, entry in board.items():
                found.setdefault(key, set()).add(repr(None if entry is None else plain(entry.value)))
        many = sorted((-len(values), key) for key, values in found.items() if len(values) > 1)
        return {key: -negative for negative, key in many}

    def explore(self) -> None:
        """Find every state, or as many as the limits allow."""
        environment = self.environment
        self._has_stores = environment.has_stores
        regions = Regions(environment.chart, environment.world)
        parts = None
        if self._by_parts and regions.parallels and not environment.codec.loops:
            parts = RegionParts(environment.chart, environment.world, environment.codec, environment.rest, regions)
            self._codes = PartCodes(max(len(each.members) for each in regions.parallels.values()))
        self._maker = StepMaker(environment, parts, lambda source, way, idle: self.learn(source, way, is_paused=idle))
        if parts is not None and self._one_by_one and may_be_apart(environment, regions.parallels.values()):
            self._apart = SeparateRegions()
        by_parts = None
        if parts is not None:
            by_parts = PartSteps(self, parts, self._codes, self._stores, environment.inputs.owner_of, self._apart)
        try:
            self._search(by_parts)
        except EntangledError:
            self.is_entangled = True

    def _search(self, by_parts: PartSteps | None) -> None:
        start = StepCase(Stimulus(START, "start", self.environment.begin), -1)
        self.each_way(start, StepOrigin(-1, self.fresh), StepCache())
        frontier = self._frontier
        while frontier and not self.is_over:
            number, run_key, saved, store, code = frontier.popleft()
            if saved is not None:
                self._leave(number, run_key, Place(saved, store))
            elif by_parts is not None:
                by_parts.leave(number, store, code)
            self.done += 1
            if number % NOW_AND_THEN == 0:
                self._progress(self.states, number)

    @property
    def is_over(self) -> bool:
        """All that was wanted is known, or a limit is reached that ends the search at once."""
        return bool(self.meter.ended or (self._wanted and self._wanted <= self.findings.flaws.keys()))

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        """Take note of what the step that was just made shows."""
        self.findings.learn(source, way, is_paused=is_paused)

    # -- one state ------------------------------------------------------------------------------------------------

    def _leave(self, number: int, run_key: bytes, place: Place) -> None:
        """Everything that can happen in a state; what concerns its goals alone comes last."""
        store = place.store
        with_goals = run_key + self._every_goal.of(store) if store.goals else run_key
        inside = self._known.get(with_goals)
        cached = inside.whole.find(store) if inside is not None else None
        if inside is not None and cached is not None and self.meter.has_room(cached.steps):
            self.note_waiting(number, inside.waiting)
            self._goal_words = inside.goal_words
            self.again(cached, number, store)
            return
        known = self._cases_of.get(run_key)
        if known is None:
            self.findings.stop(number, place)
            known = self._run_cases(run_key, place.saved, self._every_case(number, place))
        else:
            place = Place(known.saved, store)
        more = self._cases_of.get(with_goals) if store.goals else RunCases(known.saved, (), (), ())
        more = more if more is not None else self._run_cases(with_goals, known.saved, self._of_goals(place))
        here = StepOrigin(number, place, known.timed, more.timed)
        inside = self._known_run(here, with_goals)
        cached_steps: list[CachedStep] = []
        cases, caches = (*known.cases, *more.cases), (*known.caches, *more.caches)
        for case, cache in zip(cases, caches, strict=True):
            if self.is_over:
                self.cut.add(number)
                return
            cached = cache.whole.find(store)
            if cached is not None:
                self.again(cached, number, store)
            else:
                cached = self.each_way(case, here, cache)
            if self._has_stores:
                cached_steps.append(cached)
        if cached_steps:
            whole = joined(cached_steps)
            inside.whole.add(self._stores.question(whole.asked), store, whole)

    def _known_run(self, here: StepOrigin, place: bytes) -> KnownRun:
        """What is known of all states of a run with the same goals; first of all what waits for time there."""
        self._goal_words = frozenset(each.happening.words for each in here.goals)
        words = self._goal_words.union(each.happening.words for each in here.waiting)
        number = self.note_words(here.number, words)
        inside = self._known.get(place) or KnownRun(number, self._goal_words, CaseTable())
        if self._has_stores:
            self._known[place] = inside
        return inside

    def cases(self, number: int, place: Place) -> tuple[list[StepCase], list[StepCase]]:
        """Everything that can happen there but an e-stop; what is about goals that nothing pursues apart."""
        return self._every_case(number, place), self._of_goals(place)

    def _every_case(self, number: int, place: Place) -> list[StepCase]:
        """Everything that can happen there but an e-stop, and what is about goals that nothing pursues."""
        self.environment.load(place)
        found = _cases(self.environment.happenings())
        if number not in self.canceling:
            order = self.environment.ordering("cancel")
            found.append(StepCase(Stimulus(CANCEL, "command", order, is_cancel=True), -1))
        return found

    def _of_goals(self, place: Place) -> list[StepCase]:
        """What can happen there on account of goals that nothing pursues."""
        self.environment.load(place)
        return _cases(self.environment.of_goals())

    def _run_cases(self, place: bytes, saved: SavedState, cases: list[StepCase]) -> RunCases:
        """Room for what comes of what happens in a place; it is not kept where nothing can be found there again."""
        made = RunCases(saved, cases, _timed(cases), [StepCache() for _ in cases])
        if self._has_stores:
            if len(self._cases_of) >= MOST_RUNS:
                self._cases_of.clear()
                self._known.clear()
            self._cases_of[place] = made
        return made

    def again(self, cached: CachedStep, source: int, store: Store, parted: PartedState | None = None) -> None:
        """Repeat a cached step in a state that differs in its store alone, or in parts that make no difference."""
        self.steps += cached.steps
        self.meter.spend(cached.steps, self.states)
        for arrival in cached.arrivals:
            self._arrive(source, arrival, store, parted)

    def each_way(self, case: StepCase, here: StepOrigin, before: StepCache, view: PartsView = WHOLE) -> CachedStep:
        """Let it happen in each way in which it can; those that went so before are not gone again."""
        store, arrivals, steps, asked = here.place.store, [], 0, set[object]()
        footprint = NOTHING
        chosen: tuple[int, ...] | None = ()
        keeps = self._has_stores or here.parted is not None
        self.environment.choices.forget_ways()
        while chosen is not None:
            ways = before.ways.get(chosen)
            made = ways.find(store, view) if ways is not None else None
            if made is None:
                made, work = self._maker.make(here, case, chosen)
                self.meter.work += work
                self.made += 1
                if keeps and not self.environment.choices.rests_on_others:
                    known = before.ways.setdefault(chosen, CaseTable())
                    known.add(self._stores.question(made.asked), store, made, view)
            steps += 1
            asked |= made.asked
            footprint = both(footprint, made.footprint)
            if made.arrival is not None:
                self._arrive(here.number, made.arrival, store, here.parted)
                arrivals.append(made.arrival)
            chosen = made.after
            if self.meter.spend(1, self.states) and chosen is not None and self.is_over:
                self.cut.add(max(here.number, 0))
                break
        self.steps += steps
        cached = CachedStep(arrivals, steps, frozenset(asked), footprint)
        if keeps and chosen is None:
            before.whole.add(self._stores.question(asked), store, cached, view)
        return cached

    def _arrive(self, source: int, arrival: Arrival, before: Store, parted: PartedState | None) -> None:
        """Take note of a step and of the state it leads to."""
        change, store, answer, target = arrival.change, before, b"", arrival.parted
        key: bytes | int = arrival.run_key
        if change is not None:
            store, answer = self._stores.after(before, change)
            key = (
                arrival.run_key + answer
                if target is None
                else self._code_after(source, arrival, target, answer, parted)
            )
        number = self._numbers.get(key)
        if number is None:
            number = self._find(key, source, arrival, store, answer)
            if number is None:
                return
        kind = arrival.kind
        if source < 0 or (source == number and not (kind == "time" and arrival.has_moved)):
            return  # what changes nothing leads nowhere
        kept = arrival.kept
        if kept is not None and self._goal_words and not arrival.is_of_goal:
            kept |= self._goal_words
        if kept is not None and parted is not None and arrival.changed is not None:
            kept = kept.union(*(words for group, words in enumerate(self._words_here) if group not in arrival.needs))
        self.join(source, number, kind, kept)

    def _code_after(
        self, source: int, arrival: Arrival, target: PartedState, answer: bytes, parted: PartedState | None
    ) -> int:
        """The code of the state that a step leads to, where it is taken apart."""
        stays = arrival.changed is not None and parted is not None
        if arrival.changed is not None and parted is not None:
            target = parted.moved(target.frame, arrival.changed)
        code = self._codes.code(target, answer)
        if self._apart is not None and not stays:
            depth = self._depths[source] + 1 if source >= 0 else 1
            self._apart.enter(self._codes.head_of(code), target.parts, depth)
        return code

    def repeat(self, noted: Iterable[Sequence[NotedArrival]], steps: int, source: int, store: Store, code: int) -> None:
        """Repeat what was noted in a state of which every part and the frame are known."""
        numbers, targets, kept, codes = self._numbers, self._targets, self._kept, self._codes
        inner = codes.inner(code)
        self.begin(source)
        for sort, shift, change, arrival in chain.from_iterable(noted):
            if sort == MOVE:
                number = numbers.get(code + shift)
                if number is None:
                    after = self._stores.after(store, change)[0] if change is not None else store
                    number = self._find(code + shift, source, arrival, after, b"")
            elif sort == CHANGE and change is not None and arrival.parted is not None:
                after, answer = self._stores.after(store, change)
                key = codes.first(arrival.parted, answer) + inner + shift
                number = numbers.get(key)
                if number is None:
                    number = self._find(key, source, arrival, after, answer)
            else:
                number = numbers.get(arrival.run_key) if sort == END else None
                if number is None:
                    self._arrive(source, arrival, store, codes.state(code))
            if number is not None and number != source and arrival.kind != "command":
                targets.append(number)
                kept.append(REPORTED)
        self.steps += steps
        self.meter.spend(steps, self.states)

    def _find(self, key: bytes | int, source: int, arrival: Arrival, store: Store, answer: bytes) -> int | None:
        """Take note of a state that is new; its number, or None where there is no room for it."""
        if self.states >= self.meter.limits.states:
            self.meter.is_full = True
            self.cut.add(max(source, 0))
            return None
        number = self._add(key, source, arrival.way)
        if arrival.ended is not None:
            self.ends[number] = arrival.ended[0]
        elif isinstance(key, int):
            self._frontier.append((number, b"", None, store, key))
        elif arrival.state is not None:
            self._frontier.append((number, arrival.run_key, arrival.state, store, 0))
            if arrival.levels:
                self.levels[number] = {loop: Level(ended, run_key + answer) for loop, ended, run_key in arrival.levels}
            if arrival.mode == "canceling":
                self.canceling.add(number)
        return number

    def note_parts(
        self, number: int, parts: Sequence[frozenset[str]], outer: frozenset[str], of_goals: frozenset[str]
    ) -> None:
        """Note what waits for time in a state that is left: in each part, around them, and on account of its goals."""
        self._words_here, self._goal_words = parts, of_goals
        self.note_words(number, outer.union(of_goals, *parts))

    def note_no_waiting(self, number: int) -> None:
        """Note that nothing waits for time in a state that is left."""
        self._words_here, self._goal_words = (), frozenset()
        self.note_waiting(number, self.number_of(self._goal_words))

    def cut_off(self, number: int) -> None:
        """Not every step out of a state was made."""
        self.cut.add(number)


def _cases(found: Iterable[Stimulus]) -> list[StepCase]:
    """Each with its place among those of the same words."""
    met, cases = Counter[str](), []
    for each in found:
        cases.append(StepCase(each, met[each.words]))
        met[each.words] += 1
    return cases


def _timed(found: Iterable[StepCase]) -> list[StepCase]:
    """What waits for time."""
    return [each for each in found if each.happening.kind == "time"]

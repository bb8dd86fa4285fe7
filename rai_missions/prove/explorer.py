# SPDX-License-Identifier: Apache-2.0
"""All states that a mission can come into, breadth first, and what is wrong with any of them.

Rule: a step does the same wherever the mission's own keys that it looks at are the same, and is made once for these.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection
from typing import NamedTuple

from rai_missions.prove.counts import Count
from rai_missions.prove.environment import RESUME, Environment
from rai_missions.prove.limits import MOST_STATES, Limits, Meter
from rai_missions.prove.loops import Level, Loop
from rai_missions.prove.state_graph import Edge, StateGraph
from rai_missions.prove.state_key import Place
from rai_missions.prove.step_cache import Arrival, CachedStep, CaseTable, StepCache, StepOutcome, joined
from rai_missions.prove.stimulus import Stimulus
from rai_missions.prove.store import ALL_GOALS, Store

__all__ = ("CANCEL", "KILL", "START", "Edge", "Space", "Violation")

NOW_AND_THEN = 100
MOST_COURSES = 20_000
"""So many states are remembered with all that happened in them."""
Progress = Callable[[int, int], None]
START, CANCEL, KILL = "the mission starts", "the operator cancels", "the operator gives the e-stop"


class Violation(NamedTuple):
    """A state, or a step out of it, that breaks a promise."""

    promise: str
    state: int
    """Its number; -1 is before the start."""
    sentence: str
    way: Edge | None = None
    """What happens in that state; None where the state itself is at fault."""


class Inside(NamedTuple):
    """What is known of all states of one core with the same goals that nothing pursues."""

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
    """

    def __init__(
        self, environment: Environment, limits: Limits | int = MOST_STATES,
        progress: Progress = lambda found, done: None, *, wanted: Collection[str] = (),
    ) -> None:  # fmt: skip
        super().__init__()
        self.environment, self._progress, self._wanted = environment, progress, frozenset(wanted)
        self.meter = Meter(Limits(limits) if isinstance(limits, int) else limits)
        self._stores = environment.codec.stores
        self._every_goal = self._stores.question([ALL_GOALS])
        self.fresh = environment.codec.place()
        """Before the start."""
        self._frontier: deque[tuple[int, bytes, Place]] = deque()
        self._has_stores = False
        """States can differ in their stores alone."""
        self._courses: dict[bytes, list[StepCache]] = {}
        """Core, or core and goals, → what came of what happens there."""
        self._here: list[Stimulus] = []
        """What waits for time in the state that is left, but for the goals of its store."""
        self._goals_here: list[Stimulus] = []
        self._goal_words = frozenset[str]()
        """What waits for time on account of these goals."""
        self._places: dict[bytes, Inside] = {}
        """Core and goals → what is known of all states there."""
        self.ends: dict[int, str] = {}
        """Number of a state → the outcome with which the run has ended in it."""
        self.canceling: set[int] = set()
        self.levels: dict[int, dict[Loop, Level]] = {}
        """Number of a state → how far the loops are there of which a few rounds may represent all."""
        self.taken: set[str] = set()
        """JSON pointers of the transitions that were taken."""
        self.entered: set[str] = set()
        self.flaws: dict[str, Violation] = {}
        """Promise → a shortest way to break it."""
        self.in_pause: set[str] = set()
        """Invariants that a robot's reports can break while the mission is paused or held, when not every rule acts."""
        self.steps = 0
        self.cut: set[int] = set()
        """States out of which some step was not made, or leads where there was no room for it."""
        self.done = 0
        """States out of which every step was made, or as many as there was room for."""

    @property
    def is_whole(self) -> bool:
        """Nothing was left out for want of room."""
        return not self.cut and not self._frontier

    @property
    def unfinished(self) -> list[int]:
        """States whose steps were not explored, or not all."""
        return [*self.cut, *(number for number, _, _ in self._frontier)]

    def explore(self) -> None:
        """Find every state, or as many as the limits allow."""
        self._has_stores = self.environment.has_stores
        start = Stimulus(START, "start", self.environment.begin)
        self._each_way(start, -1, self.fresh, -1, StepCache())
        while self._frontier and not self._is_over:
            number, core, place = self._frontier.popleft()
            self._leave(number, core, place)
            self.done += 1
            if number % NOW_AND_THEN == 0:
                self._progress(self.states, number)

    @property
    def _is_over(self) -> bool:
        """All that was wanted is known, or a limit is reached that ends the search at once."""
        return bool(self.meter.ended or (self._wanted and self._wanted <= self.flaws.keys()))

    # -- one state ------------------------------------------------------------------------------------------------

    def _leave(self, number: int, core: bytes, place: Place) -> None:
        """Everything that can happen in a state; what concerns its goals alone comes last."""
        store = place.store
        with_goals = core + self._every_goal.of(store) if store.goals else core
        inside = self._places.get(with_goals)
        course = inside.whole.find(store) if inside is not None else None
        if inside is not None and course is not None and self.meter.has_room(course.steps):
            self.waiting[number], self._goal_words = inside.waiting, inside.goal_words
            self._again(course, number, store)
            return
        known, more = self._courses.get(core), self._courses.get(with_goals) if store.goals else []
        if known is None:
            self._stop(number, place)
        found, others = self._happenings(number, place)
        known = known if known is not None else self._room(core, found)
        more = more if more is not None else self._room(with_goals, others)
        inside = self._inside(number, with_goals, found, others)
        courses: list[CachedStep] = []
        for at, (happening, cache) in enumerate(zip((*found, *others), (*known, *more), strict=True)):
            if self._is_over:
                self.cut.add(number)
                return
            course = cache.whole.find(store)
            if course is not None:
                self._again(course, number, store)
            else:
                place_of = -1 if happening.words == CANCEL else at - (at >= len(known) and number not in self.canceling)
                course = self._each_way(happening, place_of, place, number, cache)
            if self._has_stores:
                courses.append(course)
        if courses:
            whole = joined(courses)
            inside.whole.add(self._stores.question(whole.asked), store, whole)

    def _inside(self, number: int, place: bytes, found: list[Stimulus], others: list[Stimulus]) -> Inside:
        """What is known of all states of a core with the same goals; first of all what waits for time there."""
        self._here = [each for each in found if each.kind == "time"]
        self._goals_here = [each for each in others if each.kind == "time"]
        self._goal_words = frozenset(each.words for each in self._goals_here)
        waiting = self.wait(number, self._goal_words.union(each.words for each in self._here))
        inside = self._places.get(place) or Inside(waiting, self._goal_words, CaseTable())
        if self._has_stores:
            self._places[place] = inside
        return inside

    def _happenings(self, number: int, place: Place) -> tuple[list[Stimulus], list[Stimulus]]:
        """Everything that can happen there but an e-stop; what is about goals that nothing pursues apart."""
        self.environment.load(place)
        found, others = list(self.environment.happenings()), list(self.environment.of_goals())
        if number not in self.canceling:
            found.append(Stimulus(CANCEL, "command", self.environment.ordering("cancel")))
        return found, others

    def _room(self, place: bytes, found: list[Stimulus]) -> list[StepCache]:
        """Room for what comes of what happens in a place; it is not kept where nothing can be found there again."""
        room = [StepCache() for _ in found]
        if self._has_stores:
            if len(self._courses) >= MOST_COURSES:
                self._courses.clear()
                self._places.clear()
            self._courses[place] = room
        return room

    def _again(self, course: CachedStep, source: int, store: Store) -> None:
        """The same happens in a state that differs in its store alone."""
        self.steps += course.steps
        self.meter.spend(course.steps, self.states)
        for arrival in course.arrivals:
            self._arrive(source, arrival, store)

    def _each_way(self, happening: Stimulus, at: int, place: Place, source: int, before: StepCache) -> CachedStep:
        """Let it happen in each way in which it can; those that went so before are not gone again."""
        store, arrivals, steps, asked = place.store, [], 0, set[object]()
        chosen: tuple[int, ...] | None = ()
        while chosen is not None:
            ways = before.ways.get(chosen)
            made = ways.find(store) if ways is not None else None
            if made is None:
                made = self._make(happening, at, place, source, chosen)
                if self._has_stores:
                    before.ways.setdefault(chosen, CaseTable()).add(self._stores.question(made.asked), store, made)
            steps += 1
            asked |= made.asked
            if made.arrival is not None:
                self._arrive(source, made.arrival, store)
                arrivals.append(made.arrival)
            chosen = made.after
            if self.meter.spend(1, self.states) and chosen is not None and self._is_over:
                self.cut.add(max(source, 0))
                break
        self.steps += steps
        course = CachedStep(arrivals, steps, frozenset(asked))
        if self._has_stores and chosen is None:
            before.whole.add(self._stores.question(asked), store, course)
        return course

    def _make(self, happening: Stimulus, at: int, place: Place, source: int, chosen: tuple[int, ...]) -> StepOutcome:
        """Let it happen in one way."""
        environment, arrival = self.environment, None
        chart, world, instruments = environment.chart, environment.world, environment.instruments
        looked = world.board.looked
        environment.choices.begin(chosen)
        environment.load(place)
        is_idle = (chart.mode == "paused" and happening.words != RESUME) or (
            environment.control.is_held and happening.kind == "write"
        )
        looked.clear()
        world.board.counted.clear()
        environment.make(happening.do)
        self.meter.work += len(chart.state.draft.moves) + instruments.ticks
        is_possible = world.is_possible
        read, written = looked & world.stored, {key for key, _ in chart.state.draft.written}
        if is_possible:
            kept = self._left_waiting(happening) if happening.kind == "time" and environment.time.is_silent else None
            environment.settle()
            read |= (looked | world.asked_at_the_end) & world.stored
            way = Edge(happening.words, at, environment.choices.trail)
            self.learn(source, way, is_paused=is_idle)
            arrival = self._arrival(way, happening, place.store, kept)
        asked = instruments.asked.union(self._stores.looked_at(read, written, self._counted()))
        return StepOutcome(arrival, frozenset(asked), environment.choices.next())

    def _counted(self) -> set[tuple[str, int]]:
        """Numbers that were counted, and what had been added to each when it was looked at; none in a long step."""
        world = self.environment.world
        if self.environment.instruments.is_long or not world.board.counters:
            return set()
        entries = {key: world.board.known(key) for key in world.asked_at_the_end & world.board.counters}
        added = {
            (key, each[0].added if each is not None and each[0].__class__ is Count else 0)
            for key, each in entries.items()
        }
        return world.board.counted | added

    def _left_waiting(self, taken: Stimulus) -> frozenset[str]:
        """What waits for time on after a step; a step that is about no goal leaves those of the store as they are."""
        waiting = [*self._here, *self._goals_here] if taken.is_of_goal else self._here
        return self.environment.time.kept(waiting, taken.words)

    def _arrival(self, way: Edge, happening: Stimulus, before: Store, kept: frozenset[str] | None) -> Arrival:
        chart, codec, instruments = self.environment.chart, self.environment.codec, self.environment.instruments
        has_moved = bool(chart.state.draft.moves or instruments.turned or any(instruments.begun.values()))
        if chart.outcome is not None:
            ended = chart.outcome, chart.why
            return Arrival(way, happening.kind, has_moved, ended, repr(ended).encode())
        written, added = codec.changed(before, is_exact=instruments.is_long)
        goals, many = codec.given_up(), len(before.goals)
        if happening.is_of_goal or goals[:many] != list(before.ledger.values()):
            instruments.asked.add(ALL_GOALS)
        is_absolute = ALL_GOALS in instruments.asked
        ahead = codec.ahead()
        change = self._stores.change(
            written, added, tuple(goals if is_absolute else goals[many:]), self.environment.rest.rivals,
            ahead.kept, ahead.question, is_absolute=is_absolute,
        )  # fmt: skip
        levels = codec.levels() if codec.loops else ()
        return Arrival(
            way, happening.kind, has_moved, None, codec.core(), codec.take(), change, chart.mode, levels,
             kept, happening.is_of_goal,
        )  # fmt: skip

    def _arrive(self, source: int, arrival: Arrival, before: Store) -> None:
        """Take note of a step and of the state it leads to."""
        change, store, answer = arrival.change, before, b""
        if change is None:
            key = arrival.core
        else:
            store, answer = self._stores.after(before, change)
            key = arrival.core + answer
        number = self._numbers.get(key)
        if number is None:
            if self.states >= self.meter.limits.states:
                self.meter.is_full = True
                self.cut.add(max(source, 0))
                return
            number = self._find(key, source, arrival, store, answer)
        kind = arrival.kind
        if source < 0 or (source == number and not (kind == "time" and arrival.has_moved)):
            return  # what changes nothing leads nowhere
        kept = arrival.kept
        if kept is not None and self._goal_words and not arrival.is_of_goal:
            kept |= self._goal_words
        self.join(source, number, kind, kept)

    def _find(self, key: bytes, source: int, arrival: Arrival, store: Store, answer: bytes) -> int:
        """Take note of a state that is new; its number."""
        number = self._add(key, source, arrival.way)
        if arrival.ended is not None:
            self.ends[number] = arrival.ended[0]
        elif arrival.state is not None:
            self._frontier.append((number, arrival.core, Place(arrival.state, store)))
            if arrival.levels:
                self.levels[number] = {loop: Level(ended, core + answer) for loop, ended, core in arrival.levels}
            if arrival.mode == "canceling":
                self.canceling.add(number)
        return number

    # -- what is wrong --------------------------------------------------------------------------------------------

    def _stop(self, number: int, place: Place) -> None:
        """An e-stop here ends the mission and every goal; it asks for nothing that is known."""
        environment, chart = self.environment, self.environment.chart
        environment.load(place)
        environment.choices.begin()
        environment.make(environment.ordering("kill"))
        if chart.outcome != "aborted":
            self._flaw("stop", number, f"an e-stop leaves the mission {chart.outcome or chart.mode}", Edge(KILL))
        self._end(number, Edge(KILL))

    def _end(self, source: int, way: Edge) -> None:
        loose = [goal.action for goal in self.environment.rest.pursued]
        if loose:
            self._flaw("stopped", source, f"the mission ends while '{loose[0]}' continues", way)

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        """Take note of what the step that was just made shows."""
        environment, chart = self.environment, self.environment.chart
        draft, seen = chart.state.draft, environment.instruments.seen
        for move in draft.moves:
            self.taken.update(move.taken)
            self.entered.update(move.entered)
        for place, value in draft.looked:
            seen.setdefault(place, set()).add(value)
        if chart.outcome is None:
            if restless := environment.rest.restless:
                sentence = f"the tree in '{restless[0]}' goes round without end: it rests at the limit of a step"
                self._flaw("comes to rest", source, sentence, way)
            return
        self._end(source, way)
        if chart.cause == "invariant" and is_paused:
            self.in_pause.add(chart.false_invariant)
        elif chart.cause == "invariant":
            self._flaw("invariants", source, chart.why, way)
        elif chart.cause == "cycle":
            self._flaw("comes to rest", source, chart.why, way)
        if chart.outcome == "succeeded" and not environment.world.rests_on_facts:
            self._flaw("answers", source, "the mission succeeds, whatever the robot reports", way)

    def _flaw(self, promise: str, state: int, sentence: str, way: Edge) -> None:
        """The first of each promise is a shortest."""
        if promise not in self.flaws:
            self.meter.refuted(self.states)
        self.flaws.setdefault(promise, Violation(promise, state, sentence, way))

# SPDX-License-Identifier: Apache-2.0
"""All states that a mission can come into, breadth first, and what is wrong with any of them.

Rule: a step does the same wherever the mission's own keys that it looks at are the same, and is made once for these.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from rai_missions.prove.environment import RESUME, Environment
from rai_missions.prove.limits import MOST_STATES, Limits, Meter
from rai_missions.prove.loops import Level, Loop
from rai_missions.prove.state_graph import Edge, StateGraph
from rai_missions.prove.state_key import Own, Saved
from rai_missions.prove.step_cache import Arrival, CachedStep, Made, StepCache, value_of
from rai_missions.prove.stimulus import HappeningKind, Stimulus

__all__ = ("CANCEL", "KILL", "START", "Edge", "Space", "Violation")

NOW_AND_THEN = 1000
MOST_COURSES = 20_000
"""So many states are remembered with all that happened in them."""
Progress = Callable[[int, int], None]
START, CANCEL, KILL = "the mission starts", "the operator cancels", "the operator stops the mission at once"


class Violation(NamedTuple):
    """A state, or a step out of it, that breaks a promise."""

    promise: str
    state: int
    """Its number; -1 is before the start."""
    sentence: str
    way: Edge | None = None
    """What happens in that state; None where the state itself is at fault."""


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
        self.fresh = (environment.codec.save(), environment.codec.own())
        """Before the start."""
        self._frontier: deque[tuple[int, bytes, Saved, Own]] = deque()
        self._courses: dict[bytes, list[StepCache]] = {}
        self._here: list[Stimulus] = []
        """What waits for time in the state that is left."""
        self._waits_of: dict[bytes, int] = {}
        self.ends: dict[int, str] = {}
        """Number of a state → the outcome with which the run has ended in it."""
        self.canceling: set[int] = set()
        self.levels: dict[int, dict[Loop, Level]] = {}
        """Number of a state → how far the loops are there of which a few rounds may stand for all."""
        self.taken: set[str] = set()
        """JSON pointers of the rows that were taken."""
        self.entered: set[str] = set()
        self.flaws: dict[str, Violation] = {}
        """Promise → a shortest way to break it."""
        self.in_pause: set[str] = set()
        """Invariants that what a robot says can break while the mission is paused or held, when not every rule acts."""
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
        return [*self.cut, *(number for number, *_ in self._frontier)]

    def explore(self) -> None:
        """Find every state, or as many as the limits allow."""
        start = Stimulus(START, "start", self.environment.begin)
        self._each_way(start, -1, self.fresh, -1, None)
        while self._frontier and not self._is_over:
            number, core, state, own = self._frontier.popleft()
            self._leave(number, core, (state, own))
            self.done += 1
            if number % NOW_AND_THEN == 0:
                self._progress(self.states, number)

    @property
    def _is_over(self) -> bool:
        """All that was wanted is known, or a limit is reached that ends the search at once."""
        return bool(self.meter.ended or (self._wanted and self._wanted <= self.flaws.keys()))

    # -- one state ------------------------------------------------------------------------------------------------

    def _leave(self, number: int, core: bytes, place: tuple[Saved, Own]) -> None:
        """Everything that can happen in a state."""
        own, known = place[1], self._courses.get(core)
        if known is None:
            self._stop(number, place)
        fitting = [each.course(own) for each in known or ()]
        found = self._happenings(number, place) if known is None or None in fitting else []
        self._note_waiting(number, core, found)
        if known is None:
            known, fitting = self._room(core, len(found)), [None] * len(found)
        for at, course in enumerate(fitting):
            if self._is_over:
                self.cut.add(number)
                return
            if course is not None:
                self._again(course, number, own)
            else:
                place_of = at if found[at].words != CANCEL else -1
                self._each_way(found[at], place_of, place, number, known[at] if known else None)

    def _note_waiting(self, number: int, core: bytes, found: list[Stimulus]) -> None:
        """What waits for time there; the same for all states of a core."""
        if found:
            self._here = [each for each in found if each.kind == "time"]
            self._waits_of[core] = self.wait(number, frozenset(each.words for each in self._here))
        elif core in self._waits_of:
            self.waiting[number] = self._waits_of[core]

    def _happenings(self, number: int, place: tuple[Saved, Own]) -> list[Stimulus]:
        """Everything that can happen there but an emergency stop."""
        self.environment.load(*place)
        found = list(self.environment.happenings())
        if number not in self.canceling:
            found.append(Stimulus(CANCEL, "command", self.environment.ordering("cancel")))
        return found

    def _room(self, core: bytes, many: int) -> list[StepCache] | None:
        """Room for what comes of so many happenings here; none where the mission's own keys cannot differ."""
        environment = self.environment
        if not environment.codec.telling() or environment.world.own_fade:
            return None
        if len(self._courses) >= MOST_COURSES:
            self._courses.clear()
            self._waits_of.clear()
        room = self._courses[core] = [StepCache() for _ in range(many)]
        return room

    def _again(self, course: CachedStep, source: int, own: Own) -> None:
        """The same happens in a state that differs in the mission's own keys alone."""
        self.steps += course.steps
        self.meter.spend(course.steps, self.states)
        for arrival in course.arrivals:
            self._arrive(source, arrival, own)

    def _each_way(
        self, happening: Stimulus, at: int, place: tuple[Saved, Own], source: int, before: StepCache | None
    ) -> None:
        """Let it happen in each way in which it can; those that went so before are not gone again."""
        own, arrivals, steps, needs = place[1], [], 0, dict[str, Any]()
        chosen: tuple[int, ...] | None = ()
        while chosen is not None:
            made = before.known(chosen, own) if before is not None else None
            if made is None:
                made = self._make(happening, at, place, source, chosen)
                if before is not None:
                    before.remember_way(chosen, made)
            steps += 1
            needs.update(made.needs)
            if made.arrival is not None:
                self._arrive(source, made.arrival, own)
                arrivals.append(made.arrival)
            chosen = made.after
            if self.meter.spend(1, self.states) and chosen is not None and self._is_over:
                self.cut.add(max(source, 0))
                self.steps += steps
                return
        self.steps += steps
        if before is not None:
            before.remember(CachedStep(arrivals, steps, tuple(sorted(needs.items()))))

    def _make(
        self, happening: Stimulus, at: int, place: tuple[Saved, Own], source: int, chosen: tuple[int, ...]
    ) -> Made:
        """Let it happen in one way."""
        environment, arrival = self.environment, None
        chart, world = environment.chart, environment.world
        looked = world.board.looked
        environment.choices.begin(chosen)
        environment.load(*place)
        is_idle = (chart.mode == "paused" and happening.words != RESUME) or (
            environment.control.is_held and happening.kind == "write"
        )
        looked.clear()
        environment.make(happening.do)
        self.meter.work += len(chart.state.draft.moves) + environment.instruments.ticks
        is_possible = world.is_possible
        read = looked & world.own_keys
        if is_possible:
            is_silent = happening.kind == "time" and environment.time.is_silent
            kept = environment.time.kept(self._here, happening.words) if is_silent else None
            environment.settle()
            read |= (looked | world.asked_at_the_end) & world.own_keys
            way = Edge(happening.words, at, environment.choices.trail)
            self._learn(source, way, is_paused=is_idle)
            arrival = self._arrival(way, happening.kind, place[1], kept)
        needs = tuple([(key, value_of(place[1], key)) for key in sorted(read)]) if read else ()
        return Made(arrival, needs, environment.choices.next())

    def _arrival(self, way: Edge, kind: HappeningKind, before: Own, kept: frozenset[str] | None) -> Arrival:
        chart, codec = self.environment.chart, self.environment.codec
        has_moved = bool(chart.state.draft.moves or self.environment.instruments.turned)
        if chart.outcome is not None:
            return Arrival(way, kind, has_moved, (chart.outcome, chart.why))
        written = {key: entry for key, entry in codec.own().items() if before.get(key) is not entry}
        levels = codec.levels() if codec.loops else ()
        return Arrival(
            way, kind, has_moved, None, codec.core(), codec.take(), written, codec.telling(), chart.mode,
            levels, kept,
        )  # fmt: skip

    def _arrive(self, source: int, arrival: Arrival, before: Own) -> None:
        """Take note of a step and of the state it leads to."""
        ended = arrival.ended
        if ended is not None:
            own, key = before, repr(ended).encode()
        else:
            own = {**before, **arrival.written} if arrival.written else before
            key = self.environment.codec.key(arrival.core, own, arrival.telling)
        number = self._numbers.get(key)
        if number is None:
            if self.states >= self.meter.limits.states:
                self.meter.is_full = True
                self.cut.add(max(source, 0))
                return
            number = self._add(key, source, arrival.way)
            if ended is not None:
                self.ends[number] = ended[0]
            elif arrival.state is not None:
                self._frontier.append((number, arrival.core, arrival.state, own))
                if arrival.levels:
                    self.levels[number] = {loop: Level(ended, self.environment.codec.key(core, own, arrival.telling))
                                           for loop, ended, core in arrival.levels}  # fmt: skip
                if arrival.mode == "canceling":
                    self.canceling.add(number)
        is_circle = source == number and not (arrival.kind == "time" and arrival.has_moved)
        if source >= 0 and not is_circle:  # what changes nothing leads nowhere
            self._join(source, number, arrival.kind, arrival.kept)

    # -- what is wrong --------------------------------------------------------------------------------------------

    def _stop(self, number: int, place: tuple[Saved, Own]) -> None:
        """An emergency stop here ends the mission and every goal; it asks for nothing that is known."""
        environment, chart = self.environment, self.environment.chart
        environment.load(*place)
        environment.choices.begin()
        environment.make(environment.ordering("kill"))
        if chart.outcome != "aborted":
            self._flaw(
                "stop", number, f"an emergency stop leaves the mission {chart.outcome or chart.mode}", Edge(KILL)
            )
        self._end(number, Edge(KILL))

    def _end(self, source: int, way: Edge) -> None:
        loose = [goal.action for goal in self.environment.rest.pursued]
        if loose:
            self._flaw("stopped", source, f"the mission ends while '{loose[0]}' goes on", way)

    def _learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
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
            self._flaw("answers", source, "the mission succeeds, whatever the robot says", way)

    def _flaw(self, promise: str, state: int, sentence: str, way: Edge) -> None:
        """The first of each promise is a shortest."""
        if promise not in self.flaws:
            self.meter.refuted(self.states)
        self.flaws.setdefault(promise, Violation(promise, state, sentence, way))

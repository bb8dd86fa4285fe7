# SPDX-License-Identifier: Apache-2.0
"""One step really made: the run is put into a state, one thing happens there in one way, and it comes to rest.

Rule: with the arrival comes everything that it rests on: what was asked of the store, and which parts of the state
could be looked at (`StepFootprint`). What is not known of a step is taken to rest on the whole state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from rai_missions.engine.activities.activity import GOALS
from rai_missions.engine.step import Move
from rai_missions.guards.view import presence
from rai_missions.prove.abstraction.state_key import Place
from rai_missions.prove.abstraction.store import ALL_GOALS, Store, StoreChange
from rai_missions.prove.analysis.counts import Count
from rai_missions.prove.environment.environment import RESUME, Environment
from rai_missions.prove.exploration.region_parts import Part, PartedState, RegionParts
from rai_missions.prove.exploration.regions import OUTSIDE, TIME, RegionGroups
from rai_missions.prove.exploration.step_cache import NOTHING, Arrival, ReadsChange, StepFootprint, StepOutcome
from rai_missions.prove.state_graph import LENGTHENED, LISTED, Edge
from rai_missions.prove.stimulus import Stimulus

__all__ = ("StepCase", "StepMaker", "StepOrigin")

Learn = Callable[[int, Edge, bool], None]
"""Takes note of what a step shows: the state it was made in, what happened, and whether the rules were at rest."""


class StepCase(NamedTuple):
    """One thing that can happen in a state."""

    happening: Stimulus
    at: int
    """Its place among those of the same words; -1 for what an operator or the start does."""
    scope: int = OUTSIDE
    """The group that it concerns; see `Regions.scope`."""


class StepOrigin(NamedTuple):
    """The state in which steps are made."""

    number: int
    place: Place
    waiting: Sequence[StepCase] = ()
    """What waits for time, but for goals that nothing pursues."""
    goals: Sequence[StepCase] = ()
    """What waits for time on account of these."""
    parted: PartedState | None = None
    """Where the state is taken apart, the numbers of its parts."""
    parts: Sequence[Part] = ()

    def is_last(self, scope: int) -> bool:
        """All groups but this one have come to their ends."""
        return all(part.is_ended for group, part in enumerate(self.parts) if group != scope)


class StepMaker:
    """Makes steps.

    Args:
        environment: The mission, and all that can happen to it.
        parts: Takes states apart; None where that is not done.
        learn: Receives what steps show.
    """

    def __init__(self, environment: Environment, parts: RegionParts | None, learn: Learn) -> None:
        self._environment, self._parts, self._learn = environment, parts, learn
        self._stores = environment.codec.stores
        self._each = {node.name for node in environment.chart.program.graph.order if node.is_each}
        self._numbers = self._orders = 0
        """The last number of a start or a question, and of a timer: the parts of two steps never have the same ones."""

    def make(self, here: StepOrigin, case: StepCase, chosen: tuple[int, ...]) -> tuple[StepOutcome, int]:
        """Let something happen in one way; what came of it, and how many microsteps and ticks of trees it took."""
        environment, arrival, happening = self._environment, None, case.happening
        chart, world, instruments = environment.chart, environment.world, environment.instruments
        looked, replaced = world.board.looked, world.board.replaced
        environment.choices.begin(chosen)
        environment.load(here.place)
        if self._parts is not None:
            state = chart.state
            state.number, state.order = max(state.number, self._numbers), max(state.order, self._orders)
        is_idle = (chart.mode == "paused" and happening.words != RESUME) or (
            environment.control.is_held and happening.kind == "write"
        )
        for each in (looked, replaced, world.board.counted):
            each.clear()
        environment.make(happening.do)
        draft = chart.state.draft
        work, footprint = len(draft.moves) + instruments.ticks, NOTHING
        is_possible = world.is_possible
        read, written = looked & world.stored, {key for key, _ in draft.written}
        if is_possible:
            kept = self._left_waiting(here, happening)
            environment.settle()
            read |= (looked | world.asked_at_the_end) & world.stored
            way = Edge(happening.words, case.at, environment.choices.trail)
            self._learn(here.number, way, is_idle)
            arrival, footprint = self._arrival(way, here, case, kept)
        asked = instruments.asked.union(self._stores.looked_at(read - replaced, written, self._counted()))
        self._numbers, self._orders = max(self._numbers, chart.state.number), max(self._orders, chart.state.order)
        return StepOutcome(arrival, frozenset(asked), environment.choices.next(), footprint), work

    def _counted(self) -> set[tuple[str, int]]:
        """Numbers that were counted, and what had been added to each when it was looked at; none in a long step."""
        world = self._environment.world
        if self._environment.instruments.is_long or not world.board.counters:
            return set()
        entries = {key: world.board.known(key) for key in world.asked_at_the_end & world.board.counters}
        added = {
            (key, each[0].added if each is not None and each[0].__class__ is Count else 0)
            for key, each in entries.items()
        }
        return world.board.counted | added

    def _left_waiting(self, here: StepOrigin, taken: Stimulus) -> list[StepCase] | None:
        """What waits for time on after a step; a step that is about no goal leaves those of the store as they are.

        None where more than time makes the step, or the robot is not silent.
        """
        time = self._environment.time
        if taken.kind != "time" or not time.is_silent:
            return None
        waiting = [*here.waiting, *here.goals] if taken.is_of_goal else [*here.waiting]
        kept = time.kept([each.happening for each in waiting], taken.words)
        return [each for each in waiting if each.happening.words in kept]

    def _arrival(
        self, way: Edge, here: StepOrigin, case: StepCase, waits: list[StepCase] | None
    ) -> tuple[Arrival, StepFootprint]:
        environment, happening = self._environment, case.happening
        chart, codec, instruments = environment.chart, environment.codec, environment.instruments
        moves = list(chart.state.draft.moves)
        has_moved = bool(moves or instruments.turned or instruments.has_started or any(instruments.begun.values()))
        wakes = self._wakes(happening, moves) if here.parted is not None else 0
        if chart.outcome is not None:
            ended = chart.outcome, chart.why
            footprint, _ = self._footprint(here, case, wakes, moves, None, has_ended=True)
            return Arrival(way, happening.kind, has_moved, ended, repr(ended).encode()), footprint
        change = self._change(here.place.store, happening)
        levels = codec.levels() if codec.loops else ()
        mode, is_whole = chart.mode, self._parts is None or not self._parts.takes(chart.state)
        run_key = codec.run_key() if is_whole else b""
        saved = codec.take()
        parted = self._parts.parted(saved) if not is_whole and self._parts is not None else None
        footprint, changed = self._footprint(here, case, wakes, moves, parted, has_ended=False)
        kept = self._kept(waits, footprint, moves) if waits is not None else None
        return Arrival(
            way,
            happening.kind,
            has_moved,
            None,
            run_key,
            None if parted is not None else saved,
            change,
            mode,
            levels,
            kept,
            happening.is_of_goal,
            parted,
            changed,
            footprint.needs,
        ), footprint

    def _change(self, before: Store, happening: Stimulus) -> StoreChange:
        """What a step has made of the store that it began with."""
        codec, asked = self._environment.codec, self._environment.instruments.asked
        written, added = codec.changed(before, is_exact=self._environment.instruments.is_long)
        goals, many = codec.given_up(), len(before.goals)
        if happening.is_of_goal or goals[:many] != list(before.ledger.values()):
            asked.add(ALL_GOALS)
        is_absolute, ahead, rivals = ALL_GOALS in asked, codec.ahead(), self._environment.rest.rivals
        left = tuple(goals if is_absolute else goals[many:])
        return self._stores.change(written, added, left, rivals, ahead.kept, ahead.question, is_absolute=is_absolute)

    def _kept(self, waits: Iterable[StepCase], footprint: StepFootprint, moves: Iterable[Move]) -> frozenset[str]:
        """The words of what waits on and of lists; what waits in a part at which the step did not look is left out."""
        rests = (each for each in waits if footprint is NOTHING or each.scope < 0 or each.scope in footprint.needs)
        return self._lists(moves).union(each.happening.words for each in rests)

    def _lists(self, moves: Iterable[Move]) -> frozenset[str]:
        """Which lists turned out to be longer in a step, and which it began with: see `circling`."""
        begun = {name for move in moves for name in move.entered if name in self._each}
        longer = self._environment.instruments.lengthened
        return frozenset((*(LENGTHENED + name for name in longer), *(LISTED + name for name in begun)))

    # -- what a step rests on -------------------------------------------------------------------------------------

    def _wakes(self, happening: Stimulus, moves: Iterable[Move]) -> int:
        """What a step could wake something by, as bits."""
        assert self._parts is not None
        tokens = {key for key, _ in self._environment.chart.state.draft.written} | {happening.key} - {""}
        tokens |= {presence(name) for move in moves for name in (*move.exited, *move.entered)}
        if happening.kind == "time" or happening.stale:
            tokens.add(TIME)
        if self._environment.has_actions:
            tokens.add(GOALS)
        return self._parts.regions.mask(tokens)

    def _footprint(
        self,
        here: StepOrigin,
        case: StepCase,
        wakes: int,
        moves: Sequence[Move],
        parted: PartedState | None,
        *,
        has_ended: bool,
    ) -> tuple[StepFootprint, tuple[tuple[int, int], ...] | None]:
        """Where a step goes the same way, and which parts it changes; None where it leaves the parallel state.

        Why this suffices. A step begins with what happens, and continues with what that wakes. What happens is looked
        at by the groups that it concerns, and by rules around them (`Regions.concerned`); their guards look at the
        frame, at the store, which notes it, and at states and reported keys of their own group alone, since a name in
        two groups makes them one. What rests is woken by keys, states, goals and time alone (`Part.wakes`): a guard
        that waits was not true, and is asked again to no effect where nothing that it depends on has changed. A group
        that is not woken stays as it is, and does nothing. Three things look at all groups: the end of the parallel
        state, for which it counts whether the others have ended, and what leaving it does, which is nothing for a
        part that is quiet; and what may be read later (`ReadsChange`). Wherever a step does more than this allows, it
        rests on every part.
        """
        if here.parted is None or self._parts is None:
            return NOTHING, None
        regions, frames = self._parts.regions, self._parts.frames
        parallel = frames[here.parted.frame].parallel
        needs = set(regions.concerned(parallel, case.happening, case.scope))
        needs |= {group for group, part in enumerate(here.parts) if part.wakes & wakes}
        leaves = has_ended or any(parallel.node.name in move.exited for move in moves)
        if here.is_last(case.scope) and case.scope >= 0:
            needs |= parallel.every
        if leaves:
            needs |= {group for group, part in enumerate(here.parts) if not part.is_quiet}
            if self._may_complete(parallel, here, case, needs, moves):
                needs |= parallel.every
            return StepFootprint(tuple(sorted(needs)), wakes, leaves=True), None
        if parted is None or frames[parted.frame].parallel is not parallel:
            return StepFootprint(tuple(sorted(parallel.every)), wakes), None
        pairs = enumerate(zip(here.parted.parts, parted.parts, strict=True))
        changed = tuple((group, now) for group, (before, now) in pairs if before != now)
        after = self._parts.of(parted)
        is_foreseen = all(
            group == case.scope or (group in needs and not (here.parts[group].is_ended or after[group].is_ended))
            for group, _ in changed
        )
        if not is_foreseen:
            needs |= parallel.every
        turns: tuple[ReadsChange, ...] = ()
        if any(here.parts[group].reads != after[group].reads for group, _ in changed):
            reads = frozenset[str]().union(*(part.reads for part in after))
            turns = (ReadsChange(tuple((group, after[group]) for group, _ in changed), reads),)
        return StepFootprint(tuple(sorted(needs)), wakes, turns=turns), changed

    def _may_complete(
        self, parallel: RegionGroups, here: StepOrigin, case: StepCase, needs: Iterable[int], moves: Iterable[Move]
    ) -> bool:
        """Whether others than the group concerned may have come to their ends before the parallel state was left."""
        others = [move for move in moves if parallel.node.name not in move.exited]
        entered = {parallel.group_of.get(name, case.scope) for move in others for name in move.entered}
        return bool(entered - {case.scope}) or any(here.parts[group].is_ended for group in needs if group != case.scope)

# SPDX-License-Identifier: Apache-2.0
"""Time, as far as a proof knows it: whatever waits for it gets it, in any order.

Rule: what a run finds together at one instant comes together here. What is known may go stale, spans may end, and
activities and finals may have waited for long enough, at the instant at which something else runs out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.tree import RunningLeaf, TreeActivity, TreeMachine, limit_of
from rai_missions.engine.semantics.hold import is_held, live
from rai_missions.engine.semantics.timing import pass_instant
from rai_missions.engine.state import RunState
from rai_missions.prove.abstraction.abstraction import PURSUED, Abstraction
from rai_missions.prove.abstraction.activity_key import timer_key
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.nondeterminism import MISSING, AnyOf
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.abstraction.state_key import StateCodec
from rai_missions.prove.analysis.branches import firsts, parted, passed
from rai_missions.prove.environment.input_env import InputEnvironment, owned
from rai_missions.prove.stimulus import Stimulus

__all__ = ("TimeEnvironment",)

LONG_AGO = 0.0


class Span(NamedTuple):
    """A time that a guard counts, and that is not over."""

    kind: Literal["age", "held"]
    """Whether a state counts it, or a guard that has been true without a break."""
    name: str
    """The state, or where the guard's time is remembered."""


class DueTurn(NamedTuple):
    """The turn of an activity, or of a final that settles, once what it waits for is over."""

    words: str
    owner: str
    """The state."""
    change: Callable[[], None]
    """Time passes until it is over."""
    group: frozenset[str] | None = None
    """Of a tree, the group of which a wait is over; empty for its only one, None for what is no wait of a tree."""
    is_first: bool = True
    """It can be over before all else; if not, at the instant of another group of its tree alone."""


class TimeEnvironment:
    """Time that passes for whatever waits for it.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        codec: How old states are, and the groups of what waits in trees.
        inputs: What runs.
        rest: Which goals make a difference.
        instruments: What trees did in the step.
    """

    def __init__(
        self,
        chart: Chart,
        world: OpenWorld,
        codec: StateCodec,
        inputs: InputEnvironment,
        rest: Abstraction,
        instruments: Instruments,
    ) -> None:
        self._chart, self._world, self._codec, self._inputs = chart, world, codec, inputs
        self._rest, self._instruments = rest, instruments
        self._over: list[DueTurn] = []
        """What activities and finals have waited for, and is over in this step."""
        self._spans = self._durations()

    @property
    def _state(self) -> RunState:
        """The state that is loaded, or that the step leads to."""
        return self._chart.state

    def _durations(self) -> dict[tuple[str, Any], tuple[str, float]]:
        """The timers that are set when a state is entered → the state, and after how many seconds they run out."""
        found: dict[tuple[str, Any], tuple[str, float]] = {}
        for node in self._chart.program.graph.order:
            for transition in node.transitions:
                if transition.definition.after_s is not None:
                    found["after", transition.place] = (node.name, transition.definition.after_s)
            if node.state is not None and node.state.timeout_s is not None:
                found["timeout", node.name] = (node.name, node.state.timeout_s)
        return found

    def _comes_later(self, key: tuple[str, Any]) -> bool:
        """Whether another timer that was set at the same entry of the same state runs out before it."""
        if key not in self._spans:
            return False
        owner, span = self._spans[key]
        spans = (self._spans[each] for each in self._state.timers if each in self._spans)
        return any(name == owner and other < span for name, other in spans)

    @property
    def is_silent(self) -> bool:
        """Nothing need be known that the robot must report again and again: it may have been silent for long."""
        board = self._world.board
        return all(
            board.known(key) in (None, MISSING) or None in board.among.get(key, ()) for key in self._world.passing
        )

    def kept(self, waiting: Iterable[Stimulus], taken: str) -> frozenset[str]:
        """Which of the things that waited for time wait on after a step, and not from the beginning."""
        begun = {
            name for move in self._state.draft.moves for name in (*move.exited, *move.entered)
        } | self._instruments.turned
        over = {taken, *(each.words for each in self._over)}
        return frozenset(each.words for each in waiting if each.words not in over and self._waits_on(each, begun))

    def _waits_on(self, each: Stimulus, begun: Collection[str]) -> bool:
        if each.timer is None:
            return each.owner not in begun
        key, order = each.timer
        if key[0] == "goal":
            goal = self._state.goals.get(order)
            return goal is not None and goal.phase not in (*PURSUED, "orphaned")
        return key in self._state.timers and self._state.timers[key].order == order

    def time_passes(self, *woken: str) -> None:
        """What has run out takes effect; the machines of these states are informed that time has passed."""
        self._chart.state.draft.due = frozenset(woken)
        pass_instant(self._chart.program, self._state)

    def elapse(
        self,
        change: Callable[[], None],
        *woken: str,
        beyond: str = "",
        after: Span | None = None,
        waits: Iterable[DueTurn] = (),
    ) -> Callable[[], None]:
        """Time passes until something has run out; at the same instant spans may end, and what is known go stale.

        Why each of these orders is enough. A run handles an instant as a whole: timers find the ages, held guards and
        stale keys of that instant, and rules that wait for several of these find them together. Activities have their
        turn after all timers, one after the other before any of their outcomes is answered; one that a timer wakes by
        what it does finds that its own time is over, too. What comes at once is tried in one order: timers and the
        like with all others, activities and finals with the later ones, with spans and with keys, a span with the
        later ones and with keys, a key with the later ones. Two timers are taken one after the other in a run as well.

        Args:
            change: What has run out.
            woken: The states whose machines learn that time has passed.
            beyond: Only keys that come after this: that one before it goes stale too happens when that one does.
            after: The span that has ended: only those that come after it; none where a key has gone stale.
            waits: What activities and finals wait for, and may be over too.
        """

        def happen() -> None:
            board = self._world.board
            before = self._waver(beyond)
            for span in self._spans_after(after) if not beyond else ():
                if self._world.choices.choose(2):
                    self._end_span(span)
            change()
            for each in waits:
                if (each.is_first or self._is_over(each)) and self._world.choices.choose(2):
                    self._be_over(each)
            self.time_passes(*woken, *(each.owner for each in self._over))
            gone = [key for key in before if board.known(key) is None]
            for key in before.keys() & board.among.keys():
                board.leave(key, [each for each in board.among[key] if each is not None or None in before[key]])
            if gone and self._state.mode != "ended":
                self._state.draft.news.update(dict.fromkeys(gone, ""))
                self.time_passes(*self._readers(gone))

        return happen

    def _running_spans(self) -> list[Span]:
        """What the guards of states that are not held count, and has not come to its end."""
        state, graph = self._state, self._chart.program.graph
        ages = [name for name in self._codec.aging if not (name and is_held(state, graph.nodes[name]))]
        helds = [memory for memory, since in sorted(state.true_since.items()) if since == NOW]
        return [
            *(Span("age", name) for name in ages),
            *(Span("held", memory) for memory in helds if graph.held_owners[memory].control not in state.frozen),
        ]

    def _spans_after(self, span: Span | None) -> list[Span]:
        spans = self._running_spans()
        return spans[spans.index(span) + 1 :] if span is not None else spans

    def _end_span(self, span: Span) -> None:
        if span.kind == "held":
            self._state.true_since[span.name] = LONG_AGO
        elif (age := self._codec.next_age(span.name)) is not None:
            self._codec.grow_old(span.name, age)

    def _waver(self, beyond: str) -> dict[str, Sequence[Any]]:
        """Have every key that can go stale do so at this instant or not, when someone looks."""
        before, board = dict[str, Sequence[Any]](), self._world.board
        for key, entry in list(board.entries()):
            if entry is not None and key > beyond and key in self._world.fading:
                before[key] = entry.value if isinstance(entry.value, AnyOf) else (entry.value,)
                board.leave(key, before[key] if None in before[key] else (*before[key], None))
        return before

    def _readers(self, keys: Iterable[str]) -> list[str]:
        """The states whose machines want to be notified of these."""
        wanted = {*keys, "*"}
        return [
            name
            for name, machine, state in live(self._chart.program, self._state)
            if not machine.reads(state).isdisjoint(wanted)
        ]

    def times(self) -> Iterator[Stimulus]:
        """Each thing that waits for time gets it, in any order; spans alone come before what may end with them."""
        yield from self._ages()
        waits = [*self._waits()]
        for key, timer in sorted(self._state.timers.items(), key=lambda each: timer_key(*each)):
            if self._comes_later(key) or timer.control in self._state.frozen:
                continue
            kind, which = key
            kinds = {"after": f"the time of transition {which} has come", "timeout": f"the time of '{which}' is over"}
            words = kinds.get(kind, f"'{timer.name}' is due")
            raised = timer.name if kind == "raise" else ""
            others = [each for each in waits if (kind, each.owner) != ("timeout", which)]
            do = self.elapse(self._ring(key), waits=others)
            yield Stimulus(words, "time", do, timer=(key, timer.order), event=raised)
        for name, until in sorted(self._state.awaiting_control.items()):
            if until != math.inf:
                do = self.elapse(self._dated("awaiting_control", name), waits=waits)
                yield Stimulus(f"no handover for '{name}' in time", "time", do, owner=name)
        if self._state.final is not None and not self._state.settling:
            yield Stimulus("time passes at the end", "time", self.elapse(lambda: None))
        if self._state.cancel_by != math.inf:
            yield Stimulus("the cancel takes too long", "time", self.elapse(self._too_long))

    def _settling_now(self) -> list[str]:
        """The finals that settle, but for those of held states."""
        nodes = self._chart.program.graph.nodes
        return [
            name
            for name in sorted(self._state.settling)
            if self._state.final is not None or not is_held(self._state, nodes[name])
        ]

    def orphans(self) -> Iterator[Stimulus]:
        """Goals that nothing pursues are never confirmed to have ended."""
        for goal in self._rest.remaining:
            if goal.phase != "orphaned":
                words = f"'{goal.action}' never confirms its end"
                orphan = self.elapse(self._orphan(goal.number), waits=[*self._waits()])
                yield Stimulus(words, "time", orphan, timer=(("goal", ""), goal.number), is_of_goal=True)

    def _ages(self) -> Iterator[Stimulus]:
        for span in self._running_spans():
            name = span.name
            if span.kind == "age":
                words = f"'{name or 'the mission'}' has lasted {self._codec.next_age(name):g} s"
                aged = self.elapse(partial(self._end_span, span), *self._state.running, after=span)
                yield Stimulus(words, "time", aged, owner=name, is_tick=True)
            else:
                words = f"the guard of {name.partition('#')[0]} has held for long enough"
                held = self.elapse(partial(self._end_span, span), after=span)
                yield Stimulus(words, "time", held, owner=self._chart.program.graph.held_owners[name].name)

    def turn_times(self) -> Iterator[Stimulus]:
        """Each thing that an activity or a final waits for is over, alone or with later ones."""
        waits = [*self._waits()]
        for at, each in enumerate(waits):
            if each.is_first:
                do = self.elapse(partial(self._be_over, each), waits=waits[at + 1 :])
                yield Stimulus(each.words, "time", do, owner=each.owner)

    def _be_over(self, wait: DueTurn) -> None:
        wait.change()
        self._over.append(wait)

    def _is_over(self, wait: DueTurn) -> bool:
        """Whether another group of the same tree is over in this step."""
        return any(each.owner == wait.owner and each.group for each in self._over)

    def _waits(self) -> Iterator[DueTurn]:
        """All that activities and finals wait for, in one order."""
        for name, path, state in list(self._inputs.inner()):
            owner, tree = owned(name, path), self._state.running[name]
            if path is not None and tree.leaves[path].deadline != math.inf:
                yield DueTurn(f"the time of '{owner}' is over", name, self._leaf_over(name, path))
            wake = self._machine_of(name, path).wake_at(state, self._state)
            words = f"time passes for '{owner}'"
            if isinstance(state, DecisionActivity) and state.deadline != math.inf:
                wake, words = state.deadline, f"the deadline of '{owner}' has come"
            if NOW < wake < math.inf:
                yield DueTurn(words, name, self._let_pass(name, path, wake))
        for name, state in self._inputs.running(held=True):
            if limit_of(state) == "rounds":
                yield DueTurn(f"the rounds of '{name}' continue", name, lambda: None)
            if isinstance(state, TreeActivity) and NOW < state.wake < math.inf:
                yield from self._tree_waits(name, state)
        for name in self._settling_now():
            yield DueTurn(f"'{name}' has not settled", name, self._dated("settling", name))

    def _tree_waits(self, name: str, state: TreeActivity) -> Iterator[DueTurn]:
        """What the tree waits for by itself; of branches that began at several instants, that of any."""
        groups = self._codec.groups.get(name, ())
        if not groups or all(memory.get("until") != state.wake for memory in state.tree.nodes.values()):
            yield DueTurn(f"time passes for '{name}'", name, self._grow(name), frozenset())
        for group, is_first in firsts(state, groups):
            words = f"time passes for '{name}' ({min(group)})"
            yield DueTurn(words, name, self._pass_for(name, group), group, is_first)

    def _pass_for(self, name: str, group: frozenset[str]) -> Callable[[], None]:
        def change() -> None:
            self._state.running[name] = passed(self._state.running[name], group, NOW)

        return change

    def begin_step(self) -> None:
        """Nothing is over yet."""
        self._over = []

    def part_groups(self) -> None:
        """Bring the groups of what waits in trees up to date, once a step has come to rest."""
        codec, begun, running = self._codec, self._instruments.begun, self._state.running
        for name, activity in running.items():
            if isinstance(activity, TreeActivity):
                over = [each.group for each in self._over if each.owner == name and each.group is not None]
                codec.groups[name] = parted(activity, codec.groups.get(name, ()), begun.get(name, ()), over)
        if codec.groups:
            codec.groups = {name: each for name, each in codec.groups.items() if each and name in running}

    def _machine_of(self, name: str, path: str | None) -> Any:
        machine: Any = self._chart.program.machines[name]
        return machine if path is None else machine.leaf_machines[path].machine

    def _ring(self, key: Any) -> Callable[[], None]:
        def change() -> None:
            self._state.timers[key] = self._state.timers[key]._replace(due=NOW)

        return change

    def _dated(self, field: str, name: str) -> Callable[[], None]:
        """A change: time passes until the instant of what waits there."""
        return lambda: getattr(self._state, field).update({name: NOW})

    def _too_long(self) -> None:
        self._chart.state.cancel_by = NOW

    def _orphan(self, number: int) -> Callable[[], None]:
        def change() -> None:
            goals = self._state.goals
            goals[number] = goals[number]._replace(until=NOW)

        return change

    def _leaf_over(self, name: str, path: str) -> Callable[[], None]:
        def change() -> None:
            tree = self._state.running[name]
            leaves = {**tree.leaves, path: RunningLeaf(tree.leaves[path].state, NOW)}
            self._state.running[name] = tree._replace(leaves=leaves)

        return change

    def _let_pass(self, name: str, path: str | None, wake: float) -> Callable[[], None]:
        """A change: time passes until the instant of one machine, for that machine alone."""

        def change() -> None:
            machine, state = self._machine_of(name, path), self._state.running[name]
            if path is None:
                self._state.running[name] = machine.shift(state, NOW - wake)
                return
            leaf = state.leaves[path]
            leaves = {**state.leaves, path: RunningLeaf(machine.shift(leaf.state, NOW - wake), leaf.deadline)}
            self._state.running[name] = state._replace(leaves=leaves)

        return change

    def _grow(self, name: str) -> Callable[[], None]:
        """A change: time passes until a tree's own next instant; that of its leaves is another affair."""

        def change() -> None:
            state, machine = self._state.running[name], self._chart.program.machines[name]
            assert isinstance(machine, TreeMachine)
            tree = machine.ticker.shift(state.tree, NOW - state.wake)
            self._state.running[name] = state._replace(tree=tree, wake=NOW)

        return change

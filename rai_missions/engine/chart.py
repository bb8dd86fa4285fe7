# SPDX-License-Identifier: Apache-2.0
"""The pure semantics: what a mission makes of an event, as a Step.

Rule: everything that decides is a function over a `Program` and a `RunState`; `Chart` holds the two. The same mission,
events and times give the same Steps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from typing import Any

from rai_missions.engine import snapshot
from rai_missions.engine.activities.goal_ledger import OpenGoal, awaited, loose
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import questions_in
from rai_missions.engine.configuration import CompiledStep, Configuration, DirectStep
from rai_missions.engine.decision import Question, with_verdicts
from rai_missions.engine.events import NOT_STARTED
from rai_missions.engine.handover import settle_holds
from rai_missions.engine.hold import held_by, holder_of, live
from rai_missions.engine.macrostep import complete, enabled
from rai_missions.engine.modes import Mode, mode_of
from rai_missions.engine.program import Named
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.snapshot import Snapshot
from rai_missions.engine.state import StepDraft, copied
from rai_missions.engine.step import Cause, Effect, Move, Step
from rai_missions.engine.stepping import begin_run, close, compiled, fresh, make_step
from rai_missions.engine.surroundings import Surroundings
from rai_missions.engine.timing import look_ahead
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.guards.guard import Truth, View
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.model import suggestion
from rai_missions.states.final import FinalOutcome
from rai_missions.states.state import Holder

__all__ = ("NOT_STARTED", "Chart", "Named", "Snapshot")

_new = tuple.__new__


class Chart:
    """One run of a mission, as far as rules decide it.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees: `rai_missions.trees.PyTrees()` for py_trees itself, which comes to the same.
        terms: What is known of the robot: which actions exclude each other, when a composed one has succeeded.
        named: The predicates that `{"named": …}` guards name.
        surroundings: What a proof leaves open, and where it watches.

    Raises:
        UsageError: The mission names a predicate that was not given.
    """

    def __init__(
        self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None,
        named: Named | None = None, surroundings: Surroundings | None = None,
    ) -> None:  # fmt: skip
        self.program = compiled(mission, ticker, facts=terms, named=named, surroundings=surroundings)
        self.state = fresh(self.program)

    @classmethod
    def restore(
        cls, mission: Mission, saved: Snapshot, ticker: Trees | None = None, *, terms: RobotFacts | None = None,
        named: Named | None = None,
    ) -> Chart:  # fmt: skip
        """A chart that continues where a snapshot was taken."""
        chart = cls(mission, ticker, terms=terms, named=named)
        snapshot.put_back(chart.program, chart.state, saved)
        return chart

    def snapshot(self) -> Snapshot:
        """All that the run remembers, as values that later steps do not change."""
        return snapshot.snapshot(self.program, self.state)

    def branch(self) -> Chart:
        """Another chart where this one is: what happens to either from now on changes nothing in the other."""
        return ChartBranch(self)

    # -- steps ----------------------------------------------------------------------------------------------------

    def start(self, at: float = 0.0) -> Step:
        """Enter the mission.

        Raises:
            UsageError: It was started before.
        """
        if self.mode != "ready":
            raise UsageError(f"the mission was started before; it is {self.mode}")
        begin_run(self.program, self.state, at)
        return close(self.program, self.state, Event("start", at, kind="command"))

    def write(self, key: str, value: Any, at: float | None = None, *, stamp: float | None = None) -> Step:
        """Write what a key is to the blackboard.

        Args:
            key: Its name.
            value: Its value.
            at: When that is received: now, if nothing else is given.
            stamp: When it was so, also before the run began; `at`, if nothing else is given.

        Raises:
            UsageError: The mission has no such key.
        """
        if key not in self.program.keys:
            raise UsageError(f"the mission has no key '{key}'{suggestion(key, self.program.keys)}")
        data = {"value": value} if stamp is None else {"value": value, "stamp": stamp}
        return self.send(Event(key, self.at if at is None else at, data, "write"))

    def propose(
        self, number: int, option: str, parameters: Mapping[str, Any] | None = None, *, by: str = "", why: str = "",
        at: float | None = None,
    ) -> Step:  # fmt: skip
        """Answer a question; the step's `verdict` has what became of it.

        Args:
            number: The question's.
            option: The name of the option that is proposed.
            parameters: What the option asks for.
            by: Who answers; whom the question was put to, if nothing else is given.
            why: The reason, for people.
            at: When the answer arrives, in seconds on the run's clock; now, if nothing else is given.
        """
        asked = next((question.asked for question in self.questions if question.number == number), "")
        data = {"option": option, "parameters": dict(parameters or {})} | ({"why": why} if why else {})
        return self.send(Event(by or asked, self.at if at is None else at, data, "proposal", number))

    def send(self, event: Event) -> Step:
        """Let an event happen: everything due before it first, then it, to completion.

        One whose time has passed already happens now. An event that does nothing but fire transitions without timers,
        activities and ends takes the short way.

        Raises:
            UsageError: Its time is not a finite number of seconds.
        """
        state = self.state
        name, at, data, kind, _ = event
        if kind != "event" or not state.quick or at >= state.wake:
            return make_step(self.program, state, event)
        if at > state.at:
            state.at = at
        config = state.config
        direct = config.direct.get(name)
        if direct is not None:
            return self._direct(event, direct)
        plan = config.plans.get(name)
        if plan is None:
            plan = config.plan(name, declared=name in self.program.declared)
        if not plan:
            is_declared = name in self.program.declared
            return self._short(event, (), ()) if is_declared else make_step(self.program, state, event)
        state.event = data
        looked: list[tuple[str, Truth]] = []
        transitions = enabled(state, plan, looked)
        if not transitions:
            return self._short(event, (), tuple(looked))
        leap = config.leaps.get((tuple(transitions), name))
        if leap is None or not leap.plain or not state.listening.isdisjoint(leap.shifts):
            return make_step(self.program, state, event)
        first = plan[0][0]
        if all(chain[0].test is None for chain in plan):
            config.direct[name] = (None, "", leap)
        elif len(plan) == len(plan[0]) == 1:
            config.direct[name] = (first.test, first.place, leap)
        return self._leapt(event, leap, tuple(looked))

    def _direct(self, event: Event, direct: DirectStep) -> Step:
        """A step on the short way where it is known what fires, if anything does."""
        state = self.state
        test, place, leap = direct
        state.event = event.data
        looked: tuple[tuple[str, Truth], ...] = ()
        if test is not None:
            value = test(state)
            looked = ((place, value),)
            if value is not True:
                return self._short(event, (), looked)
        if state.listening and not state.listening.isdisjoint(leap.shifts):
            return make_step(self.program, state, event)
        return self._leapt(event, leap, looked)

    def _leapt(self, event: Event, leap: CompiledStep, looked: tuple[tuple[str, Truth], ...]) -> Step:
        """The end of a step on the short way that makes a move."""
        state = self.state
        state.config = config = leap.config
        state.active = config.active
        if not leap.acts:
            return self._short(event, leap.moves, looked)
        program, draft = self.program, state.draft
        for act in leap.acts:
            act(program, state)
        written = draft.written
        if draft.internal or (written and state.listening):
            draft.moves.append(leap.move)
            draft.looked += looked
            complete(program, state, None)
            return close(program, state, event)
        if draft.effects or draft.notes or draft.news:
            notes = with_verdicts(draft.notes)[0] if draft.notes else ()
            state.draft = StepDraft()
            return self._short(event, leap.moves, looked, tuple(written), tuple(draft.effects), notes)
        step = self._short(event, leap.moves, looked, tuple(written))
        written.clear()
        return step

    def _short(
        self, event: Event, moves: tuple[Move, ...], looked: tuple[tuple[str, Truth], ...],
        written: tuple[tuple[str, Any], ...] = (), effects: tuple[Effect, ...] = (), notes: tuple[str, ...] = (),
    ) -> Step:  # fmt: skip
        """The value of a step on the short way; without moves no transition fired."""
        state = self.state
        state.seq = seq = state.seq + 1
        wake = state.wake
        return _new(Step, (
            seq, state.at, event, moves, looked, written, None, None if wake == inf else wake, effects, "", notes,
            (), "running", state.holder, (), "", False,
        ))  # fmt: skip

    def absorb(self, writes: Iterable[tuple[str, Any, float]], *, at: float, seq: int) -> None:
        """Take over what quiet steps wrote, without stepping: a replay is where the run was then.

        Args:
            writes: Key, value and stamp.
            at: The time until which nothing else happened.
            seq: The number of the last step until then.
        """
        state, writes = self.state, tuple(writes)
        if not writes and seq == state.seq:
            return
        for key, value, stamp in writes:
            state.board[key] = Stamped(value, stamp)
        state.at, state.seq = max(state.at, at), seq
        look_ahead(self.program, state)

    def settle_holds(self) -> None:
        """Give what is held, now, the time that it had left: what begins from here on counts from the same instant."""
        settle_holds(self.program, self.state)

    def configuration(self, targets: Iterable[str]) -> tuple[Configuration, list[str]]:
        """The configuration in which these states are active, and the pairs of states in it that exclude each other.

        Args:
            targets: Their names; what is inside them is entered by default.
        """
        return snapshot.configuration(self.program, targets)

    def broken(self) -> Iterator[tuple[str, str]]:
        """The invariants that are false now: name, and its guard in words."""
        return snapshot.broken(self.program, self.state)

    # -- what is known of the run ---------------------------------------------------------------------------------

    @property
    def mission(self) -> Mission:
        """The mission."""
        return self.program.mission

    @property
    def terms(self) -> RobotFacts:
        """What is known of the robot."""
        return self.program.facts

    @property
    def view(self) -> View:
        """What guards see of the run."""
        return self.state

    @property
    def at(self) -> float:
        """Now, in seconds on the run's clock."""
        return self.state.at

    @property
    def seq(self) -> int:
        """Steps so far."""
        return self.state.seq

    @property
    def mode(self) -> Mode:
        """`ready`, `running`, `paused` or `canceling`; of a run that has ended, its outcome."""
        return mode_of(self.state.mode, self.state.outcome)

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self.state.active

    @property
    def outcome(self) -> FinalOutcome | None:
        """How the mission ended; None while it runs."""
        return self.state.outcome

    @property
    def why(self) -> str:
        """The rule that decided the outcome."""
        return self.state.why

    @property
    def cause(self) -> Cause:
        """What has ended the mission, where no rule of it did."""
        return self.state.cause

    @property
    def false_invariant(self) -> str:
        """The name of the invariant that has ended the mission; empty for any other end."""
        return self.state.false_invariant

    @property
    def quiet(self) -> bool:
        """The last step did nothing but write the blackboard: it need not be written down by itself."""
        return self.state.quiet

    @property
    def wake_at(self) -> float | None:
        """The earliest instant at which time alone can change something."""
        return self.state.wake_at

    @property
    def unheard(self) -> tuple[str, ...]:
        """The robot keys that the start waits for: never received, or stale whenever they were."""
        state, keys = self.state, self.program.keys.items()
        waited = (name for name, key in keys if key.source == "robot" and not key.optional)
        return tuple(name for name in waited if name not in state.board or name in state.outdated)

    @property
    def questions(self) -> tuple[Question, ...]:
        """Those that are open, the oldest first, each with the time that it has by now."""
        found = (each for _, _, activity in live(self.program, self.state) for each in questions_in(activity))
        return tuple(sorted(found, key=lambda question: question.number))

    @property
    def awaited(self) -> frozenset[int]:
        """The numbers of goals, calls, questions and behaviours whose end the run still waits for."""
        each = (machine.awaits(activity) for _, machine, activity in live(self.program, self.state))
        return frozenset(self.state.goals).union(self.state.calls, *each)

    @property
    def awaited_goals(self) -> int:
        """How many goals have an end that has not been confirmed and that the run waits for.

        Those that are left unconfirmed, `open_goals` of `Result` and of the status, are `loose_goals`.
        """
        return awaited(self.state.goals)

    @property
    def loose_goals(self) -> tuple[OpenGoal, ...]:
        """The goals that may still be executing, and that no cancel can be relied on to end."""
        return loose(self.state.goals)

    # -- who has control ------------------------------------------------------------------------------------------

    @property
    def holder(self) -> Holder:
        """Who holds control."""
        return holder_of(self.program, self.state)

    @property
    def taken(self) -> bool:
        """The operator holds it and has taken it, rather than been given it by the mission."""
        return self.state.taken

    @property
    def waiting(self) -> Mapping[str, str]:
        """State → who must have control before what it does can begin, or begin again."""
        nodes, state = self.program.graph.nodes, self.state
        each = {name: nodes[name].control for name in (*state.pending, *state.laid_by)}
        return {name: holder for name, holder in each.items() if holder is not None}

    @property
    def wanted(self) -> frozenset[str]:
        """Who must have control for what waits to begin."""
        wanted = (self.program.graph.nodes[name].control for name in self.state.pending)
        return frozenset(holder for holder in wanted if holder is not None)

    @property
    def held_by(self) -> str:
        """`operator`, who has taken control, or `nobody`; empty while the mission is not held."""
        return held_by(self.state)

    @property
    def held_since(self) -> float | None:
        """Since when, in seconds on the run's clock; None while the mission is not held."""
        return self.state.held_since if self.held_by else None

    @property
    def held(self) -> frozenset[str]:
        """The active states that wait until the operator gives control back."""
        state = self.state
        return frozenset(node.name for node in state.config.nodes if state.frozen and node.control in state.frozen)

    @property
    def paused_at(self) -> float | None:
        """Since when no question loses time; None while the run is not paused."""
        return self.state.paused_at if self.mode == "paused" else None

    def still_since(self, name: str) -> float | None:
        """Since when the time of a state is stopped, in seconds on the run's clock; None while it runs."""
        state, control = self.state, self.program.graph.nodes[name].control
        instants = [state.paused_at] if self.mode == "paused" else []
        instants += [state.frozen[control]] if control in state.frozen else []
        return min(instants, default=None)


class ChartBranch(Chart):
    """A chart that continues where another is.

    Args:
        chart: The other.
    """

    def __init__(self, chart: Chart) -> None:
        self.program, self.state = chart.program, copied(chart.state)

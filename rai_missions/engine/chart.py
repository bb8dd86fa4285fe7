# SPDX-License-Identifier: Apache-2.0
"""The pure semantics: what a mission makes of an event, as a Step.

Rule: everything that decides is a function over a `Program` and a `RunState`; `Chart` holds the two. The same mission,
events and times give the same Steps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from types import NoneType
from typing import Any

from rai_missions.engine import short_way, snapshot
from rai_missions.engine.activities.goal_ledger import OpenGoal, awaited, loose
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import questions_in
from rai_missions.engine.configuration import Configuration
from rai_missions.engine.decision import Question
from rai_missions.engine.events import NOT_STARTED
from rai_missions.engine.handover import settle_holds
from rai_missions.engine.hold import held_by, holder_of, live, waiting_answers
from rai_missions.engine.modes import Mode
from rai_missions.engine.nodes import Written
from rai_missions.engine.program import Named
from rai_missions.engine.robot_facts import RobotFacts, check_facts
from rai_missions.engine.short_way import BEFORE
from rai_missions.engine.snapshot import Snapshot
from rai_missions.engine.state import copied
from rai_missions.engine.step import Cause, Step
from rai_missions.engine.stepping import begin_run, close, compiled, fresh, make_step
from rai_missions.engine.surroundings import Surroundings
from rai_missions.engine.timing import look_ahead
from rai_missions.errors import UsageError, suggestion
from rai_missions.event import Event
from rai_missions.given import check_event, check_given, check_seconds, given_names
from rai_missions.guards.view import View
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.states.control import Holder
from rai_missions.states.final import FinalOutcome

__all__ = ("NOT_STARTED", "Chart", "Named", "Snapshot")

_new = tuple.__new__
NO_WRITES: Written | None = ()


class Chart:
    """One run of a mission: events go in, and each gives the `Step` that the mission's rules make of it.

    Nothing else happens: no clock runs, nothing is sent. What a step asks of the robot is in its `effects`.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees: `rai_missions.trees.PyTrees()` for py_trees itself, which comes to the same.
        terms: What is known of the robot: which actions exclude each other, when a composed one has succeeded.
        named: The predicates that `{"named": …}` guards name.
        surroundings: Where a proof watches, and what it leaves open; a run needs none.

    Raises:
        UsageError: The mission names a predicate that was not given, or is none.
    """

    def __init__(
        self,
        mission: Mission,
        ticker: Trees | None = None,
        *,
        terms: RobotFacts | None = None,
        named: Named | None = None,
        surroundings: Surroundings | None = None,
    ) -> None:
        given_mission(mission, "a chart")
        check_given(ticker, (Trees, NoneType), "ticker", "what compiles trees", "PyTrees() is one")
        check_facts(terms)
        if named is not None:
            given_names(named, "named", "predicates")
        self.program = compiled(mission, ticker, facts=terms, named=named, surroundings=surroundings)
        self.state = fresh(self.program)

    @classmethod
    def restore(
        cls,
        mission: Mission,
        saved: Snapshot,
        ticker: Trees | None = None,
        *,
        terms: RobotFacts | None = None,
        named: Named | None = None,
    ) -> Chart:
        """A chart that continues where a snapshot was taken.

        Raises:
            UsageError: It is no mission, or no snapshot.
        """
        given_names(saved, "restore", "what a snapshot holds")
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
            UsageError: It was started before, or is paused; or the time is no number.
        """
        check_seconds(at, "start")
        if not self.unstarted:
            raise UsageError(f"the mission was started before; it is {self.mode}")
        if self.held_back:
            raise UsageError("the mission is paused before its start; resume it first")
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
        name: object = key  # a program may give anything
        if not isinstance(name, str) or name not in self.program.keys:
            check_given(name, str, "write", "the name of a key")
            raise UsageError(f"the mission has no key '{key}'{suggestion(key, self.program.keys)}")
        if stamp is not None:
            check_seconds(stamp, "stamp")
        data = {"value": value} if stamp is None else {"value": value, "stamp": stamp}
        return self.send(_new(Event, (key, self.state.at if at is None else at, data, "write", 0)))

    def propose(
        self,
        number: int,
        option: str,
        parameters: Mapping[str, Any] | None = None,
        *,
        by: str = "",
        why: str = "",
        at: float | None = None,
    ) -> Step:
        """Answer a question; the step's `verdict` has what became of it.

        Args:
            number: The question's.
            option: The name of the option that is proposed.
            parameters: What the option asks for.
            by: Who answers; whom the question was put to, if nothing else is given.
            why: The reason, for people.
            at: When the answer arrives, in seconds on the run's clock; now, if nothing else is given.
        """
        given = given_names({} if parameters is None else parameters, "parameters", "values")
        asked = next((question.asked for question in self.questions if question.number == number), "")
        data = {"option": option, "parameters": dict(given)} | ({"why": why} if why else {})
        return self.send(Event(by or asked, self.at if at is None else at, data, "proposal", number))

    def send(self, event: Event) -> Step:
        """Let an event happen: everything due before it first, then it, to completion.

        One whose time has passed already happens now. An event that does nothing but fire transitions without timers,
        activities and ends takes the short way.

        Raises:
            UsageError: Its time is not a finite number of seconds, or it is no event.
        """
        try:
            state = self.state
            name, at, data, kind, _ = event
            # True and Decimal compare like numbers, and are no times: `check_event` decides on any class but these two.
            is_other = at.__class__ is not float and at.__class__ is not int
            if not state.quick or kind != "event" or is_other or not BEFORE < at < state.wake:
                if kind == "write" and state.quick and not is_other and BEFORE < at < state.wake:
                    return short_way.reading(self.program, state, event)
                check_event(event, "a chart")
                return make_step(self.program, state, event)
            direct = state.config.direct.get(name)
            if direct is None:
                return short_way.step(self.program, state, event)
            if at > state.at:
                state.at = at
            state.event = data
            test, looked, leap = direct
            if test is not None and (value := test(state)) is not True:
                return short_way.value(state, event, (), ((looked[0][0], value),))
            write, written = leap.write, NO_WRITES
            if state.listening or (write is None and leap.acts):
                return short_way.leapt(self.program, state, event, leap, looked)
            if write is not None:
                written = write(state)
                if written is None:
                    return short_way.leapt(self.program, state, event, leap, looked)
            state.config = config = leap.config
            state.active = config.active
            state.seq = seq = state.seq + 1
            state.quiet = False
            wake = state.wake
            return _new(
                Step,
                (
                    seq,
                    state.at,
                    event,
                    leap.moves,
                    looked,
                    written,
                    None,
                    None if wake == inf else wake,
                    (),
                    "",
                    (),
                    (),
                    "running",
                    state.holder,
                    (),
                    "",
                    False,
                ),
            )
        except (ArithmeticError, AttributeError, TypeError, ValueError):
            # Looked at only now: a look at each event would cost each its time.
            check_event(event, "a chart")
            raise

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
        return self.state.shown_mode

    @property
    def unstarted(self) -> bool:
        """It has neither been started nor ended: `ready`, or paused before its start."""
        return self.state.mode == "ready"

    @property
    def held_back(self) -> bool:
        """It was paused before its start, and not resumed: it does not begin by itself."""
        return self.state.held_back

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self.state.active

    @property
    def active_in_order(self) -> tuple[str, ...]:
        """The same in the order of the mission's text; its other states are not looked at."""
        nodes = self.program.graph.nodes
        return tuple(sorted(self.state.active, key=lambda name: nodes[name].index))

    @property
    def rounds(self) -> Mapping[str, tuple[int, int]]:
        """Active `each` → how many of its items are over, and how many it has: those of its entry."""
        return {name: (over, len(items)) for name, (items, over) in tuple(self.state.rounds.items())}

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
        state, waited = self.state, self.mission.needed_facts()
        return tuple(name for name in waited if name not in state.board or name in state.outdated)

    @property
    def questions(self) -> tuple[Question, ...]:
        """Those that are open, the oldest first, each with the time that it has by now."""
        found = (each for _, _, activity in live(self.program, self.state) for each in questions_in(activity))
        return tuple(sorted(found, key=lambda question: question.number))

    @property
    def waiting_answers(self) -> tuple[Event, ...]:
        """The answers that are judged once a pause ends, or control is given back."""
        return waiting_answers(self.state)

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
        wanted = (self.program.graph.nodes[name].control for name in tuple(self.state.pending))
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

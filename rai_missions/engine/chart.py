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

from rai_missions.engine import snapshot
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.chart_view import ChartView
from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.program import Named, Program
from rai_missions.engine.compiled.states import Written
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.robot_facts import RobotFacts, check_facts
from rai_missions.engine.semantics import short_way
from rai_missions.engine.semantics.handover import settle_holds
from rai_missions.engine.semantics.short_way import BEFORE
from rai_missions.engine.semantics.stepping import begin_run, close, compiled, fresh, make_step
from rai_missions.engine.semantics.timing import look_ahead
from rai_missions.engine.snapshot import Snapshot
from rai_missions.engine.state import RunState, copied
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError, suggestion
from rai_missions.event import Event
from rai_missions.given import check_event, check_given, check_seconds, given_names
from rai_missions.guards.view import View
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission, given_mission

__all__ = ("Chart",)

_new = tuple.__new__
NO_WRITES: Written | None = ()


class Chart(ChartView):
    """One run of a mission: events go in, and each gives the `Step` that the mission's rules make of it.

    Nothing else happens: no clock runs, nothing is sent. What a step asks of the robot is in its `effects`.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees: `rai_missions.trees.PyTrees()` for py_trees itself, which comes to the same.
        robot_facts: What is known of the robot: which actions exclude each other, when a composed one has succeeded.
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
        robot_facts: RobotFacts | None = None,
        named: Named | None = None,
        surroundings: Surroundings | None = None,
    ) -> None:
        given_mission(mission, "a chart")
        check_given(ticker, (Trees, NoneType), "ticker", "what compiles trees", "PyTrees() is one")
        check_facts(robot_facts)
        if named is not None:
            given_names(named, "named", "predicates")
        program = compiled(mission, ticker, robot_facts=robot_facts, named=named, surroundings=surroundings)
        super().__init__(program, fresh(program))

    @classmethod
    def restore(
        cls,
        mission: Mission,
        saved: Snapshot,
        ticker: Trees | None = None,
        *,
        robot_facts: RobotFacts | None = None,
        named: Named | None = None,
    ) -> Chart:
        """A chart that continues where a snapshot was taken.

        Raises:
            UsageError: It is no mission, or no snapshot.
        """
        given_names(saved, "restore", "what a snapshot holds")
        chart = cls(mission, ticker, robot_facts=robot_facts, named=named)
        snapshot.put_back(chart.program, chart.state, saved)
        return chart

    def branch(self) -> Chart:
        """A copy of this chart in its present state: what happens to either later changes nothing in the other."""
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
        begin_run(self._program, self._state, at)
        return close(self._program, self._state, Event("start", at, kind="command"))

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
        if not isinstance(name, str) or name not in self._program.keys:
            check_given(name, str, "write", "the name of a key")
            raise UsageError(f"the mission has no key '{key}'{suggestion(key, self._program.keys)}")
        if stamp is not None:
            check_seconds(stamp, "stamp")
        data = {"value": value} if stamp is None else {"value": value, "stamp": stamp}
        return self.send(_new(Event, (key, self._state.at if at is None else at, data, "write", 0)))

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
            state = self._state
            name, at, data, kind, _ = event
            # True and Decimal compare like numbers, and are no times: `check_event` decides on any class but these two.
            is_other = at.__class__ is not float and at.__class__ is not int
            if not state.quick or kind != "event" or is_other or not BEFORE < at < state.wake:
                if kind == "write" and state.quick and not is_other and BEFORE < at < state.wake:
                    return short_way.receive_reading(self._program, state, event)
                check_event(event, "a chart")
                return make_step(self._program, state, event)
            direct = state.config.direct.get(name)
            if direct is None:
                return short_way.receive_event(self._program, state, event)
            if at > state.at:
                state.at = at
            state.event = data
            test, looked, move = direct
            if test is not None and (value := test(state)) is not True:
                return short_way.short_step(state, event, (), ((looked[0][0], value),))
            write, written = move.write, NO_WRITES
            if state.watched or (write is None and move.acts):
                return short_way.finish_move(self._program, state, event, move, looked)
            if write is not None:
                written = write(state)
                if written is None:
                    return short_way.finish_move(self._program, state, event, move, looked)
            state.config = move.config
            state.seq = seq = state.seq + 1
            state.quiet = False
            wake = state.wake
            return _new(
                Step,
                (
                    seq,
                    state.at,
                    event,
                    move.values,
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
        state, writes = self._state, tuple(writes)
        if not writes and seq == state.seq:
            return
        for key, value, stamp in writes:
            state.board[key] = Stamped(value, stamp)
        state.at, state.seq = max(state.at, at), seq
        look_ahead(self._program, state)

    def settle_holds(self) -> None:
        """Give what is held, now, the time that it had left: what begins from here on counts from the same instant."""
        settle_holds(self._program, self._state)

    def configuration(self, targets: Iterable[str]) -> tuple[Configuration, list[str]]:
        """The configuration in which these states are active, and the pairs of states in it that exclude each other.

        Args:
            targets: Their names; what is inside them is entered by default.
        """
        return snapshot.configuration(self._program, targets)

    def broken(self) -> Iterator[tuple[str, str]]:
        """The invariants that are false now: name, and its guard in words."""
        return snapshot.broken(self._program, self._state)

    # -- for those who watch each step ---------------------------------------------------------------------------

    @property
    def program(self) -> Program:
        """The compiled mission."""
        return self._program

    @property
    def state(self) -> RunState:
        """What the run remembers. A proof puts another in its place."""
        return self._state

    @state.setter
    def state(self, state: RunState) -> None:
        self._state = state

    @property
    def view(self) -> View:
        """What guards see of the run."""
        return self._state

    @property
    def quiet(self) -> bool:
        """The last step did nothing but write the blackboard, or refuse to: it need not be written down by itself."""
        return self._state.quiet

    @property
    def held(self) -> frozenset[str]:
        """The active states that wait until the operator gives control back."""
        state = self._state
        return frozenset(node.name for node in state.config.nodes if state.frozen and node.control in state.frozen)


class ChartBranch(Chart):
    """A chart that continues where another is.

    Args:
        chart: The other.
    """

    def __init__(self, chart: Chart) -> None:
        ChartView.__init__(self, chart.program, copied(chart.state))

# SPDX-License-Identifier: Apache-2.0
"""Everything that can happen to a mission in a state: what it receives, what is known, the operator's orders, and time.

Rule: what is listed here is all that a proof is about; nothing else is assumed of robot, model, person or clock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.activities.computing import ComputingMachine
from rai_missions.engine.activities.decision import DecisionMachine
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import TreeMachine
from rai_missions.engine.compiled.configuration import CompiledMove
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.semantics.handover import is_kept, receive_control
from rai_missions.engine.semantics.stepping import begin_run
from rai_missions.engine.state import RunState
from rai_missions.event import Event
from rai_missions.guards.view import Site, Test, Truth, View
from rai_missions.keys import Key, Stamped
from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction.abstraction import Abstraction
from rai_missions.prove.abstraction.asked_readings import AskedReadings, OpenSite
from rai_missions.prove.abstraction.control_env import ControlEnvironment, control_event
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.nondeterminism import Choices, OpenFields
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld, predicates_in
from rai_missions.prove.abstraction.state_key import Place, StateCodec
from rai_missions.prove.abstraction.step_circles import StepCircles
from rai_missions.prove.analysis.parts import parts
from rai_missions.prove.environment.input_env import InputEnvironment
from rai_missions.prove.environment.time_env import TimeEnvironment
from rai_missions.prove.stimulus import Stimulus
from rai_missions.states.action import Action
from rai_missions.states.control import Holder
from rai_missions.states.effects import Call
from rai_missions.states.tree.leaves import ActionLeaf

__all__ = ("RESUME", "Environment")

RESUME = "the operator resumes"


class OpenSurroundings(Surroundings):
    """What the engine asks of a proof, and reports to it."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment

    def holder(self, state: RunState) -> Holder:
        return self._environment.control.find(state)

    def site(self, place: str, keys: Mapping[str, Key], state: str) -> Site:
        return OpenSite(place, keys, state, self._ask)

    def _ask(self, view: View, key: str, test: Test, counts: Truth) -> Truth:
        return self._environment.readings.ask(view, key, test, counts)

    def machine(self, node: CompiledState, machine: Machine) -> Machine:
        self._environment.instruments.watch(machine, node.place)
        if isinstance(machine, DecisionMachine):
            self._environment.inputs.leave_answers_open(machine)
        if isinstance(machine, ComputingMachine) and node.state is not None:
            live = self._environment.rest.live
            return machine.computing(self._environment.world.anything_of(node, machine.into, live))
        return machine

    def before_move(self, state: RunState, move: CompiledMove) -> bool:
        return self._environment.circles.may_move(state, move)

    def before_entry(self, state: RunState, node: CompiledState) -> None:
        self._environment.control.enter(state, node)

    def before_round(self, state: RunState, node: CompiledState) -> None:
        self._environment.rest.lengthen(state, node, self._environment.circles.is_new_round)

    def waits(self, state: RunState, event: Event, waiting: tuple[Event, ...]) -> bool:
        return self._environment.control.waits(state, event, waiting)


class Environment:
    """A mission to which anything can happen.

    Args:
        mission: One that `check` finds no fault in.
        ticker: Who ticks trees.
        robot_facts: What is known of the robot.
        is_calm: The operator leaves the mission alone.
    """

    def __init__(
        self,
        mission: Mission,
        ticker: Trees | None = None,
        *,
        robot_facts: RobotFacts | None = None,
        is_calm: bool = False,
    ) -> None:
        self.choices, self.instruments = Choices(), Instruments(is_foreign=bool(mission.uses))
        self.chart = chart = Chart(
            mission,
            ticker,
            robot_facts=robot_facts,
            named=predicates_in(mission, self.choices),
            surroundings=OpenSurroundings(self),
        )
        self.instruments.watch_finals(chart.program)
        self.world = OpenWorld(chart, self.choices)
        self.readings = AskedReadings(chart, self.world)
        self.control = ControlEnvironment(chart, self.choices, is_calm=is_calm)
        self.rest = Abstraction(chart, self.world, self.control, self.instruments)
        self.circles = StepCircles(chart, self.world, self.rest, self.instruments)
        self.codec = StateCodec(chart, self.world, self.rest)
        self.inputs = InputEnvironment(chart, self.world, self.rest, self.instruments)
        self.time = TimeEnvironment(chart, self.world, self.codec, self.inputs, self.rest, self.instruments)
        runs = any(state.activity() and not state.options for _, _, state in mission.walk())
        is_informed = bool(self.world.fleeting or self.world.predicates) or self.world.own_fade
        calls = any(True for _ in parts(mission, Call))
        self.has_actions = any(True for kind in (Action, ActionLeaf) for _ in parts(mission, kind))
        """Goals can be started."""
        self.pause_matters = runs or is_informed or bool(self.control.needed) or calls
        """Something can change while the mission is paused; else it continues as if nothing had been."""

    @property
    def has_stores(self) -> bool:
        """What a step asks of a store is known, and states can differ in it alone."""
        return (bool(self.world.stored) or self.has_actions) and not self.world.own_fade

    def load(self, place: Place) -> None:
        """Be in a state again."""
        self.codec.load(place)
        self.control.leave_open()

    def make(self, happens: Callable[[], None]) -> None:
        """Let something happen; what it did can be read until the next."""
        self.time.begin_step()
        self.rest.make(happens)

    def settle(self) -> None:
        """Come to rest: forget what makes no difference any more."""
        self.rest.settle()
        self.time.part_groups()

    def of_goals(self) -> Iterator[Stimulus]:
        """What can be reported, or never is, of the goals that nothing pursues."""
        if self.chart.mode in ("running", "paused", "canceling"):
            yield from self.time.orphans()
            yield from self.inputs.of_goals()

    def happenings(self) -> Iterator[Stimulus]:
        """Everything else that can happen now but a cancel and an e-stop.

        Time comes last: of two shortest runs the one is printed in which reports come before it, when nothing that they
        are about has run out of time.
        """
        mode = self.chart.mode
        if mode == "paused":
            yield from self._meanwhile()
        elif mode in ("running", "canceling"):
            yield from self.inputs.answers()
            yield from self.inputs.reports()
            yield from self.inputs.events()
            yield from self._writes()
            yield from self._handovers()
            yield from self.time.times()
            yield from self.time.turn_times()
            if mode == "running" and self.pause_matters and not self.control.is_calm:
                yield Stimulus("the operator pauses", "command", self.ordering("pause"))
                yield from self._stop()

    def _meanwhile(self) -> Iterator[Stimulus]:
        """What can happen while the mission is paused; what would wait for its continuation can come then, too."""
        yield from self.inputs.of_calls()
        yield from self._writes()
        yield Stimulus(RESUME, "event", self._resume)
        yield from self._stop()

    def _stop(self) -> Iterator[Stimulus]:
        """A stop ends what a pause keeps; where nothing of that runs, it is a pause."""
        program, running = self.chart.program, self.chart.state.running
        if not self.control.is_calm and any(is_kept(program, program.graph.nodes[name]) for name in running):
            yield Stimulus("the operator stops the robot", "command", self.ordering("stop"))

    def _resume(self) -> None:
        """Control may have changed hands meanwhile: then it did before anything starts again."""
        control, state = self.control, self.chart.state
        control.is_resuming = True
        if control.here:
            found = self.choices.choose(1 + len(control.holds))
            if found:
                control.take(control.holds[found - 1])
            assert self.chart.holder
            assert control.found is not None
            receive_control(self.chart.program, state, control.found)
        self.ordering("resume")()
        control.is_resuming = False

    def begin(self) -> None:
        """The mission starts, no matter who has control."""
        self.control.let_go()
        self.control.leave_open()
        begin_run(self.chart.program, self.chart.state, NOW)

    def ordering(self, command: str) -> Callable[[], None]:
        """The operator's order to `pause`, `stop`, `resume` or `cancel`, or the e-stop (`kill`)."""

        def order() -> None:
            self.inputs.handle(Event(command, NOW, {"by": "operator"}, "command"))
            if command in ("pause", "stop"):
                self.control.lay_by()

        return order

    def _handovers(self) -> Iterator[Stimulus]:
        """A handover is acknowledged, what runs loses control, or the operator takes it and gives it back."""
        control = self.control
        for who in sorted(control.waited_for):
            yield self._handover(f"control is with {who}", who, "mission")
        if control.is_calm or not control.here:
            return
        if control.is_held:
            for who in control.others:
                yield self._handover(f"the operator gives control back to {who}", who, "mission")
        elif control.is_in_hand:
            for who in [who for who in control.others if who != self.chart.state.holder]:
                yield self._handover(f"control is with {who}", who, "mission")
        for who in [who for who in control.holds if who != self.chart.held_by]:
            words = "the operator takes control" if who == "operator" else "control is taken, and with no one"
            yield self._handover(words, who, "operator")

    def _handover(self, words: str, who: str, by: str) -> Stimulus:
        do = self.inputs.receive(control_event(who, by))
        return Stimulus(words, "robot" if by != "operator" else "command", do)

    # -- what is known --------------------------------------------------------------------------------------------

    def _writes(self) -> Iterator[Stimulus]:
        """What is listened for becomes each other thing that it can be."""
        board, state = self.world.board, self.chart.state
        for key in sorted(state.watched):
            now = board.known(key)
            alike = board.among.get(key) or ((None if now is None else now.value,) if board.is_known(key) else ())
            for value in self._others(key, now):
                if value in alike:
                    continue
                if value is None:
                    yield self._goes_stale(key)
                else:
                    yield Stimulus(f"{key} is {_in_words(value)}", "write", self._report(key, value), key=key)
        for key, written in self.chart.mission.blackboard.items():
            if written.max_age_s is not None and written.source != "robot" and board.known(key) is not None:
                yield self._goes_stale(key)
        running = state.running if state.mode != "paused" else ()
        trees = [name for name in running if isinstance(self.chart.program.machines[name], TreeMachine)]
        if trees or self.world.predicates:
            yield Stimulus(
                "time passes, and rules are looked at again",
                "write",
                lambda: self.time.time_passes(*trees),
                is_tick=True,
            )

    def _goes_stale(self, key: str) -> Stimulus:
        gone = self.time.elapse(self._forget_it(key), beyond=key)
        return Stimulus(f"{key} goes stale", "write", gone, stale=key, key=key)

    def _others(self, key: str, now: Any) -> Iterator[Any]:
        """What it can be next; of an object the fields alone that someone looks at."""
        if key not in self.world.shapes:
            yield from self.world.values.of(key)
            return
        if None in self.world.values.of(key):
            yield None
        if now is None:
            yield self.world.shapes[key].fresh({})
            return
        yield from now.value.mixtures()

    def _report(self, key: str, value: Any) -> Callable[[], None]:
        def happen() -> None:
            made = value.fresh() if isinstance(value, OpenFields) else value
            if alike := self.world.board.among.get(key):  # that it changes is all that a step finds out of these
                self.world.board.put(key, None if alike[0] is None else Stamped(alike[0], NOW))
            self.inputs.handle(Event(key, NOW, {"value": made}, "write"))

        return happen

    def _forget_it(self, key: str) -> Callable[[], None]:
        def change() -> None:
            self.world.board.put(key, None)

        return change


def _in_words(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, OpenFields):
        return value.words()
    return f"{value:g}" if isinstance(value, float) else str(value)

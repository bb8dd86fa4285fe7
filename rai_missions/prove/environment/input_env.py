# SPDX-License-Identifier: Apache-2.0
"""What robot, model, person and other programs can report to a mission in a state.

Rule: anyone who is asked can answer anything or nothing, and a server ends a goal in any way at any time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import GOAL_ENDS, GoalActivity
from rai_missions.engine.activities.activity import ActivityHost, Machine, Turn
from rai_missions.engine.activities.behaviour import BehaviourActivity
from rai_missions.engine.activities.call import replies_to
from rai_missions.engine.activities.decision import DecisionActivity, DecisionMachine
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree import TreeActivity
from rai_missions.engine.decision import Offer, Question, VerdictNote
from rai_missions.engine.semantics.events import handle
from rai_missions.engine.semantics.hold import free, is_held
from rai_missions.event import Event, EventKind
from rai_missions.prove.abstraction.abstraction import Abstraction
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.nondeterminism import Payload
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.environment.answer_values import AnswerValues, Parameters
from rai_missions.prove.stimulus import Stimulus
from rai_missions.states import answerer_words

__all__ = ("InputEnvironment",)


class InputEnvironment:
    """Everything that can be reported to a mission.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        rest: Which goals make a difference.
        instruments: Which parameters options take.
    """

    def __init__(self, chart: Chart, world: OpenWorld, rest: Abstraction, instruments: Instruments) -> None:
        self._chart, self._world, self._rest, self._instruments = chart, world, rest, instruments
        self._choices, self._values = world.choices, world.values
        self._brought = AnswerValues(chart.mission.blackboard, world.values)
        self._names_doubt = any("uncertain" in transition.on for _, transition in chart.mission.every_transition())
        """Some transition is about what was done or not, as far as is known."""
        self.last_event: Event | None = None
        """What last happened to the mission."""
        self._brings: Parameters | None = None
        """What that brought along, where it was an answer with parameters."""

    def handle(self, event: Event, brings: Parameters | None = None) -> None:
        """Let an event happen."""
        self.last_event, self._brings = event, brings
        handle(self._chart.program, self._chart.state, event)

    @property
    def example(self) -> Event | None:
        """What last happened, as plain data; what no one has looked at of an answer is anything that is allowed."""
        event = self.last_event
        if event is None:
            return None
        brought = self._brings.example() if self._brings is not None else {}
        return event._replace(data={**event.data, **({"parameters": brought} if brought else {})})

    def owner_of(self, number: int) -> str:
        """Whose goal, call, question or behaviour has a number; empty for none."""
        if number in self._chart.state.goals:
            return self._chart.state.goals[number].owner
        for name, path, state in self.inner(held=True):
            asked = state.question.number if isinstance(state, DecisionActivity) else getattr(state, "number", 0)
            if number and asked == number:
                return owned(name, path)
        return self._chart.state.calls.get(number, "")

    def receive(self, event: Event) -> Callable[[], None]:
        return lambda: self.handle(event)

    def events(self) -> Iterator[Stimulus]:
        """What the mission declares, and what may have been done or not, where some transition is about it."""
        state = self._chart.state
        if state.final is not None:
            return
        fields = self._values.fields("event")
        for name in self._chart.mission.events:
            plan = state.config.plans.get(name)
            if plan is None:
                plan = state.config.plan(name, declared=True)
            if plan and free(state, plan):  # what held states name can come right after the hand-back
                yield Stimulus(f"event '{name}'", "event", self._bringing(name, "event", fields), event=name)
        if self._names_doubt and not state.frozen:
            doubt = self._bringing("uncertain", "doubt", fields)
            yield Stimulus("no one knows whether it was done", "event", doubt, event="uncertain")

    def _bringing(self, name: str, kind: EventKind, fields: Sequence[str]) -> Callable[[], None]:
        """An event whose payload is chosen again each time it happens."""
        return lambda: self.handle(Event(name, NOW, Payload(fields, self._field), kind))

    def _field(self, field: str) -> Any:
        return self._choices.pick(self._values.field(f"event.{field}"))

    # -- reports --------------------------------------------------------------------------------------------------

    def reports(self) -> Iterator[Stimulus]:
        """Everything that servers, services and behaviours can report."""
        yield from self._late_successes()
        for goal in self._rest.pursued:
            if not is_held(self._chart.state, self._chart.program.graph.nodes[goal.owner.partition("#")[0]]):
                yield from self._goal(goal)
        for number, owner, machine in list(self._called()):
            yield from self._call(number, owner, machine)
        for number, owner in self._behaving():
            for status in ("success", "failure"):
                event = Event("behaviour", NOW, {"status": status}, "behaviour", number)
                words = f"the behaviour of '{owner}': {status}"
                yield Stimulus(words, "robot", self.receive(event), number)
        yield from self.of_calls()

    def _late_successes(self) -> Iterator[Stimulus]:
        """The goals that succeed although a pause or a handover asked for their end; just as well right after it."""
        for name, state in self.running(held=False):
            if isinstance(state, GoalActivity) and state.phase == "again":
                machine: Any = self._chart.program.machines[name]
                if machine.succeeded is None:  # what is composed of services ends as its 'cancel' reports
                    words = f"'{machine.definition.action}' of '{name}' succeeds although its end was asked for"
                    yield Stimulus(words, "robot", self._succeeding_late(name), owner=name)

    def _succeeding_late(self, name: str) -> Callable[[], None]:
        """The number of the goal is that of the moment: where goals are alike, one has the number of another."""

        def happen() -> None:
            self._result("succeeded", self._chart.state.running[name].number, name)()

        return happen

    def of_goals(self) -> Iterator[Stimulus]:
        """What can be reported of goals that no state waits for."""
        for goal in self._rest.remaining:
            words = f"'{goal.action}' of '{goal.owner}' has ended"  # how it ended makes no difference
            do = self._result("canceled", goal.number, goal.owner)
            yield Stimulus(words, "robot", do, goal.number, is_of_goal=True)

    def of_calls(self) -> Iterator[Stimulus]:
        """What can be reported of calls whose reply no state waits for: a failure is an event."""
        for service, number in sorted((service, number) for number, service in self._chart.state.calls.items()):
            yield from (each._replace(event="call_failed") for each in self._call(number, service, None))

    def _call(self, number: int, owner: str, machine: Machine | None) -> Iterator[Stimulus]:
        for reply in replies_to(machine):
            do = self._result(reply, number, owner)
            yield Stimulus(f"the call of '{owner}': {reply}", "robot", do, number)

    def _goal(self, goal: Goal) -> Iterator[Stimulus]:
        named, number = f"'{goal.action}' of '{goal.owner}'", goal.number
        if goal.phase == "sent":
            event = Event("accepted", NOW, {}, "accepted", number)
            yield Stimulus(f"{named} is accepted", "robot", self.receive(event), number)
        composed = goal.action in self._chart.robot_facts.succeeded
        for end in GOAL_ENDS:
            if composed and (end == "succeeded" or (goal.phase == "running" and end in ("failed", "rejected"))):
                continue  # its guards decide it, and no server
            do = self._result(end, number, goal.owner)
            yield Stimulus(f"{named} ended: {end}", "robot", do, number)

    def _result(self, name: str, number: int, owner: str) -> Callable[[], None]:
        """A report with those of its fields that the mission looks at."""

        def happen() -> None:
            data: dict[str, Any] = {}
            for key, field in self._wanted(owner).items() if name == "succeeded" else ():
                data[field] = self._given_result(key)
            for field in self._values.fields("event"):
                if field not in data:
                    data[field] = self._field(field)
            data = {field: value for field, value in data.items() if value is not None}
            self.handle(Event(name, NOW, data, "result", number))

        return happen

    def _given_result(self, key: str) -> Any:
        """What a result has for a key; it may lack it."""
        known = [value for value in self._values.of(key) if value is not None]
        learned = self._values.learned
        return self._choices.pick((None, *(known if key in learned.compared | learned.gone_over else known[:1])))

    def _wanted(self, owner: str) -> Mapping[str, str]:
        """Key → the field of the result that goes there."""
        name, is_leaf, path = owner.partition("#")
        machine: Any = self._chart.program.machines.get(name)
        if is_leaf and machine is not None:
            machine = machine.leaf_machines[path].machine
        wanted: Mapping[str, str] = getattr(getattr(machine, "definition", None), "result", {})
        return wanted

    def inner(self, *, held: bool = False) -> Iterator[tuple[str, str | None, Any]]:
        """Every activity that runs: its state, its path in a tree or None, its machine's state.

        Args:
            held: Those of held states, too.
        """
        for name, state in self.running(held=held):
            if isinstance(state, TreeActivity):
                for path, leaf in sorted(state.leaves.items()):
                    yield name, path, leaf.state
            else:
                yield name, None, state

    def running(self, *, held: bool) -> list[tuple[str, Any]]:
        """What runs, in the order of the mission: that in which it began is no part of a state.

        Args:
            held: What runs in held states, too.
        """
        state, nodes = self._chart.state, self._chart.program.graph.nodes
        found = sorted(state.running.items(), key=lambda each: nodes[each[0]].index)
        return found if held else [each for each in found if not is_held(state, nodes[each[0]])]

    def _behaving(self) -> list[tuple[int, str]]:
        running = [(owned(name, path), state) for name, path, state in self.inner()]
        return [(state.number, owner) for owner, state in running if isinstance(state, BehaviourActivity)]

    def _called(self) -> Iterator[tuple[int, str, Machine]]:
        """The calls whose reply an activity of any kind waits for: what it awaits that is no goal and no question."""
        for name, path, state in self.inner():
            if not isinstance(state, GoalActivity | DecisionActivity | BehaviourActivity):
                machine: Any = self._chart.program.machines[name]
                machine = machine if path is None else machine.leaf_machines[path].machine
                yield from ((number, owned(name, path), machine) for number in sorted(machine.awaits(state)))

    # -- answers --------------------------------------------------------------------------------------------------

    def answers(self) -> Iterator[Stimulus]:
        """Each option, one that there is not, and no one there; silence is the time that runs out."""
        for name, path, state in list(self.inner()):
            if isinstance(state, DecisionActivity):
                yield from self._replies(state.question, owned(name, path), is_bounded=state.deadline != math.inf)

    def _replies(self, question: Question, owner: str, *, is_bounded: bool) -> Iterator[Stimulus]:
        who, number = question.asked, question.number
        answer = f"answer of {answerer_words(who)} to '{owner}'"
        for offer in question.options:
            words = f"{answer}: {offer.name}"
            yield Stimulus(words, "answer", self._option(number, who, owner, offer), number)
        empty: tuple[tuple[str, dict[str, Any]], ...] = (("nonsense", {"option": "?"}),)
        if not is_bounded:  # else nonsense, absence and silence all have it asked again; see `activity_key.rested`
            empty += (("nothing, being absent", {"absent": "not here"}),)
        for last_event, data in empty:
            event = Event(who, NOW, data, "proposal", number)
            yield Stimulus(f"{answer}: {last_event}", "answer", self.receive(event), number)

    def _option(self, number: int, who: str, owner: str, offer: Offer) -> Callable[[], None]:
        schema = self._instruments.schemas.get((owner, offer.name))

        def happen() -> None:
            brings = self._brought.parameters(schema, self._choices.pick) if schema is not None else None
            known = brings.known() if brings is not None else {}
            data = {"option": offer.name, **({"parameters": known} if known else {})}
            self.handle(Event(who, NOW, data, "proposal", number), brings)

        return happen

    def leave_answers_open(self, machine: DecisionMachine) -> None:
        """Have the parameters of an answer that is accepted chosen when someone looks."""
        receive = machine.receive

        def receiving(state: DecisionActivity, event: Event, host: ActivityHost) -> Turn | None:
            turn = receive(state, event, host)
            if self._brings is None or turn is None or turn.outcome is None or not _is_accepted(turn):
                return turn
            return turn._replace(outcome=turn.outcome._replace(data=self._brings))

        machine.receive = receiving  # type: ignore[method-assign]


def _is_accepted(turn: Turn) -> bool:
    """Whether an outcome is the option that was proposed; a fallback comes without what an answer has brought."""
    return any(isinstance(each, VerdictNote) and each.verdict.accepted for each in turn.notes)


def owned(name: str, path: str | None) -> str:
    """Who asks, calls or pursues: a state, or a leaf of its tree."""
    return name if path is None else f"{name}#{path}"

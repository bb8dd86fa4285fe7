# SPDX-License-Identifier: Apache-2.0
"""The shortest run to a flaw, step by step and, where it can be had, done by the chart itself into a journal.

Rule: a journal is written by a chart that keeps time; whether the flaw is in it too is found out, not claimed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import Ask, CallService, Cause, StartBehaviour, StartGoal, Step
from rai_missions.event import Event, Tick
from rai_missions.guards.view import Truth
from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction.abstraction import PURSUED
from rai_missions.prove.abstraction.nondeterminism import AnyOf, OpenFields
from rai_missions.prove.abstraction.store import LEFT
from rai_missions.prove.analysis.parts import guards_in
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Edge, Space
from rai_missions.prove.stimulus import CANCEL, KILL, START
from rai_missions.prove.verdicts.properties import Property
from rai_missions.prove.verdicts.traced_lists import TracedLists

if TYPE_CHECKING:
    from rai_missions.journal import Journal

__all__ = ("TraceReplayer", "TraceStep", "go", "trace", "ways_to")

SLICE = 0.4
"""Facts are reported again after this part of the time for which they can be believed."""
MOST_INSTANTS = 20_000
"""Instants that are waited through, at most, for a thing that takes time."""


class TraceStep(NamedTuple):
    """One thing that happens on the way to a flaw."""

    words: str
    event: Event | None
    """What the mission receives; None where time passes or something goes stale."""
    owner: str
    """Whose goal, call, question or behaviour it is about; empty for others."""
    stale: str
    """The key that goes stale."""
    facts: Mapping[str, Any]
    """What is known when it happens: robot and argument keys, None for unknown."""
    control: Event | None
    """Who is found to have control when it happens, and by whom; None where no one looks or it is known."""
    predicates: Mapping[str, Truth]
    """The values of the user's predicates."""
    active: frozenset[str]
    """The states that are active afterwards."""
    outcome: str | None
    why: str
    cause: Cause
    false_invariant: str


def ways_to(space: Space, claim: Property) -> list[Edge]:
    """The shortest way to where a claim is refuted."""
    return [*space.path(claim.state), *([claim.way] if claim.way is not None else [])]


def trace(space: Space, claim: Property) -> list[TraceStep]:
    """What happens on the shortest way to where a claim is refuted."""
    environment = space.environment
    environment.load(space.fresh)
    found: list[TraceStep] = []
    lists = TracedLists(environment)
    for each in ways_to(space, claim):
        traced = _traced(environment, each, found[-1].facts if found else {})
        lists.learn()
        environment.settle()  # it may choose more of what an answer brings
        found.append(traced._replace(event=environment.inputs.example))
        environment.load(environment.codec.place())
    whole = lists.lists()
    return [each._replace(facts={name: whole.get(name, value) for name, value in each.facts.items()}) for each in found]


def go(environment: Environment, way: Edge) -> tuple[str, str]:
    """Let happen again what led one way.

    Returns:
        Whose goal, call, question or behaviour it is about, and the key that goes stale; empty for none.

    Raises:
        LookupError: That cannot happen here.
    """
    place = environment.codec.place()
    every = [*environment.happenings(), *environment.of_goals()] if way.at >= 0 else []
    alike = [each for each in every if each.words == way.words]
    if way.at >= len(alike):
        raise LookupError(way.words)
    happening = alike[way.at] if way.at >= 0 else None
    environment.load(place)
    environment.choices.begin(way.trail)
    environment.inputs.last_event, environment.control.found = None, None
    if happening is None:
        order = environment.ordering
        commands = {START: environment.begin, CANCEL: order("cancel"), KILL: order("kill")}
        environment.make(commands[way.words])
        return "", ""
    owner = environment.inputs.owner_of(happening.number)
    environment.make(happening.do)
    return owner, happening.stale


def _traced(environment: Environment, way: Edge, before: Mapping[str, Any]) -> TraceStep:
    owner, stale = go(environment, way)
    chart, world = environment.chart, environment.world
    looked = chart.state.draft.looked
    values = {place[6:]: value for place, value in looked if place.startswith("named:")}
    is_possible = world.is_possible  # it may look at more
    assert is_possible
    facts = {name: _plain(entry, before.get(name)) for name, entry in world.board.entries() if name in world.open_keys}
    event, found = environment.inputs.example, environment.control.found
    ended = chart.outcome, chart.why, chart.cause, chart.false_invariant
    return TraceStep(way.words, event, owner, stale, facts, found, values, chart.active, *ended)


def _plain(entry: Any, before: Any) -> Any:
    """A value that it can have: where it has one of several, what it was before, if that is one."""
    value = None if entry is None else entry.value
    if isinstance(value, AnyOf):
        return before if before in value else value[0]
    if isinstance(value, OpenFields):
        return value.example()
    return value


class TraceReplayer:
    """Has a chart that keeps time make the steps of a trace, into a new journal.

    Args:
        mission: The mission.
        robot_facts: What is known of the robot.
        journal: Where its steps are written.
    """

    def __init__(self, mission: Mission, robot_facts: RobotFacts | None, journal: Journal) -> None:
        self._journal = journal
        self._predicates: Mapping[str, Truth] = {}
        names = {name for each in guards_in(mission) for name in each.predicates()}
        self._chart = Chart(mission, robot_facts=robot_facts, named={name: self._predicate(name) for name in names})
        self._keys = mission.blackboard
        self._facts: dict[str, Any] = {}
        self._again: dict[str, float] = {}
        """Key → when it is reported again, before it goes stale."""
        self._started: dict[str, list[int]] = {}
        """Owner → the numbers of what it has started."""
        self._quiet: dict[str, tuple[str, Any, float]] = {}

    def play(self, run: list[TraceStep]) -> bool:
        """Make the steps of a trace; whether the run comes to the same states and outcome as the last one."""
        for traced in run:
            self._play(traced)
        return self._is_reached(run[-1])

    def _is_reached(self, traced: TraceStep) -> bool:
        chart = self._chart
        if (chart.outcome, chart.cause, chart.false_invariant) != (
            traced.outcome,
            traced.cause,
            traced.false_invariant,
        ):
            return False
        return chart.active == traced.active or traced.cause == "cycle"  # which end it in the midst of their rounds

    def _predicate(self, name: str) -> Callable[..., Truth]:
        return lambda known, **arguments: self._predicates.get(name)

    # -- one step -------------------------------------------------------------------------------------------------

    def _play(self, traced: TraceStep) -> None:
        self._predicates = traced.predicates
        named = traced.stale or (traced.event.name if traced.event is not None and traced.event.kind == "write" else "")
        gone = [name for name, value in traced.facts.items() if value is None and name != named and name in self._facts]
        self._grow_old(gone)
        for name, value in traced.facts.items():
            if value is not None and name != named and (name not in self._facts or self._facts[name] != value):
                self._write(name, value)
        found = traced.control
        if found is not None and (found.name, found.data["by"] == "operator") != (
            self._chart.holder,
            self._chart.taken,
        ):
            self._take(lambda: self._chart.send(found._replace(at=self._chart.at)))
        self._happen(traced)

    def _happen(self, traced: TraceStep) -> None:
        chart, event = self._chart, traced.event
        if traced.words == START:
            self._take(lambda: chart.start(chart.at))
        elif traced.stale:
            self._grow_old([traced.stale])
        elif event is None:
            self._wait(traced)
        elif event.kind == "write":
            self._write(event.name, traced.facts.get(event.name))
        else:
            number = self._number(traced.owner, event.number)
            self._take(lambda: chart.send(event._replace(at=chart.at, number=number)))

    def _number(self, owner: str, number: int) -> int:
        """The number that this chart has given to what the other numbered otherwise."""
        started, goals = self._started.get(owner, []), self._chart.state.goals
        if number in started or not started:
            return number
        given_up = [each for each in started if each in goals and goals[each].phase not in PURSUED]
        return given_up[0] if number >= LEFT and given_up else started[-1]

    def _take(self, make: Callable[[], Step]) -> Step:
        chart, since = self._chart, self._chart.at
        step = make()
        for effect in step.effects:
            if isinstance(effect, StartGoal | CallService | StartBehaviour):
                owner = effect.owner or getattr(effect, "service", "")
                self._started.setdefault(owner, []).append(effect.number)
            elif isinstance(effect, Ask):
                self._started.setdefault(effect.question.owner, []).append(effect.question.number)
        if chart.quiet and not step.refusal and step.event.kind in ("write", "tick"):
            self._quiet |= {key: (key, value, step.at) for key, value in step.writes}
        else:
            self._journal.write(step, since=since, quiet=tuple(self._quiet.values()))
            self._quiet.clear()
        return step

    def _write(self, name: str, value: Any) -> Step | None:
        if value is None or self._chart.outcome is not None:
            return None
        self._facts[name] = value
        age = self._keys[name].max_age_s
        self._again[name] = self._chart.at + SLICE * age if age is not None else math.inf
        return self._take(lambda: self._chart.write(name, value, self._chart.at))

    # -- time -----------------------------------------------------------------------------------------------------

    def _wait(self, traced: TraceStep) -> None:
        """Let time pass until the step has happened; what is known stays known."""
        for _ in range(MOST_INSTANTS):
            wake = self._chart.wake_at
            if wake is None or self._chart.outcome is not None:
                return
            for step in self._pass(wake, at_most=1):
                if (step.moves or step.effects or step.notes or step.outcome) and self._is_reached(traced):
                    return

    def _grow_old(self, names: list[str]) -> None:
        """Report nothing more of these until they are stale; of the others, the same as before."""
        until = self._chart.at
        for name in names:
            self._facts.pop(name, None)
            self._again.pop(name, None)
            age = self._keys[name].max_age_s
            entry = self._chart.view.board.get(name)
            if age is not None and entry is not None:
                until = max(until, entry.at + age)
        if until > self._chart.at:
            self._pass(until, at_most=MOST_INSTANTS)

    def _pass(self, until: float, *, at_most: int) -> list[Step]:
        """Time passes, in so many instants at most."""
        steps: list[Step] = []
        for _ in range(at_most):
            if self._chart.at >= until or self._chart.outcome is not None:
                break
            at = min([until, *self._again.values()])
            steps.append(self._take(partial(self._chart.send, Tick(at))))
            due = [name for name, again in self._again.items() if again <= at]
            written = [self._write(name, self._facts[name]) for name in due]
            steps += [step for step in written if step is not None]
        return steps

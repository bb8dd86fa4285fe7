# SPDX-License-Identifier: Apache-2.0
"""A run between two steps: what nothing looks at is forgotten, what waits for time waits as long as ever.

Rule: forgetting gives more runs, never fewer. A key that is forgotten can be anything when a rule looks again; only
one that what waits does not look at, being as it is, is forgotten, since its change changes nothing now.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import WAITING, GoalActivity, GoalMachine
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree import TreeActivity, limit_of
from rai_missions.engine.compiled.configuration import Plan
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState
from rai_missions.engine.semantics.hold import awake, free, is_held
from rai_missions.engine.semantics.timers import next_number
from rai_missions.engine.state import TABLE, FieldKind, RunState, Timer
from rai_missions.guards.view import View
from rai_missions.keys import Stamped
from rai_missions.prove.abstraction.activity_key import SOON, rested, timer_key
from rai_missions.prove.abstraction.alike_readings import AlikeReadings
from rai_missions.prove.abstraction.control_env import ControlEnvironment
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.nondeterminism import OpenFields, Payload
from rai_missions.prove.abstraction.open_rounds import MORE, OpenRounds, Round
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.abstraction.store import ALL_GOALS, MANY, Rivals
from rai_missions.prove.analysis.counts import Count
from rai_missions.prove.analysis.liveness import ALL, Later, LiveReads, LooksAhead
from rai_missions.prove.analysis.parts import guards_in, writes_in
from rai_missions.prove.analysis.passed_nodes import ForgetsNodes, PassedNodes
from rai_missions.states.compound import Each

__all__ = ("INDIFFERENT", "PURSUED", "Abstraction", "relink_stopped")

STOPPED = ("stopped", "again")
"""Phases of a goal whose end was asked for."""
INDIFFERENT: frozenset[FieldKind] = frozenset(("number", "past", "end", "passing"))
"""What of a run makes no difference to what can happen next."""
REMEMBERED = 4096
"""Configurations of which is remembered what they wait for."""
PURSUED = ("sent", "running")
"""The phases of a goal that its state still pursues."""


class Abstraction:
    """Brings a run to rest after each step.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        control: Who has control.
        instruments: What is measured of a step.
    """

    def __init__(self, chart: Chart, world: OpenWorld, control: ControlEnvironment, instruments: Instruments) -> None:
        self._chart, self._world, self._control, self._instruments = chart, world, control, instruments
        mission, facts, values = chart.mission, chart.robot_facts, world.values
        idle = frozenset(mission.blackboard) - values.learned.compared - world.fleeting
        self._reopened = idle & world.open_keys
        """Keys that any value does for, and that no guard looks at."""
        self.idle = idle - world.open_keys - values.learned.gone_over
        """The mission's own keys whose value makes no difference."""
        copies = {each.set for each in writes_in(mission) if each.source is not None}
        answers = {name for name, key in mission.blackboard.items() if key.source == "answer"}
        self._given = world.open_keys | world.facts | copies | answers
        """Keys that may hold a list that the mission has not written itself."""
        self._lists = {
            name: state.each.partition(".")[0]
            for _, name, state in mission.walk()
            if isinstance(state, Each) and self._is_alone(state.each)
        }
        """`each` → the key that has its list, where that can be any list, and no guard or other key has it."""
        timed = guards_in((mission, facts.succeeded, facts.failed))
        self._longest_s = max((max(each.age_s or 0.0, each.held_s) for each in timed), default=0.0)
        """The longest that any guard looks back."""
        self.saturating = values.saturating()
        """Counters → the bounds past which no guard distinguishes their values."""
        self._waiting: dict[tuple[int, ...], tuple[CompiledGuard, ...]] = {}
        triggers = {word for _, transition in mission.every_transition() for word in transition.on}
        self.live: LooksAhead = LiveReads(mission, chart.program.graph, facts, reads_all=bool(world.predicates))
        self.passed: dict[str, ForgetsNodes] = {
            name: PassedNodes(root) for _, name, state in mission.walk() if (root := state.root()) is not None
        }
        self._alike_readings = AlikeReadings(chart, world)
        self._rivals: dict[frozenset[str], Rivals] = {}
        self.names_orphans = "orphaned" in triggers
        self._names_failed_calls = "call_failed" in triggers
        rests: Mapping[FieldKind, Callable[[Any], Any]] = {
            "timers": _rest_timers,
            "deadlines": _rest_instants,
            "settling": _rest_instants,
            "deadline": _soon,
            "goals": _rest_goals,
            "activities": self._rest_activities,
            "rounds": self._rest_rounds,
            "lists": self._rest_lists,
        }
        self._rests = [(each.name, rests[each.kind]) for each in TABLE if each.kind in rests]

    def settle(self) -> None:
        """Forget what nothing looks at, and put every timer that runs to the same distance."""
        state = self._chart.state
        if state.mode == "ended":
            return
        self._control.let_go()
        _forget_ended(state)
        state.watched = self._sensed(state)
        self._forget(state)
        for name, rest in self._rests:
            if value := getattr(state, name):
                setattr(state, name, rest(value))
        self._cap(state)
        state.answer = self._read_later(state.answer)
        state.event, state.asked = {}, ""

    @property
    def restless(self) -> list[str]:
        """The states whose trees rest only because they have gone round as often as a step allows."""
        return [name for name, activity in self._chart.state.running.items() if limit_of(activity) == "writes"]

    def _is_alone(self, path: str) -> bool:
        """Whether a list can be any, and is found nowhere but there."""
        learned = self._world.values.learned
        is_open = path.partition(".")[0] in self._world.open_keys
        return is_open and len(learned.kin_of(path)) == 1 and not learned.atoms.get(path)

    # -- what is looked at ----------------------------------------------------------------------------------------

    def _sensed(self, state: RunState) -> frozenset[str]:
        """The keys that what waits for something looks at, being as it is; no other can change anything now."""
        world = self._world
        board, looked = world.board, world.board.looked
        looked.clear()
        for key, shape in world.shapes.items():
            entry = board.known(key)
            if entry is not None:
                if not isinstance(entry.value, OpenFields):  # a robot has just reported it
                    entry = Stamped(shape.fresh(entry.value), NOW)
                    board.put(key, entry)
                entry.value.looked.clear()
        waiting = list(self._watching(state))
        running = list(awake(self._chart.program, state)) if state.running and state.mode != "paused" else []
        read = frozenset[str]().union(*(machine.reads(activity) for _, machine, activity in running))
        alike = self._alike_readings.narrow(state, waiting, read)
        for condition in waiting:
            self._look(state, condition)
        for _, machine, activity in running:
            if isinstance(machine, GoalMachine) and not world.predicates:
                _sense(machine, activity, state)
            else:
                looked |= machine.reads(activity)
        sensed = frozenset(looked) & world.fleeting
        for key in alike.keys() & sensed:
            board.leave(key, alike[key])
        return sensed

    def _watching(self, state: RunState) -> Iterable[CompiledGuard]:
        """The guards that may do something without an event."""
        program = self._chart.program
        if state.mode == "paused":
            yield from (condition for _, condition in program.invariants)
            return
        if state.final is not None:
            yield from [state.final.requires] if state.final.requires is not None else []
        else:
            yield from self._eventless(state)
        for name in state.settling:
            if state.final is None and is_held(state, program.graph.nodes[name]):
                continue
            requires = program.graph.nodes[name].requires
            assert requires is not None
            yield requires
        yield from (condition for _, condition in program.invariants)

    def _eventless(self, state: RunState) -> Iterable[CompiledGuard]:
        """The guards of free states that may fire transitions without an event."""
        config = state.config
        if state.frozen:
            return _waiting(free(state, config.eventless), [node for node in config.nodes if not is_held(state, node)])
        waiting = self._waiting.get(config.key)
        if waiting is None:
            if len(self._waiting) >= REMEMBERED:
                self._waiting.clear()
            waiting = self._waiting[config.key] = tuple(_waiting(config.eventless, config.nodes))
        return waiting

    def _look(self, state: RunState, condition: CompiledGuard) -> None:
        if self._world.predicates:  # they may have another value the next time
            self._world.board.looked |= condition.reads
            return
        condition.test(state)
        for test in condition.held_guards.values():
            test(state)

    def _forget(self, state: RunState) -> None:
        world, board = self._world, self._world.board
        for key in world.fleeting - state.watched:
            board.forget(key)
        for key in world.shapes:
            entry = board.known(key)
            if entry is not None:
                for field in entry.value.keys() - entry.value.looked if not world.predicates else ():
                    del entry.value[field]
        for key in self._reopened:
            board.pop(key, None)
        for key, (low, high) in self.saturating.items():
            entry = board.known(key)
            if entry is not None and entry[0].__class__ is not Count and not low <= entry.value <= high:
                board.put(key, Stamped(min(max(entry.value, low), high), NOW))

    def _read_later(self, answer: Mapping[str, Any]) -> dict[str, Any]:
        """The parameters of the last answer that may be read before the next."""
        if not answer and not isinstance(answer, Payload):
            return {}
        wanted = self.later.answers
        every = answer.fields if isinstance(answer, Payload) else answer
        kept = {name: answer.get(name) for name in every if name in wanted or ALL in wanted}
        return {name: value for name, value in kept.items() if value is not None}

    def _rest_activities(self, running: dict[str, Any]) -> dict[str, Any]:
        machines = self._chart.program.machines
        view = self._chart.state
        return {
            name: self._without_passed(name, rested(each, machines[name], self._longest_s, view))
            for name, each in running.items()
        }

    def _rest_rounds(self, rounds: OpenRounds) -> OpenRounds:
        """Without the items that are done, and without the next one where no one can look at it before its round."""
        for name, (items, index) in list(rounds.entries()):
            left = items[index:]
            left = self._without_next(name, left)
            if left != items:
                rounds[name] = left, 0
        return rounds

    def _rest_lists(self, lists: dict[tuple[str, str], Round]) -> dict[tuple[str, str], Round]:
        return {key: (self._without_next(key[1], items[at:]), 0) for key, (items, at) in lists.items()}

    def _without_next(self, each: str, left: tuple[Any, ...]) -> tuple[Any, ...]:
        """The items that are left; without the next one where no one can look at it before its round."""
        path = self._lists.get(each)
        is_free = len(left) == 2 and path is not None and (path in self._reopened or path not in self.later.roots)
        return (left[0], MORE) if is_free else left

    def _without_passed(self, name: str, activity: Any) -> Any:
        """A machine's state without what its tree remembers of nodes that it has passed."""
        if not isinstance(activity, TreeActivity):
            return activity
        nodes = self.passed[name].forgotten(activity.tree.nodes)
        if nodes is activity.tree.nodes:
            return activity
        return activity._replace(tree=activity.tree._replace(nodes=nodes))

    # -- what there may be any number of --------------------------------------------------------------------------

    @property
    def rivals(self) -> Rivals:
        """All that makes a difference of a goal that nothing pursues any more; None where none is left."""
        starts = self.later.starts
        found = self._rivals.get(starts)
        if found is None:
            found = self._rivals[starts] = self._rivals_among(starts)
        return found

    def _rivals_among(self, starts: frozenset[str]) -> Rivals:
        conflict, known = self._chart.robot_facts.conflict, dict[str, tuple[str, ...]]()

        def rivals(goal: Goal) -> tuple[Any, ...] | None:
            if goal.action not in known:
                known[goal.action] = tuple(sorted(each for each in starts if conflict(goal.action, each)))
            found = known[goal.action]
            return (goal.phase == "orphaned", *found) if found else None

        return (lambda goal: (goal.phase == "orphaned", goal.action)) if self.names_orphans else rivals

    @property
    def pursued(self) -> list[Goal]:
        """The goals whose end a state waits for, in the order in which states are compared."""
        goals = [goal for goal in self._chart.state.goals.values() if goal.phase in PURSUED]
        return sorted(goals, key=lambda goal: (goal.owner, goal.action, goal.phase))

    @property
    def remaining(self) -> list[Goal]:
        """The goals that nothing pursues and that make a difference yet, one for all that are alike."""
        goals = [goal for goal in self._chart.state.goals.values() if goal.phase not in PURSUED]
        rivals = self.rivals
        alike = {rest: goal for goal in reversed(goals) if (rest := rivals(goal)) is not None}
        return [alike[rest] for rest in sorted(alike)]

    @property
    def later(self) -> Later:
        """What makes a difference from here on."""
        return self.live.after(self._chart.state.config)

    def _alike(self, state: RunState) -> dict[tuple[Any, ...], list[Any]]:
        """What cannot be distinguished from its like: kind and words → its keys."""
        alike: dict[tuple[Any, ...], list[Any]] = {}
        for key, timer in state.timers.items():
            if isinstance(key[1], int):
                alike.setdefault(("timer", *timer_key(key, timer)), []).append(key)
        for number, service in state.calls.items():
            alike.setdefault(("call", service), []).append(number)
        rivals = self.rivals
        for number, goal in state.goals.items():
            if goal.phase not in PURSUED and (rest := rivals(goal)) is not None:
                alike.setdefault(("goal", *rest), []).append(number)
        return alike

    def _cap(self, state: RunState) -> None:
        if not self._names_failed_calls:
            state.calls.clear()  # whatever they come to, no transition is about it
        if len(state.timers) + len(state.calls) <= MANY:
            return
        stores: Mapping[str, dict[Any, Any]] = {"timer": state.timers, "call": state.calls}
        for words, keys in self._alike(state).items():
            for key in keys[MANY:] if words[0] in stores else ():  # of goals `Stores` keeps so many
                del stores[words[0]][key]

    def make(self, happens: Callable[[], None]) -> None:
        """Let something happen; what it did can be read until the next."""
        state = self._chart.state
        self._instruments.begin_step()
        several = len(state.timers) + len(state.calls) + len(state.goals) >= MANY
        before = {words: keys for words, keys in self._alike(state).items() if len(keys) >= MANY} if several else {}
        if any(words[0] == "goal" for words in before):
            self._instruments.asked.add(ALL_GOALS)
        happens()
        if before and state.mode != "ended":
            self._replenish(state, before)

    def _replenish(self, state: RunState, before: dict[tuple[Any, ...], list[Any]]) -> None:
        """Where there were many, there may be as many still."""
        now = Counter({words: len(keys) for words, keys in self._alike(state).items()})
        for words in before:
            if now[words] == MANY - 1 and self._world.choices.choose(2):
                self._add_another(state, words)

    def _add_another(self, state: RunState, words: tuple[Any, ...]) -> None:
        key = self._alike(state)[words][0]
        if words[0] == "timer":
            state.order += 1
            state.timers["raise", state.order] = Timer(SOON, state.order, *state.timers[key][2:])
        elif words[0] == "call":
            state.calls[next_number(state)] = state.calls[key]
        else:
            number = next_number(state)
            state.goals[number] = state.goals[key]._replace(number=number)

    def lengthen(self, state: RunState, node: CompiledState, is_new: Callable[[RunState, CompiledState], bool]) -> None:
        """A list that the surroundings gave may be longer than was thought, where it has two items or more.

        Args:
            state: The run.
            node: The `each` that goes over it.
            is_new: What this round and those after it lead to may not have been tried yet.
        """
        items, index = state.rounds[node.name]
        assert isinstance(node.state, Each)
        path = node.state.each
        is_open = items[index:] == (MORE,)
        if not is_open and not (0 < index == len(items) - 1 and path.split(".")[0] in self._given):
            return
        is_first = is_new(state, node)
        if is_open:
            items = (*items[:index], self._world.item(path, is_first=is_first))
        if self._world.choices.choose(2 if is_first else 1):
            items = (*items, MORE)
            self._instruments.lengthened.add(node.name)
        state.rounds[node.name] = items, index


# -- what waits -------------------------------------------------------------------------------------------------------


def _soon(until: float) -> float:
    return SOON if until != math.inf else math.inf


def _rest_instants(instants: dict[str, float]) -> dict[str, float]:
    return {name: _soon(until) for name, until in instants.items()}


def _rest_timers(timers: dict[Any, Timer]) -> dict[Any, Timer]:
    return {key: timer if timer.due == SOON else timer._replace(due=SOON) for key, timer in timers.items()}


def _rest_goals(goals: dict[int, Goal]) -> dict[int, Goal]:
    return {
        number: goal if goal.until in (SOON, math.inf) else goal._replace(until=SOON) for number, goal in goals.items()
    }


def _waiting(chains: Plan, nodes: Iterable[CompiledState]) -> Iterator[CompiledGuard]:
    """The guards of transitions that need no event, and those of states that count for how long they have been true."""
    yield from (each.condition for chain in chains for each in chain if each.condition is not None)
    inside = sorted(nodes, key=lambda node: node.index)
    conditions = (transition.condition for node in inside for transition in node.transitions)
    yield from (condition for condition in conditions if condition is not None and condition.held_guards)


def _sense(machine: GoalMachine, activity: GoalActivity, view: View) -> None:
    """Look as the machine does while it waits."""
    if activity.phase == "settling" and machine.achieved is not None:
        machine.achieved(view)
    elif activity.phase == "running":
        for test in (machine.succeeded, machine.failed):
            if test is not None:
                test(view)


def relink_stopped(state: RunState) -> None:
    """Have what was stopped know its goal, which is another's number where alike goals are kept once."""
    for name, activity in _stopped(state):
        numbers = [each.number for each in state.goals.values() if each.owner == name and each.phase not in PURSUED]
        if numbers:
            state.running[name] = activity._replace(number=max(numbers))


def _forget_ended(state: RunState) -> None:
    """What was stopped and whose goal has ended has nothing left to wait for: it is as if it had never been sent."""
    for name, activity in _stopped(state):
        if activity.number in state.goals:
            continue
        if activity.phase == "stopped":
            del state.running[name]
        else:
            state.running[name] = WAITING


def _stopped(state: RunState) -> list[tuple[str, GoalActivity]]:
    """What waits for the end of a goal that a pause or a change of control has stopped."""
    running = state.running.items()
    return [(name, each) for name, each in running if isinstance(each, GoalActivity) and each.phase in STOPPED]

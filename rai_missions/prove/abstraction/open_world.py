# SPDX-License-Identifier: Apache-2.0
"""What the surroundings of a mission can be: keys, fields, lists and predicates have any value when a rule looks.

Rule: nothing is chosen before a rule looks at it; what is assumed of the robot is listed here, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.computing import ComputedResult
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState
from rai_missions.guards.view import Site, Truth, as_counted
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction.nondeterminism import Choices, OpenBoard, OpenFields
from rai_missions.prove.abstraction.open_items import OpenItems, open_lists
from rai_missions.prove.abstraction.open_rounds import OpenRounds, list_name
from rai_missions.prove.abstraction.open_sight import OpenSight, Sights
from rai_missions.prove.analysis.comparisons import Comparisons
from rai_missions.prove.analysis.liveness import LooksAhead
from rai_missions.prove.analysis.parts import guards_in, parts, writes_in
from rai_missions.prove.analysis.questions import questions
from rai_missions.prove.analysis.representatives import SCALARS, Values
from rai_missions.states.action import Action
from rai_missions.states.call import Call
from rai_missions.states.tree.leaves import ActionLeaf, CallLeaf

__all__ = ("NOW", "OpenWorld", "predicates_in")

NOW = 1e6
"""The instant at which everything happens."""
PREDICATE = (True, False, None)


def predicates_in(mission: Mission, choices: Choices) -> dict[str, Callable[..., Truth]]:
    """The predicates of the user's program that a mission names; each has any value whenever it is asked."""

    def predicate(known: Any, **arguments: Any) -> Truth:
        value: Truth = choices.pick(PREDICATE)
        return value

    return dict.fromkeys(sorted(name for each in guards_in(mission) for name in each.predicates()), predicate)


class OpenWorld:
    """A blackboard on which robot and arguments can be anything.

    Args:
        chart: The mission, before the start.
        choices: Where what is left open is chosen.
    """

    def __init__(self, chart: Chart, choices: Choices) -> None:
        mission, state = chart.mission, chart.state
        self._chart, self.choices = chart, choices
        self.predicates = frozenset(chart.program.named)
        self.values = Values(mission, chart.robot_facts)
        keys = mission.blackboard
        self.fleeting = frozenset(name for name, key in keys.items() if key.source == "robot")
        """The keys that the robot reports."""
        self.passing = frozenset(name for name, key in keys.items() if key.must_recur)
        """The keys that the robot must report again and again."""
        self.open_keys = self.fleeting | {name for name, key in keys.items() if key.source == "argument"}
        """The keys that can have any value at the start."""
        self.fading = frozenset(name for name, key in keys.items() if key.max_age_s is not None)
        """The keys that may go stale, whichever their source."""
        self.own_keys = frozenset(keys) - self.open_keys
        """The keys that only the mission, answers and results write."""
        self.own_fade = not self.own_keys.isdisjoint(self.fading)
        """Some of them grow stale."""
        self.shapes = {name: shape for name in sorted(self.fleeting) if (shape := self._shape(name)) is not None}
        """Objects that are known field by field, or question by question."""
        self.board = OpenBoard(self.open_keys, self._value, NOW)
        for name, entry in state.board.items():
            if name not in self.open_keys:
                self.board[name] = entry
        self.rounds = OpenRounds(self.board.looked)
        lists = {list_name(name) for name, node in chart.program.graph.nodes.items() if node.is_each}
        self.stored = self.own_keys | lists
        """What is apart from the rest of a state: the own keys, and the lists that states go over."""
        state.board, state.rounds, state.at = self.board, self.rounds, NOW
        self.items = self._open_items()
        """The items of lists that are left open."""
        self.facts = self._facts()
        """The keys that rest on what the robot, its servers and services report."""
        self._assume()
        self.chosen = {} if self.is_open else self._distinguished()
        """Reported scalar → the values of which a look finds one: of those that are alike the first."""

    @property
    def is_open(self) -> bool:
        """Others may look at a value in their own way: the user's predicates, and kinds of other packages."""
        return bool(self.predicates or self._chart.mission.uses)

    def _facts(self) -> frozenset[str]:
        mission = self._chart.mission
        kinds: tuple[type[Any], ...] = (Action, Call, ActionLeaf, CallLeaf)
        with_results: Iterator[Any] = (part for kind in kinds for part in parts(mission, kind))
        facts = set(self.fleeting | {key for part in with_results for key in part.result})
        copies = {(e.set, e.source.split(".")[0]) for e in writes_in(mission) if e.source is not None}
        while more := {name for name, source in copies if source in facts} - facts:
            facts |= more
        return frozenset(facts)

    # -- what is free ---------------------------------------------------------------------------------------------

    def _value(self, key: str) -> Any:
        if key in self.board.among:
            return self.choices.pick(self.board.among.pop(key))
        shape = self.shapes.get(key)
        if shape is not None:
            can_lack = None in self.values.of(key)
            return None if can_lack and self.choices.choose(2) == 0 else shape.fresh({})
        if self._chart.mission.blackboard[key].type == "list":
            return self._list(key)
        return self.choices.pick(self.distinct(key))

    def distinct(self, key: str) -> Sequence[Any]:
        """The values of which a look finds one."""
        return self.chosen.get(key) or self.values.of(key)

    def _distinguished(self) -> dict[str, tuple[Any, ...]]:
        """The values of keys, of those that are alike to all that is asked of a key the first alone.

        Either of two such values leads to the same steps as long as it lasts, and any other can follow on both.
        """
        keys = self._chart.mission.blackboard
        scalars = {key: self.values.of(key) for key in self.fleeting if keys[key].type in SCALARS}
        return self._alike(scalars, lambda key, value: {key: Stamped(value, NOW)})

    def _alike(
        self, values: Mapping[str, Sequence[Any]], board: Callable[[str, Any], dict[str, Any]]
    ) -> dict[str, tuple[Any, ...]]:
        """The values of each path, of those that are alike to all that is asked of it the first alone.

        Args:
            values: Path → all values; None is unknown.
            board: A blackboard on which a path has a value.
        """
        mission, state, facts = self._chart.mission, self._chart.state, self._chart.program.robot_facts
        found = {}
        for path, asked in questions((mission, facts.succeeded, facts.failed), values).items():
            tests = [(each.compile(Site("", mission.blackboard)), counts) for each, counts in asked]
            first = dict[Any, Any]()
            for value in values[path]:
                state.board = {} if value is None else board(path, value)
                first.setdefault(tuple([as_counted(test(state), counts) for test, counts in tests]), value)
            found[path] = tuple(first.values())
        state.board = self.board
        return found

    def _list(self, key: str) -> list[Any] | None:
        """A list of no, one or two items, each anything; `Abstraction` has longer ones."""
        many = self.choices.pick((0, 1, 2, None) if self.values.can_lack(key) else (0, 1, 2))
        return None if many is None else [self.item(key) for _ in range(many)]

    def item(self, path: str, *, is_first: bool = True) -> Any:
        """Any item of a list; the first alternative alone where another way tries the others."""
        shape = self._item_shapes.get(path)
        if shape is not None:
            return shape.fresh({} if is_first else dict.fromkeys(shape.fields))
        known = self.values.item(path)
        return known[self.choices.choose(len(known) if is_first else 1)]

    def _open_items(self) -> OpenItems:
        """The items that are left open field by field; none where others look at values in their own way."""
        mission, values = self._chart.mission, self.values
        lists = {} if self.is_open or self.own_fade else open_lists(mission, values.learned)
        shapes = {
            state.item: OpenFields(
                values.learned.within(state.item), self._alike_fields(state.item).__getitem__, self.choices.pick
            )
            for state in lists.values()
        }
        self._item_shapes = {state.each: shapes[state.item] for state in lists.values()}
        self.board.share(shapes)
        return OpenItems(shapes, lists, self.board)

    def _alike_fields(self, item: str) -> dict[str, tuple[Any, ...]]:
        """The values of the fields of a list's items, of those that are alike to all that is asked the first alone."""
        declared = self._chart.mission.blackboard[item].fields or {}
        every = {field: self.values.part(item, field) for field in self.values.learned.within(item)}
        scalars = {f"{item}.{field}": values for field, values in every.items() if declared.get(field) in SCALARS}

        def board(path: str, value: Any) -> dict[str, Any]:
            return {item: Stamped({path.partition(".")[2]: value}, NOW)}

        alike = {path.partition(".")[2]: values for path, values in self._alike(scalars, board).items()}
        return {**every, **alike}

    def _shape(self, key: str) -> OpenFields | None:
        if self.values.is_sight(key):
            return OpenSight(Sights([each for each in self.values.of(key) if each is not None], self.choices.pick))
        if fields := self.values.shape(key):
            return OpenFields(fields, partial(self.values.part, key), self.choices.pick)
        return None

    def anything_of(self, node: CompiledState, into: str, live: LooksAhead) -> Callable[..., ComputedResult]:
        """What a state may work out: any of its outcomes, with any value that can come with it.

        Of values that are the same in all that may be read of them once the state has ended so, one represents all:
        the step, and every later one, reads the same of each, and differs in nothing else. Where no guard looks into
        what an outcome comes with, the value that has it, and nothing in it, represents all.
        """
        state, fitting = node.state, dict[str, list[Any]]()
        assert state is not None
        outcomes = sorted(state.computed())
        known = [value for value in self.values.of(into) if value is not None]
        for outcome in outcomes:
            later = live.with_outcome(node, outcome, outcomes)
            examples = state.computed_examples(outcome)
            can_come = [
                value for value in known if any(self._is_like(into, value, each) for each in examples or [value])
            ]
            can_come = can_come or [max(known, key=len, default={})]
            fitting[outcome] = list({repr(later.of(into, value)): value for value in reversed(can_come)}.values())[::-1]

        def compute(*given: Any) -> ComputedResult:
            outcome = self.choices.pick(tuple(fitting))
            return ComputedResult(outcome, self.choices.pick(fitting[outcome]))

        return compute

    def _is_like(self, path: str, value: Mapping[str, Any], example: Mapping[str, Any]) -> bool:
        """Whether the fields that anybody looks at are known in an object if they are in another."""
        learned = self.values.learned
        for field in learned.within(path):
            inner, one, other = f"{path}.{field}", value.get(field), example.get(field)
            is_known = bool(one) if learned.is_goal(inner) else one is not None
            if is_known != (other is not None):
                return False
            if isinstance(one, Mapping) and isinstance(other, Mapping) and not self._is_like(inner, one, other):
                return False
        return True

    # -- what is assumed ------------------------------------------------------------------------------------------

    def _assume(self) -> None:
        """Set the invariants aside that no rule can keep or break: what they speak of is the robot's affair."""
        program = self._chart.program
        self.assumed = {name: each for name, each in program.invariants if self._speaks_of_the_robot_alone(each)}
        """Invariants that are taken to hold."""
        program.invariants = tuple((name, each) for name, each in program.invariants if name not in self.assumed)
        kept = {name: program.mission.invariants[name] for name, _ in program.invariants}
        mission = program.mission.model_copy(update={"invariants": kept})
        looked_at = Comparisons(mission, program.robot_facts).compared
        self._doubted = [each for each in self.assumed.values() if self._can_be_broken(each, looked_at)]

    def _can_be_broken(self, condition: CompiledGuard, looked_at: frozenset[str]) -> bool:
        """Whether it must be asked for in each state; one over a single key narrows down that key's values instead."""
        if condition.reads.isdisjoint(looked_at) and "*" not in condition.reads:
            return False
        key = next(iter(condition.reads))
        if len(condition.reads) > 1 or key not in self.fleeting or key in self.shapes or condition.held_guards:
            return True
        self.values.narrow(key, lambda value: self._allows(condition, key, value))
        self._chart.state.board = self.board
        return False

    def _allows(self, condition: CompiledGuard, key: str, value: Any) -> bool:
        state = self._chart.state
        state.board = {} if value is None else {key: Stamped(value, NOW)}
        return condition.test(state) is not False

    def _speaks_of_the_robot_alone(self, condition: CompiledGuard) -> bool:
        of_the_run = any(each.age_s is not None or each.states() for each in condition.guard.walk())
        return not of_the_run and bool(condition.reads) and condition.reads <= self.fleeting | {"*"}

    @property
    def doubts(self) -> bool:
        """Whether each state is asked if what is assumed of the robot is true there."""
        return bool(self._doubted)

    @property
    def is_possible(self) -> bool:
        """Nothing that is assumed of the robot is false."""
        return all(each.test(self._chart.state) is not False for each in self._doubted)

    def own(self) -> dict[str, Any]:
        """What the mission's own keys hold, as far as it is known."""
        return {key: entry for key, entry in self.board.entries() if key in self.own_keys}

    # -- what success rests on ------------------------------------------------------------------------------------

    @property
    def asked_at_the_end(self) -> frozenset[str]:
        """The keys that decide whether a success counts."""
        final = self._chart.state.final
        return final.requires.reads if final is not None and final.requires is not None else frozenset()

    @property
    def rests_on_facts(self) -> bool:
        """Whether the mission's success would not have counted had robot, servers and services reported nothing."""
        state = self._chart.state
        final = state.final
        if final is None or final.requires is None:
            return False
        state.board = OpenBoard((), self._value, NOW)
        state.board.refill({key: entry for key, entry in self.board.entries() if key not in self.facts})
        try:
            return final.requires.test(state) is not True
        finally:
            state.board = self.board

# SPDX-License-Identifier: Apache-2.0
"""The chart that runs missions, on a blackboard that can say anything, with what its guards say taken down.

Rule: what a step does is the chart's own doing; here is only what it is told, and what is heard of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import GoalMachine
from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.activities.decision import DecisionMachine
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import TreeMachine
from rai_missions.engine.nodes import Condition, Node
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.guards.elapsed import Elapsed
from rai_missions.guards.guard import Test, Truth
from rai_missions.guards.in_state import In
from rai_missions.guards.named import Named
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.prove.comparisons import Comparisons
from rai_missions.prove.nondeterminism import Choices, OpenBoard, OpenFields
from rai_missions.prove.parts import guards_in, parts, writes_in
from rai_missions.prove.representatives import Values
from rai_missions.states.action import Action
from rai_missions.states.call import Call
from rai_missions.states.tree.leaves import ActionLeaf, CallLeaf

__all__ = ("NOW", "InstrumentedChart")

NOW = 1e6
"""The instant at which everything happens."""
PREDICATE = (True, False, None)


class InstrumentedChart(Chart):
    """A chart whose surroundings can be anything.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees.
        terms: What is known of the robot.
    """

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None) -> None:
        self.choices = Choices()
        self.predicates = frozenset(each.named for each in guards_in(mission) if isinstance(each, Named))
        super().__init__(mission, ticker, terms=terms, named=dict.fromkeys(self.predicates, self._never_asked))
        self.values = Values(mission, self.terms)
        self.seen: dict[str, set[Truth]] = {}
        """The place of a guard that makes something possible → what it has said."""
        self.ticks = 0
        """Ticks of trees in this step."""
        self.turned: set[str] = set()
        """The states of whose tree a loop's round that has taken time has ended in this step."""
        self.at_once: set[str] = set()
        """The states of whose tree a loop's round has ever ended as soon as it began."""
        self.begun: dict[str, set[str]] = {}
        """State → the paths of what has begun in its tree in this step."""
        self.answered: set[tuple[str, str]] = set()
        """Who asks, and an option that was taken there."""
        self.schemas: dict[tuple[str, str], Mapping[str, Any]] = {}
        """Who asks, and an option → what its parameters must be."""
        keys = mission.blackboard
        self._fleeting = frozenset(name for name, key in keys.items() if key.source == "robot")
        self.open_keys = self._fleeting | {name for name, key in keys.items() if key.source == "argument"}
        """The keys that can have any value at the start."""
        self._shapes = {
            name: OpenFields(fields, partial(self._part, name))
            for name in self._fleeting if (fields := self.values.shape(name))
        }  # fmt: skip
        """Objects that are known field by field."""
        self._wavering: dict[str, Any] = {}
        """Key → what it was until this instant, at which it may go stale."""
        self.board = OpenBoard(self.open_keys, self._value, NOW)
        for name, entry in self.view.board.items():
            if name not in self.open_keys:
                self.board[name] = entry
        self.view.board, self.view.at = self.board, NOW
        self.facts = self._facts()
        """The keys that rest on what the robot, its servers and services say."""
        self._assume()
        self._watch_finals()

    def _facts(self) -> frozenset[str]:
        results = {key for part in self._parts_with_results() for key in part.result}
        facts = set(self._fleeting | results)
        copies = {(e.set, e.source.split(".")[0]) for e in writes_in(self.mission) if e.source is not None}
        while more := {name for name, source in copies if source in facts} - facts:
            facts |= more
        return frozenset(facts)

    def _parts_with_results(self) -> Iterator[Any]:
        kinds: tuple[type[Any], ...] = (Action, Call, ActionLeaf, CallLeaf)
        for kind in kinds:
            yield from parts(self.mission, kind)

    # -- what is free ---------------------------------------------------------------------------------------------

    def _value(self, key: str) -> Any:
        if key in self._wavering:
            return self.choices.pick((self._wavering.pop(key), None))
        shape = self._shapes.get(key)
        if shape is not None:
            can_lack = None in self.values.of(key)
            return None if can_lack and self.choices.choose(2) == 0 else shape.fresh({})
        if self.mission.blackboard[key].type == "list":
            return self._list(key)
        return self.choices.pick(self.values.of(key))

    def _list(self, key: str) -> list[Any] | None:
        """Of no, one or two items, each anything; `Resting` has longer ones."""
        many = self.choices.pick((0, 1, 2, None) if None in self.values.of(key) else (0, 1, 2))
        return None if many is None else [self.choices.pick(self.values.item(key)) for _ in range(many)]

    def _part(self, key: str, field: str) -> Any:
        return self.choices.pick(self.values.part(key, field))

    @staticmethod
    def _never_asked(known: Mapping[str, Any], **arguments: Any) -> Truth:
        raise AssertionError("predicates are chosen in `ask_named`")

    def ask_named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        value: Truth = self.choices.pick(PREDICATE)
        self.looked.append((f"named:{name}", value))
        return value

    # -- what is assumed ------------------------------------------------------------------------------------------

    def _assume(self) -> None:
        """Set the invariants aside that no rule can keep or break: what they speak of is the robot's affair."""
        self.assumed = {name: each for name, each in self._invariants if self._speaks_of_the_robot_alone(each)}
        """Invariants that are taken to hold."""
        self._invariants = tuple((name, each) for name, each in self._invariants if name not in self.assumed)
        mission = self.mission.model_copy(
            update={"invariants": {n: self.mission.invariants[n] for n, _ in self._invariants}}
        )
        looked_at = Comparisons(mission, self.terms).compared
        self._doubted = [each for each in self.assumed.values() if self._can_be_broken(each, looked_at)]

    def _can_be_broken(self, condition: Condition, looked_at: frozenset[str]) -> bool:
        """Whether it must be asked for in each state; one over a single key narrows down that key's values instead."""
        if condition.reads.isdisjoint(looked_at) and "*" not in condition.reads:
            return False
        key = next(iter(condition.reads))
        if len(condition.reads) > 1 or key not in self._fleeting or key in self._shapes or condition.holds:
            return True
        self.values.narrow(key, lambda value: self._allows(condition, key, value))
        self.view.board = self.board
        return False

    def _allows(self, condition: Condition, key: str, value: Any) -> bool:
        self.view.board = {} if value is None else {key: Stamped(value, NOW)}
        return condition.test(self.view) is not False

    def _speaks_of_the_robot_alone(self, condition: Condition) -> bool:
        of_the_run = any(isinstance(each, In | Elapsed) for each in condition.guard.walk())
        return not of_the_run and bool(condition.reads) and condition.reads <= self._fleeting | {"*"}

    @property
    def is_possible(self) -> bool:
        """Nothing that is assumed of the robot is false."""
        return all(each.test(self.view) is not False for each in self._doubted)

    @property
    def asked_at_the_end(self) -> frozenset[str]:
        """The keys that say whether a success counts."""
        final = self._final
        return final.requires.reads if final is not None and final.requires is not None else frozenset()

    @property
    def rests_on_facts(self) -> bool:
        """Whether the mission's success would not have counted had robot, servers and services said nothing."""
        final = self._final
        if final is None or final.requires is None:
            return False
        known = {key: entry for key, entry in self.board.entries() if key not in self.facts}
        silent = OpenBoard((), self._value, NOW)
        silent.refill(known)
        self.view.board = silent
        try:
            return final.requires.test(self.view) is not True
        finally:
            self.view.board = self.board

    # -- what is heard of it --------------------------------------------------------------------------------------

    def _watch_finals(self) -> None:
        for node in self._graph.order:
            if node.requires is not None:
                test = self._watched(node.requires.place, node.requires.test)
                node.requires = node.requires._replace(test=test)

    def _watched(self, place: str, test: Test) -> Test:
        seen = self.seen.setdefault(place, set())

        def watched(view: Any) -> Truth:
            value = test(view)
            seen.add(value)
            return value

        return watched

    def _machine(self, node: Node) -> Machine | None:
        is_new = node.name not in self._machines
        machine = super()._machine(node)
        if is_new and machine is not None:
            self._watch(machine, node.place)
        return machine

    def _watch(self, machine: Any, place: str) -> None:
        if isinstance(machine, DecisionMachine):
            self._watch_question(machine, place)
        elif isinstance(machine, GoalMachine) and machine.achieved is not None:
            machine.achieved = self._watched(f"{place}/achieved", machine.achieved)
        elif isinstance(machine, TreeMachine):
            self._count(machine)
            for path, limb in machine.limbs.items():
                self._watch(limb.machine, f"{place}/tree/{path}")

    def _count(self, machine: TreeMachine) -> None:
        """Have the ticks of a tree counted, and the rounds of its loops noticed."""
        tick = machine.ticker.tick

        def counted(*given: Any) -> Any:
            self.ticks += 1
            ticked = tick(*given)
            begun = [path for path, call, _ in ticked.trace if call == "initialise"]
            self.begun.setdefault(machine.owner, set()).update(begun)
            if any(not each.at_once for each in ticked.rounds):
                self.turned.add(machine.owner)
            if any(each.at_once for each in ticked.rounds):
                self.at_once.add(machine.owner)
            return ticked

        machine.ticker.tick = counted  # type: ignore[method-assign,assignment]

    def _watch_question(self, machine: DecisionMachine, place: str) -> None:
        machine.begin = self._taking(machine.owner, machine.begin)  # type: ignore[method-assign]
        machine.hear = self._taking(machine.owner, machine.hear)  # type: ignore[method-assign]
        machine.shown = []  # what a question shows makes no difference to what becomes of it
        machine.asked = self._without_schemas(machine.owner, machine.asked)
        where = f"{place}/decision/options"
        machine.tests = {name: self._watched(f"{where}/{name}/when", test) for name, test in machine.tests.items()}

    def _without_schemas(self, owner: str, asked: Any) -> Any:
        """A question that takes whatever parameters are made for it."""
        options = {}
        for name, option in asked.options.items():
            if option.parameters is not None:
                self.schemas[owner, name] = option.parameters
            options[name] = option.model_copy(update={"parameters": None if option.parameters is None else {}})
        return asked.model_copy(update={"options": options})

    def _taking(self, owner: str, make: Callable[..., Any]) -> Callable[..., Any]:
        def made(*given: Any, **words: Any) -> Any:
            turn = make(*given, **words)
            if turn is not None and turn.outcome is not None:
                self.answered.add((owner, turn.outcome.name))
            return turn

        return made

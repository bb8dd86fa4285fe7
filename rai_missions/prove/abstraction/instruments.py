# SPDX-License-Identifier: Apache-2.0
"""What a proof measures while a mission runs: the values of guards, which options are taken, what trees do in a step.

Rule: nothing here changes what a step does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.activities.action import GoalActivity, GoalMachine
from rai_missions.engine.activities.decision import DecisionMachine
from rai_missions.engine.activities.tree import TreeMachine
from rai_missions.engine.compiled.program import Program
from rai_missions.event import Event
from rai_missions.guards.view import Test, Truth
from rai_missions.prove.abstraction.store import ALL_GOALS, ObstructionQuery

__all__ = ("Instruments",)


class Instruments:
    """Attached to finals at once, and to each machine as it is compiled.

    Args:
        is_foreign: The mission has activities of other packages, which may look at any goal.
    """

    def __init__(self, *, is_foreign: bool = False) -> None:
        self._is_foreign = is_foreign
        self.seen: dict[str, set[Truth]] = {}
        """The place of a guard that makes something possible → its values so far."""
        self.answered: set[tuple[str, str]] = set()
        """Who asks, and an option that was taken there."""
        self.schemas: dict[tuple[str, str], Mapping[str, Any]] = {}
        """Who asks, and an option → what its parameters must be."""
        self.at_once: set[str] = set()
        """The states of whose tree a loop's round has ever ended as soon as it began."""
        self.restarted: set[str] = set()
        """The states whose tree has ever begun twice in one step."""
        self.ticks = 0
        """Ticks of trees in this step."""
        self.turned: set[str] = set()
        """The states of whose tree a loop's round that has taken time has ended in this step."""
        self.begun: dict[str, set[str]] = {}
        """State → the paths of the waits and timeouts that have begun in its tree in this step."""
        self.has_started = False
        """A leaf of a tree was started in this step."""
        self.asked: set[Any] = set()
        """What was asked of the goals in this step that nothing pursues: see `Stores.question`."""
        self.lengthened: set[str] = set()
        """The states whose list was found to have another item in this step."""
        self.is_long = False
        """It was looked whether this step goes round: the values of keys were compared."""

    def begin_step(self) -> None:
        """Forget what the last step did."""
        self.ticks, self.turned, self.begun, self.asked, self.is_long = 0, set(), {}, set(), False
        self.lengthened, self.has_started = set(), False

    def compare_values(self) -> None:
        """Look from now on whether this step goes round."""
        self.is_long = True

    def watch_finals(self, program: Program) -> None:
        """Note the values of the `requires` of finals."""
        for node in program.graph.order:
            if node.requires is not None:
                test = self._noting(node.requires.place, node.requires.test)
                node.requires = node.requires._replace(test=test)

    def watch(self, machine: Any, place: str) -> None:
        """Note what a machine does."""
        if isinstance(machine, DecisionMachine):
            self._watch_question(machine, place)
        elif isinstance(machine, GoalMachine):
            self._watch_starts(machine, ObstructionQuery(machine.definition.action))
            if machine.achieved is not None:
                machine.achieved = self._noting(f"{place}/achieved", machine.achieved)
        elif isinstance(machine, TreeMachine):
            self._count(machine)
            for path, leaf_machine in machine.leaf_machines.items():
                self.watch(leaf_machine.machine, f"{place}/tree/{path}")
        elif self._is_foreign:
            self._watch_starts(machine, ALL_GOALS)

    def _noting(self, place: str, test: Test) -> Test:
        seen = self.seen.setdefault(place, set())

        def noting(view: Any) -> Truth:
            value = test(view)
            seen.add(value)
            return value

        return noting

    def _count(self, machine: TreeMachine) -> None:
        """Count the ticks of a tree, and note the rounds of its loops."""
        tick = machine.ticker.tick

        def counted(*given: Any) -> Any:
            self.ticks += 1
            ticked = tick(*given[:4])  # a proof changes what is known in any way, so that every tick looks at all
            self.begun.setdefault(machine.owner, set()).update(ticked.waits)
            self.has_started |= bool(ticked.started)
            if any(not each.at_once for each in ticked.rounds):
                self.turned.add(machine.owner)
            if any(each.at_once for each in ticked.rounds):
                self.at_once.add(machine.owner)
            return ticked

        begin = machine.begin

        def beginning(host: Any) -> Any:
            if machine.owner in host.view.draft.tree_rounds:
                self.restarted.add(machine.owner)
            return begin(host)

        machine.begin = beginning  # type: ignore[method-assign]
        machine.ticker.tick = counted  # type: ignore[method-assign,assignment]

    def _watch_starts(self, machine: Any, asked: Any) -> None:
        """Note what is asked of the goals that nothing pursues before another is started."""
        begin, receive = machine.begin, machine.receive

        def beginning(host: Any) -> Any:
            self.asked.add(asked)
            return begin(host)

        def receiving(state: Any, event: Event, host: Any) -> Any:
            if not isinstance(state, GoalActivity) or state.phase in ("waiting", "again"):
                self.asked.add(asked)
            return receive(state, event, host)

        machine.begin, machine.receive = beginning, receiving

    def _watch_question(self, machine: DecisionMachine, place: str) -> None:
        machine.begin = self._taking(machine.owner, machine.begin)  # type: ignore[method-assign]
        machine.receive = self._taking(machine.owner, machine.receive)  # type: ignore[method-assign]
        machine.shown = []  # what a question shows makes no difference to what becomes of it
        machine.asked = self._without_schemas(machine.owner, machine.asked)
        where = f"{place}/decision/options"
        machine.tests = {name: self._noting(f"{where}/{name}/when", test) for name, test in machine.tests.items()}

    def _without_schemas(self, owner: str, asked: Any) -> Any:
        """A question that takes whatever parameters are made for it."""
        options = {}
        for name, option in asked.options.items():
            if option.parameters is not None:
                self.schemas[owner, name] = option.parameters
            options[name] = option.model_copy(update={"parameters": None if option.parameters is None else {}})
        return asked.model_copy(update={"options": options})

    def _taking(self, owner: str, make: Callable[..., Any]) -> Callable[..., Any]:
        def taking(*given: Any, **words: Any) -> Any:
            turn = make(*given, **words)
            if turn is not None and turn.outcome is not None:
                self.answered.add((owner, turn.outcome.name))
            return turn

        return taking

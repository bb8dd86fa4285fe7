# SPDX-License-Identifier: Apache-2.0
"""A mission compiled, with all that does not change while it runs.

Rule: what changes while a mission runs is in `RunState`; every function of the engine is one over the two.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.activities.factory import Bench, machine_of
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.compiled.graph import Graph
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState, Content
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import UsageError
from rai_missions.guards.view import Truth
from rai_missions.mission.mission import Mission

__all__ = ("Named", "Program")

Named = Mapping[str, Callable[..., Truth]]
"""Predicates of the user's program by name; each gets the blackboard's fresh values and the guard's `with`."""


class Program:
    """A mission, compiled.

    Args:
        mission: One that `check` finds no fault in.
        content: How effects, the entry of a list and of a final are compiled.
        ticker: Who ticks trees, if not as compiled here.
        has_trees: Whether a state of it runs a tree.
        robot_facts: What is known of the robot.
        named: The predicates that `{"named": …}` guards name.
        surroundings: What is left open, and who watches.

    Raises:
        UsageError: The mission names a predicate that was not given.
    """

    __slots__ = (
        "declared", "graph", "has_trees", "held_in_invariants", "invariants", "keys", "machines", "mission", "named",
        "robot_facts", "surroundings", "ticker",
    )  # fmt: skip

    def __init__(
        self,
        mission: Mission,
        content: Content,
        ticker: Trees | None = None,
        *,
        has_trees: bool,
        robot_facts: RobotFacts | None = None,
        named: Named | None = None,
        surroundings: Surroundings | None = None,
    ) -> None:
        self.mission, self.keys = mission, mission.blackboard
        self.ticker: Trees = ticker if ticker is not None else CompiledTrees()
        self.robot_facts = robot_facts if robot_facts is not None else RobotFacts()
        self.surroundings = surroundings if surroundings is not None else Surroundings()
        self.has_trees = has_trees
        self.graph = Graph(mission, content)
        asked = mission.predicates() if named else ()
        self.named: Named = {name: each for name, each in (named or {}).items() if name in asked}
        if absent := sorted(self.graph.named - self.named.keys()):
            sentence = f"the mission names predicates that were not given: {', '.join(absent)}"
            raise UsageError(f"{sentence}; give named={{…}}, on the command line --guards FILE.py")
        self.declared = frozenset(mission.events)
        self.machines: dict[str, Machine | None] = {}
        self.invariants: tuple[tuple[str, CompiledGuard], ...] = tuple(self.graph.invariants.items())
        self.held_in_invariants = {
            memory: test for _, each in self.invariants for memory, test in each.held_guards.items()
        }

    def machine(self, node: CompiledState) -> Machine | None:
        """The machine of a state's activity; None for a state that runs nothing."""
        if node.name not in self.machines:
            assert node.state is not None
            made_at = self.surroundings.site
            bench = Bench(node.name, node.name, node.place, self.keys, self.robot_facts, self.ticker, made_at)
            made = machine_of(node.state, bench)
            self.machines[node.name] = self.surroundings.machine(node, made) if made is not None else None
        return self.machines[node.name]

# SPDX-License-Identifier: Apache-2.0
"""Which machine runs which kind of state, compiled once a mission."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.action import GoalMachine
from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.activities.behaviour import BehaviourMachine
from rai_missions.engine.activities.call import CallMachine
from rai_missions.engine.activities.decision import DecisionMachine
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree import LeafMachine, TreeMachine
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.errors import UsageError
from rai_missions.guards.guard import Site
from rai_missions.keys import Key
from rai_missions.states.action import Action
from rai_missions.states.call import Call
from rai_missions.states.decision import Decision
from rai_missions.states.state import State
from rai_missions.states.tree import ActionLeaf, BehaviourLeaf, CallLeaf, DecisionLeaf, Tree, TreeNode, tree_paths

__all__ = ("machine_of",)


class _Bench:
    """What a machine is made of."""

    def __init__(self, keys: Mapping[str, Key], terms: RobotFacts) -> None:
        self.keys, self.terms = keys, terms

    def pursuit(self, definition: Any, owner: str, place: str, state: str) -> Machine:
        succeeded, failed = self.terms.succeeded.get(definition.action), self.terms.failed.get(definition.action)
        site = Site(f"{place}/achieved", self.keys, state)
        return GoalMachine(definition, owner, site, succeeded=succeeded, failed=failed)

    def leaf(self, node: TreeNode, owner: str, place: str, state: str) -> LeafMachine | None:
        if isinstance(node, ActionLeaf):
            return LeafMachine(self.pursuit(node, owner, place, state), node.timeout_s)
        if isinstance(node, CallLeaf):
            return LeafMachine(CallMachine(node, owner, Site(place, self.keys, state)), node.timeout_s)
        if isinstance(node, DecisionLeaf):
            return LeafMachine(DecisionMachine(node.decision, owner, Site(f"{place}/decision", self.keys, state)), None)
        if isinstance(node, BehaviourLeaf):
            return LeafMachine(BehaviourMachine(owner), None)
        return None


def machine_of(
    state: State, name: str, place: str, *, keys: Mapping[str, Key], terms: RobotFacts, trees: Trees | None
) -> Machine | None:
    """The machine of a state's activity; None for a state that runs nothing.

    Raises:
        UsageError: The state runs a tree and nobody was given who ticks trees.
    """
    bench = _Bench(keys, terms)
    if isinstance(state, Action):
        return bench.pursuit(state, name, place, name)
    if isinstance(state, Call):
        return CallMachine(state, name, Site(place, keys, name))
    if isinstance(state, Decision):
        return DecisionMachine(state.decision, name, Site(f"{place}/decision", keys, name))
    if not isinstance(state, Tree):
        return None
    if trees is None:
        raise UsageError(f"state '{name}' runs a tree; give the chart a ticker: Chart(mission, ticker=PyTrees())")
    limbs: dict[str, LeafMachine] = {}
    for path, node in tree_paths(state.tree):
        limb = bench.leaf(node, f"{name}#{path}", f"{place}/tree/{path}".rstrip("/"), name)
        if limb is not None:
            limbs[path] = limb
    return TreeMachine(trees.compile(state.tree, f"{place}/tree", keys, name), limbs, name)

# SPDX-License-Identifier: Apache-2.0
"""Makes the live nodes of a tree.

Rule: how a kind of node is compiled is in `MAKERS` and nowhere else; what it then does is in its class.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.trees import leaves
from rai_missions.engine.trees.composites import CompiledSelector, CompiledSequence
from rai_missions.engine.trees.decorators import (
    REPORTS,
    CompiledConverter,
    CompiledCount,
    CompiledEternalGuard,
    CompiledLoop,
    CompiledOneShot,
    CompiledReport,
    CompiledTimeout,
)
from rai_missions.engine.trees.node import FAILURE, SUCCESS, CompiledNode
from rai_missions.engine.trees.parallel import CompiledParallel
from rai_missions.engine.trees.sites import TreePlace
from rai_missions.guards.view import Site
from rai_missions.states import tree

__all__ = ("MAKERS", "live_nodes")

Inside = list[Any]
"""The live nodes of a node's children."""
Maker = Callable[[TreePlace, Any, str, Inside], CompiledNode]


def live_nodes(root: tree.TreeNode, place: TreePlace) -> tuple[CompiledNode, ...]:
    """The live nodes of a tree, outer before inner; the first is its root."""
    nodes: list[CompiledNode] = []
    _add(root, "", place, nodes)
    for number, node in enumerate(nodes):
        node.number = number
    return tuple(nodes)


def _add(node: tree.TreeNode, path: str, place: TreePlace, nodes: list[Any]) -> CompiledNode:
    number = len(nodes)
    nodes.append(None)  # its place is before what is inside it
    inside = [_add(child, f"{path}/{branch}".lstrip("/"), place, nodes) for branch, child in node.branches()]
    made = MAKERS[type(node)](place, node, path, inside)
    made.path = path
    nodes[number] = made
    return made


def _is_steady(site: Site) -> bool:
    """Whether a guard depends on nothing but keys, states and time."""
    return not (site.held_guards or site.named or site.passing)


def _check(at: TreePlace, node: tree.Check, path: str, inside: Inside) -> CompiledNode:
    site = at.site(path, "check")
    return leaves.CompiledCheck(node.check.compiled(site, True), site, steady=_is_steady(site))


def _guard(at: TreePlace, node: tree.EternalGuard, path: str, inside: Inside) -> CompiledNode:
    site = at.site(path, "eternal_guard")
    return CompiledEternalGuard(inside[0], node.guard.compiled(site, True), site, steady=_is_steady(site))


def _set(at: TreePlace, node: tree.Set, path: str, inside: Inside) -> CompiledNode:
    site = at.site(path, "set")
    value, adds = at.value(node, site), node.add is not None
    return leaves.CompiledSet(node.set, at.keys.get(node.set), value, site, adds=adds)


def _one_shot(at: TreePlace, node: tree.OneShot, path: str, inside: Inside) -> CompiledNode:
    return CompiledOneShot(inside[0], (SUCCESS, FAILURE) if node.policy == "on_completion" else (SUCCESS,))


def _decision(at: TreePlace, node: tree.Decision, path: str, inside: Inside) -> CompiledNode:
    return leaves.CompiledDecision(frozenset(node.decision.options), dict(zip(node.then, inside, strict=True)))


def _converter(at: TreePlace, node: tree.Decorator, path: str, inside: Inside) -> CompiledNode:
    return CompiledConverter(inside[0], REPORTS[node.word])


def _loop(at: TreePlace, node: tree.Decorator, path: str, inside: Inside) -> CompiledNode:
    word = f"condition {node.status}" if isinstance(node, tree.Condition) else node.word
    return CompiledLoop(inside[0], REPORTS[word])


MAKERS: Mapping[type[tree.TreeNode], Maker] = {
    tree.Sequence: lambda at, node, path, inside: CompiledSequence(inside, memory=node.memory),
    tree.Selector: lambda at, node, path, inside: CompiledSelector(inside, memory=node.memory),
    tree.Parallel: lambda at, node, path, inside: CompiledParallel(inside, node.policy, synchronise=node.synchronise),
    tree.Inverter: _converter,
    tree.FailureIsSuccess: _converter,
    tree.SuccessIsFailure: _converter,
    tree.RunningIsFailure: _converter,
    tree.RunningIsSuccess: _converter,
    tree.PassThrough: _converter,
    tree.FailureIsRunning: _loop,
    tree.SuccessIsRunning: _loop,
    tree.Condition: _loop,
    tree.Retry: lambda at, node, path, inside: CompiledCount(inside[0], node.num_failures, FAILURE, "failures"),
    tree.Repeat: lambda at, node, path, inside: CompiledCount(inside[0], node.num_success, SUCCESS, "success"),
    tree.Timeout: lambda at, node, path, inside: CompiledTimeout(inside[0], node.duration_s),
    tree.OneShot: _one_shot,
    tree.EternalGuard: _guard,
    tree.StatusToBlackboard: lambda at, node, path, inside: CompiledReport(inside[0], node.key),
    tree.Check: _check,
    tree.Decision: _decision,
    tree.Set: _set,
    tree.Publish: lambda at, node, path, inside: leaves.CompiledPublish(node.publish, at.message(node, path)),
    tree.Wait: lambda at, node, path, inside: leaves.CompiledWait(node.wait_s),
    tree.Action: lambda at, node, path, inside: leaves.CompiledActivity(at.sent(node, path)),
    tree.Call: lambda at, node, path, inside: leaves.CompiledActivity(at.sent(node, path)),
    tree.Behaviour: lambda at, node, path, inside: leaves.CompiledBehaviour(),
}
"""Kind of node → how it is compiled."""

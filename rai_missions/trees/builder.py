# SPDX-License-Identifier: Apache-2.0
"""Makes live behaviours of a tree's nodes.

Rule: how a kind of node becomes a behaviour is in `MAKERS` and nowhere else; what it then does is in its class.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import OneShotPolicy, ParallelPolicy

from rai_missions.engine.trees.sites import TreePlace
from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site
from rai_missions.keys import Key
from rai_missions.states import tree
from rai_missions.trees import leaves, nodes

__all__ = ("MAKERS", "TreeBuilder")


class TreeBuilder:
    """Makes one tree live.

    Args:
        place: The JSON pointer of the tree.
        keys: The mission's keys.
        state: The state that runs the tree.
        round: The round that every behaviour of this tree looks at.
    """

    def __init__(self, place: str, keys: Mapping[str, Key], state: str, round: Tick) -> None:  # noqa: A002
        self.tree, self.keys, self.round = TreePlace(place, keys, state), keys, round
        self.live: dict[str, Any] = {}
        """Path → the behaviour that is there, outer before inner."""

    def build(self, node: tree.TreeNode, path: str = "") -> Any:
        """The live behaviour of a node, with all that is inside it."""
        self.live[path] = None  # its place is before what is inside it
        inside = [self.build(child, f"{path}/{branch}".lstrip("/")) for branch, child in node.branches()]
        behaviour = MAKERS[type(node)](self, node, path, inside)
        behaviour.path, behaviour.round = path, self.round
        self.live[path] = behaviour
        return behaviour

    def site(self, path: str, word: str) -> Site:
        """Where something of a node is compiled."""
        return self.tree.site(path, word)


Inside = list[Behaviour]
"""The behaviours of a node's children."""
Maker = Callable[[TreeBuilder, Any, str, Inside], Any]


def _with(behaviour: Any, **attributes: Any) -> Any:
    for name, value in attributes.items():
        setattr(behaviour, name, value)
    return behaviour


def _tested(behaviour: Any, guard: Guard, site: Site) -> Any:
    return _with(behaviour, test=guard.compiled(site, True), site=site)


def _parallel(at: TreeBuilder, node: tree.Parallel, path: str, inside: Inside) -> Any:
    policy: ParallelPolicy.Base
    if node.policy == "success_on_one":
        policy = ParallelPolicy.SuccessOnOne()
    elif node.policy == "success_on_all":
        policy = ParallelPolicy.SuccessOnAll(synchronise=node.synchronise)
    else:
        selected = [inside[int(number)] for number in node.policy]
        policy = ParallelPolicy.SuccessOnSelected(selected, synchronise=node.synchronise)
    return nodes.ParallelBehaviour(node.word, policy, inside)


def _ask(at: TreeBuilder, node: tree.Decision, path: str, inside: Inside) -> Any:
    subtrees = dict(zip(node.then, inside, strict=True))
    return _with(leaves.AskBehaviour(node.word, inside), options=frozenset(node.decision.options), subtrees=subtrees)


def _write(at: TreeBuilder, node: tree.Set, path: str, inside: Inside) -> Any:
    site, write, adds = at.site(path, "set"), leaves.WriteBehaviour(node.word), node.add is not None
    value = at.tree.value(node, site)
    return _with(write, key=node.set, definition=at.keys.get(node.set), adds=adds, value=value, site=site)


def _publish(at: TreeBuilder, node: tree.Publish, path: str, inside: Inside) -> Any:
    return _with(leaves.PublishBehaviour(node.word), topic=node.publish, message=at.tree.message(node, path))


def _sent(at: TreeBuilder, node: tree.TreeNode, path: str, inside: Inside) -> Any:
    return _with(leaves.ActivityLeaf(node.word), site=at.tree.sent(node, path))


MAKERS: Mapping[type[tree.TreeNode], Maker] = {
    tree.Sequence: lambda at, node, path, inside: nodes.SequenceBehaviour(node.word, node.memory, inside),
    tree.Selector: lambda at, node, path, inside: nodes.SelectorBehaviour(node.word, node.memory, inside),
    tree.Parallel: _parallel,
    **{kind: lambda at, node, path, inside: nodes.PLAIN[type(node)](node.word, inside[0]) for kind in nodes.PLAIN},
    tree.Retry: lambda at, node, path, inside: nodes.RetryBehaviour(node.word, inside[0], node.num_failures),
    tree.Repeat: lambda at, node, path, inside: nodes.RepeatBehaviour(node.word, inside[0], node.num_success),
    tree.Timeout: lambda at, node, path, inside: nodes.TimeoutBehaviour(node.word, inside[0], node.duration_s),
    tree.OneShot: lambda at, node, path, inside: nodes.OneShotBehaviour(
        node.word, inside[0], OneShotPolicy[node.policy.upper()]
    ),
    tree.Condition: lambda at, node, path, inside: nodes.ConditionBehaviour(
        node.word, inside[0], nodes.STATUSES[node.status]
    ),
    tree.EternalGuard: lambda at, node, path, inside: _tested(
        nodes.EternalGuardBehaviour(node.word, inside[0]), node.guard, at.site(path, "eternal_guard")
    ),
    tree.StatusToBlackboard: lambda at, node, path, inside: _with(
        nodes.StatusToBlackboardBehaviour(node.word, inside[0]), key=node.key
    ),
    tree.Check: lambda at, node, path, inside: _tested(
        leaves.CheckBehaviour(node.word), node.check, at.site(path, "check")
    ),
    tree.Decision: _ask,
    tree.Set: _write,
    tree.Publish: _publish,
    tree.Wait: lambda at, node, path, inside: _with(leaves.WaitBehaviour(node.word), wait_s=node.wait_s),
    tree.Action: _sent,
    tree.Call: _sent,
    tree.Behaviour: lambda at, node, path, inside: leaves.PythonLeaf(node.program()),
}
"""Kind of node → how its behaviour is made."""

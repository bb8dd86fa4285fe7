# SPDX-License-Identifier: Apache-2.0
"""Makes live behaviours of a tree's nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.common import OneShotPolicy, ParallelPolicy

from rai_missions.engine.activities.activity import GOALS
from rai_missions.guards.guard import Guard, Operand, Site, Test, View
from rai_missions.keys import Key
from rai_missions.states import tree
from rai_missions.states.effects import Set, filled, references
from rai_missions.trees import leaves, nodes
from rai_missions.trees.tick import Tick

__all__ = ("BuiltNode", "TreeBuilder")


class BuiltNode(NamedTuple):
    """What is at a path."""

    behaviour: Any
    site: Site | None
    """What its guard depends on, where it has one."""


class TreeBuilder:
    """Makes one tree live.

    Args:
        place: The JSON pointer of the tree.
        keys: The mission's keys.
        state: The state that runs the tree.
        round: The round that every behaviour of this tree looks at.
    """

    def __init__(self, place: str, keys: Mapping[str, Key], state: str, round: Tick) -> None:  # noqa: A002
        self.place, self.keys, self.state, self.round = place, keys, state, round
        self.planted: dict[str, BuiltNode] = {}
        """Path → what is there, outer before inner."""

    def plant(self, node: tree.TreeNode, path: str = "") -> Behaviour:
        """The live behaviour of a node, with all that is inside it."""
        self.planted[path] = BuiltNode(None, None)
        inside = {
            pointer: self.plant(child, f"{path}/{pointer}" if path else pointer) for pointer, child in node.branches()
        }
        behaviour, site = self._made(node, path, inside)
        behaviour.path, behaviour.round = path, self.round
        self.planted[path] = BuiltNode(behaviour, site)
        planted: Behaviour = behaviour
        return planted

    def _made(self, node: tree.TreeNode, path: str, inside: Mapping[str, Behaviour]) -> tuple[Any, Site | None]:
        children = list(inside.values())
        if isinstance(node, tree.Branch):
            return self._composite(node, children), None
        if isinstance(node, tree.EternalGuard):
            site = self._site(path, "eternal_guard")
            return self._guarded(nodes.EternalGuard(node.word, children[0]), node.guard, site), site
        if isinstance(node, tree.Decorator):
            return self._decorator(node, children[0]), None
        if isinstance(node, tree.CheckLeaf):
            site = self._site(path, "check")
            return self._guarded(leaves.Check(node.word), node.check, site), site
        if isinstance(node, tree.DecisionLeaf):
            ask = leaves.Ask(node.word, children)
            ask.options = frozenset(node.decision.options)
            ask.subtrees = {pointer.partition("/")[2]: child for pointer, child in inside.items()}
            return ask, None
        if isinstance(node, tree.SetLeaf):
            return self._write(node, path)
        return self._leaf(node, path), self._sent_with(node, path)

    def _write(self, node: tree.SetLeaf, path: str) -> tuple[Any, Site]:
        write, site = leaves.Write(node.word), self._site(path, "set")
        write.key, write.definition, write.adds = node.set, self.keys.get(node.set), node.add is not None
        write.value = self._value(node.effect(), site)
        return write, site

    def _sent_with(self, node: tree.TreeNode, path: str) -> Site | None:
        """What an action or call depends on when it is begun; that something of it grows stale begins nothing."""
        if not isinstance(node, tree.ActionLeaf | tree.CallLeaf):
            return None
        site = self._site(path, node.word)
        for reference in references(node.goal if isinstance(node, tree.ActionLeaf) else node.request):
            Operand(reference, site)
        site.instants.clear()
        if isinstance(node, tree.ActionLeaf):
            site.reads.add(GOALS)
        return site

    def _site(self, path: str, word: str) -> Site:
        return Site("/".join(filter(None, (self.place, path, word))), self.keys, self.state)

    @staticmethod
    def _guarded(behaviour: Any, guard: Guard, site: Site) -> Any:
        test: Test = guard.compile(site)
        behaviour.test = test
        return behaviour

    @staticmethod
    def _composite(node: tree.TreeNode, children: list[Behaviour]) -> Behaviour:
        if isinstance(node, tree.Sequence):
            return nodes.Sequence(node.word, node.memory, children)
        if isinstance(node, tree.Selector):
            return nodes.Selector(node.word, node.memory, children)
        assert isinstance(node, tree.ParallelTree)
        policy: ParallelPolicy.Base
        if node.policy == "success_on_one":
            policy = ParallelPolicy.SuccessOnOne()
        elif node.policy == "success_on_all":
            policy = ParallelPolicy.SuccessOnAll(synchronise=node.synchronise)
        else:
            selected = [children[int(number)] for number in node.policy]
            policy = ParallelPolicy.SuccessOnSelected(selected, synchronise=node.synchronise)
        return nodes.Parallel(node.word, policy, children)

    @staticmethod
    def _decorator(node: tree.Decorator, child: Behaviour) -> Behaviour:
        if type(node) in nodes.PLAIN:
            return nodes.PLAIN[type(node)](node.word, child)
        if isinstance(node, tree.Retry):
            return nodes.Retry(node.word, child, node.num_failures)
        if isinstance(node, tree.Repeat):
            return nodes.Repeat(node.word, child, node.num_success)
        if isinstance(node, tree.Timeout):
            return nodes.Timeout(node.word, child, node.duration_s)
        if isinstance(node, tree.OneShot):
            return nodes.OneShot(node.word, child, OneShotPolicy[node.policy.upper()])
        if isinstance(node, tree.Condition):
            return nodes.Condition(node.word, child, nodes.STATUSES[node.status])
        assert isinstance(node, tree.StatusToBlackboard)
        report = nodes.StatusToBlackboard(node.word, child)
        report.key = node.key
        return report

    def _leaf(self, node: tree.TreeNode, path: str) -> Behaviour:
        if isinstance(node, tree.WaitLeaf):
            wait = leaves.Wait(node.word)
            wait.wait_s = node.wait_s
            return wait
        if isinstance(node, tree.PublishLeaf):
            publish = leaves.Publish(node.word)
            publish.topic, publish.message = node.publish, self._message(node.message, path)
            return publish
        if isinstance(node, tree.BehaviourLeaf):
            return leaves.PythonLeaf(tree.factory_name(node.factory))
        return leaves.ActivityLeaf(node.word)

    @staticmethod
    def _value(effect: Set, site: Site) -> Callable[[View], Any]:
        if effect.add is not None:
            old, add = Operand(effect.set, site), effect.add
            return lambda view: _sum(old.read(view), add)
        if effect.source is not None:
            return Operand(effect.source, site).read
        return lambda view: effect.value

    def _message(self, template: Mapping[str, Any], path: str) -> Callable[[View], Mapping[str, Any]]:
        def message(view: View) -> Mapping[str, Any]:
            content: Mapping[str, Any] = filled(template, view, self._site(path, "message"))
            return content

        return message


def _sum(value: Any, add: float) -> Any:
    """A number that stays whole where both are; None where there is none to add to."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return value + (int(add) if isinstance(value, int) and add == int(add) else add)

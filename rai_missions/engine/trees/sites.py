# SPDX-License-Identifier: Apache-2.0
"""What the leaves of a tree read, compiled once, whichever ticker runs them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.activity import GOALS
from rai_missions.engine.activities.ticker import TreeState
from rai_missions.engine.templates import FilledTemplate, SentTemplate
from rai_missions.guards.view import Operand, Site, View
from rai_missions.keys import Key
from rai_missions.plain_data import is_numeric
from rai_missions.states import tree
from rai_missions.states.effects import references

__all__ = ("TreePlace", "added", "shifted")


class TreePlace(NamedTuple):
    """Where a tree is compiled."""

    place: str
    """The JSON pointer of the tree."""
    keys: Mapping[str, Key]
    """The mission's keys."""
    state: str
    """The state that runs the tree."""

    def site(self, path: str, word: str) -> Site:
        """Where something of a node is compiled."""
        return Site("/".join(filter(None, (self.place, path, word))), self.keys, self.state)

    def sent(self, node: tree.TreeNode, path: str) -> Site:
        """What an action or call depends on when it begins; that something of it grows stale begins nothing."""
        site = self.site(path, node.word)
        for reference in references(node.goal if isinstance(node, tree.Action) else getattr(node, "request", {})):
            Operand(reference, site)
        site.instants.clear()
        if isinstance(node, tree.Action):
            site.reads.add(GOALS)
        return site

    def value(self, node: tree.Set, site: Site) -> Callable[[View], Any]:
        """What a `set` writes; None where that is unknown."""
        effect, add = node.effect(), node.add
        source = node.set if add is not None else effect.source
        read = Operand(source, site).read if source is not None else lambda view: effect.value
        return read if add is None else lambda view: added(read(view), add)

    def message(self, node: tree.Publish, path: str) -> Callable[[View], FilledTemplate]:
        """What a `publish` publishes."""
        return SentTemplate("message", node.message, self.site(path, "message")).fill


def added(value: Any, add: float) -> Any:
    """A number that stays whole where both are; None where there is none to add to."""
    if not is_numeric(value):
        return None
    return value + (int(add) if isinstance(value, int) and add == int(add) else add)


def shifted(state: TreeState, by_s: float) -> TreeState:
    """The state as it would be had everything happened so much later, in seconds."""
    nodes = {}
    for path, memory in state.nodes.items():
        late = {word: memory[word] + by_s for word in ("until", "began") if word in memory}
        held = {name: since + by_s for name, since in memory.get("held", {}).items()}
        nodes[path] = {**memory, **late, **({"held": held} if held else {})}
    return state._replace(nodes=nodes)

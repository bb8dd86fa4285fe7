# SPDX-License-Identifier: Apache-2.0
"""A state that runs a behaviour tree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, model_validator

from rai_missions.model import AnyOf, fault
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State
from rai_missions.states.transition import Transition
from rai_missions.states.tree.behaviour import BehaviourLeaf, Factory
from rai_missions.states.tree.node import TreeNode, depth

__all__ = ("Tree",)

DEEPEST = 100
"""Objects and lists within one another; each node of a tree costs two of them."""


def _shallow(given: Any) -> Any:
    if (found := depth(given)) > DEEPEST:
        raise fault(
            "depth", f"the tree is nested {found} deep, and at most {DEEPEST} can be read; make states of its parts"
        )
    return given


class Tree(State, word="tree"):
    """Runs a behaviour tree; its success and failure are the outcomes."""

    tree: Annotated[AnyOf[TreeNode], BeforeValidator(_shallow)]
    """The root of the tree; in Python also a function that makes a behaviour of py_trees."""

    def __init__(
        self,
        tree: TreeNode | Factory,
        *,
        tick_s: float = 0.1,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    @classmethod
    def meanings(cls) -> Mapping[str, str]:
        return {**super().meanings(), "tick_s": BehaviourLeaf.meanings()["tick_s"]}

    @model_validator(mode="before")
    @classmethod
    def _of_a_factory(cls, words: Any) -> Any:
        """In Python `Tree(factory, tick_s=0.1)` runs one behaviour of the user's program."""
        factory = words.get("tree") if isinstance(words, Mapping) else None
        is_node = isinstance(factory, TreeNode) or (isinstance(factory, type) and issubclass(factory, TreeNode))
        if is_node or factory is None or isinstance(factory, Mapping | list | tuple | str | int | float):
            if isinstance(words, Mapping) and "tick_s" in words:
                why = "a tree of nodes is ticked when something changes; leave 'tick_s' to a behaviour in Python"
                raise fault("tick_s", why, at=("tick_s",))
            return words
        given = {"tick_s": words["tick_s"]} if "tick_s" in words else {}
        rest = {word: value for word, value in words.items() if word != "tick_s"}
        return {**rest, "tree": BehaviourLeaf(factory, **given)}

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed"}

    def root(self) -> TreeNode:
        return self.tree

    def within(self, part: str) -> str:
        return f"/tree/{part.removeprefix('#')}".rstrip("/")

    def activity(self) -> str:
        return "tree"

    def title(self) -> str:
        return ""

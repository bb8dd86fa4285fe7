# SPDX-License-Identifier: Apache-2.0
"""A state that runs a behaviour tree."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from rai_missions.states.state import State
from rai_missions.states.tree.node import NODE, depth
from rai_missions.written import fault

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

    positional: ClassVar = ("tree",)

    tree: Annotated[NODE, BeforeValidator(_shallow)]

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed"}

    def activity(self) -> str:
        return "tree"

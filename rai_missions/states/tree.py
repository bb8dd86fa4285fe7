# SPDX-License-Identifier: Apache-2.0
"""A behaviour tree as data, under py_trees' own names; what ticks it is given to the chart.

Rule: nothing here knows py_trees. A tree's state is a frozen value from which a ticker rebuilds.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from rai_missions.effects import Effect
from rai_missions.guards.guard import Guard
from rai_missions.states.decision import Asked
from rai_missions.states.state import State
from rai_missions.written import Bool, Integer, Json, Kind, Name, Number, Path, Seconds, Text, fault, kind_of

__all__ = (
    "ActionLeaf", "Branch", "CallLeaf", "CheckLeaf", "DecisionLeaf", "Decorator", "PublishLeaf", "SetLeaf", "Tree",
    "TreeNode", "WaitLeaf", "tree_paths",
)  # fmt: skip


class TreeNode(Kind, family="tree node"):
    """A node of a tree."""

    name: Text = ""
    """For pictures; without it the node is called by its word."""

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        """Its children, each with the pointer from here."""
        return iter(())


def _children(given: Any) -> Any:
    return tuple(given) if isinstance(given, list) else given


Children = Annotated[tuple[kind_of(TreeNode), ...], BeforeValidator(_children), Field(min_length=1)]


class Branch(TreeNode):
    """A composite: it has children."""

    def children(self) -> tuple[TreeNode, ...]:
        """In the order written."""
        given: tuple[TreeNode, ...] = getattr(self, self.word)
        return given

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        for index, child in enumerate(self.children()):
            yield f"{self.word}/{index}", child


class Sequence(Branch, word="sequence"):
    """One after the other, until one fails."""

    positional: ClassVar = ("sequence",)
    sequence: Children
    memory: Bool = True
    """Goes on at the running child; without it, from the first at each tick."""


class Selector(Branch, word="selector"):
    """One after the other, until one succeeds."""

    positional: ClassVar = ("selector",)
    selector: Children
    memory: Bool = False
    """Goes on at the running child; without it, a higher one that stops failing takes over."""


class ParallelTree(Branch, word="parallel"):
    """All at each tick; fails with the first that fails."""

    positional: ClassVar = ("parallel",)
    parallel: Children
    policy: Literal["success_on_all", "success_on_one"] | tuple[int, ...] = "success_on_all"
    """Whose success is enough: all, one, or the children with these numbers (from 0)."""
    synchronise: Bool = True
    """A child that has succeeded is not ticked again."""


class Decorator(TreeNode):
    """Changes what its one child says."""

    def child(self) -> TreeNode:
        """The node inside."""
        given: TreeNode = getattr(self, "child_", None) or getattr(self, DECORATED[self.word])
        return given

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        yield self.pointer(), self.child()

    def pointer(self) -> str:
        """Where the child stands."""
        return "child" if "child_" in type(self).model_fields else self.word


NODE = kind_of(TreeNode)
DECORATED = {word: f"of_{word}" for word in (
    "inverter", "failure_is_success", "failure_is_running", "success_is_failure", "success_is_running",
    "running_is_failure", "running_is_success", "one_shot",
)}  # fmt: skip


class Inverter(Decorator, word="inverter"):
    """Success is failure, failure is success."""

    positional: ClassVar = ("of_inverter",)
    of_inverter: NODE = Field(alias="inverter")  # type: ignore[valid-type]


class FailureIsSuccess(Decorator, word="failure_is_success"):
    """Be positive."""

    positional: ClassVar = ("of_failure_is_success",)
    of_failure_is_success: NODE = Field(alias="failure_is_success")  # type: ignore[valid-type]


class FailureIsRunning(Decorator, word="failure_is_running"):
    """Keep trying."""

    positional: ClassVar = ("of_failure_is_running",)
    of_failure_is_running: NODE = Field(alias="failure_is_running")  # type: ignore[valid-type]


class SuccessIsFailure(Decorator, word="success_is_failure"):
    """Be depressed."""

    positional: ClassVar = ("of_success_is_failure",)
    of_success_is_failure: NODE = Field(alias="success_is_failure")  # type: ignore[valid-type]


class SuccessIsRunning(Decorator, word="success_is_running"):
    """Never done."""

    positional: ClassVar = ("of_success_is_running",)
    of_success_is_running: NODE = Field(alias="success_is_running")  # type: ignore[valid-type]


class RunningIsFailure(Decorator, word="running_is_failure"):
    """Got to be snappy."""

    positional: ClassVar = ("of_running_is_failure",)
    of_running_is_failure: NODE = Field(alias="running_is_failure")  # type: ignore[valid-type]


class RunningIsSuccess(Decorator, word="running_is_success"):
    """Don't hang around."""

    positional: ClassVar = ("of_running_is_success",)
    of_running_is_success: NODE = Field(alias="running_is_success")  # type: ignore[valid-type]


class OneShot(Decorator, word="one_shot"):
    """Runs to its end once in the life of the tree; afterwards its end is repeated."""

    positional: ClassVar = ("of_one_shot",)
    of_one_shot: NODE = Field(alias="one_shot")  # type: ignore[valid-type]
    policy: Literal["on_completion", "on_successful_completion"] = "on_completion"


class Retry(Decorator, word="retry"):
    """Starts its child again until it succeeds, so often at the most."""

    positional: ClassVar = ("child_", "num_failures")
    num_failures: Integer = Field(alias="retry", ge=1)
    child_: NODE = Field(alias="child")  # type: ignore[valid-type]


class Repeat(Decorator, word="repeat"):
    """Starts its child again until it has succeeded so often; -1 for ever."""

    positional: ClassVar = ("child_", "num_success")
    num_success: Integer = Field(alias="repeat", ge=-1)
    child_: NODE = Field(alias="child")  # type: ignore[valid-type]


class Timeout(Decorator, word="timeout"):
    """Fails when its child takes longer."""

    positional: ClassVar = ("child_", "duration_s")
    duration_s: Seconds = Field(alias="timeout", gt=0)
    child_: NODE = Field(alias="child")  # type: ignore[valid-type]


class EternalGuard(Decorator, word="eternal_guard"):
    """Runs its child while a guard is true; else it fails and what runs inside is ended."""

    positional: ClassVar = ("child_", "guard")
    guard: kind_of(Guard) = Field(alias="eternal_guard")  # type: ignore[valid-type]
    child_: NODE = Field(alias="child")  # type: ignore[valid-type]


class ActionLeaf(TreeNode, word="action"):
    """A goal; as the state of the same word."""

    positional: ClassVar = ("action",)
    action: Name
    goal: dict[Text, Json] = Field(default_factory=dict)
    result: dict[Name, Text] = Field(default_factory=dict)
    achieved: kind_of(Guard) | None = None
    settle_s: Seconds = 0.0
    cancel_s: Seconds = 5.0
    over_orphan: Bool = False
    timeout_s: Seconds | None = Field(default=None, gt=0)


class CallLeaf(TreeNode, word="call"):
    """A call; as the state of the same word."""

    positional: ClassVar = ("call",)
    call: Name
    request: dict[Text, Json] = Field(default_factory=dict)
    result: dict[Name, Text] = Field(default_factory=dict)
    timeout_s: Seconds | None = Field(default=None, gt=0)


class CheckLeaf(TreeNode, word="check"):
    """Success while a guard is true, failure while it is false or unknown."""

    positional: ClassVar = ("check",)
    check: kind_of(Guard)  # type: ignore[valid-type]


class WaitLeaf(TreeNode, word="wait_s"):
    """Running for so long, then success."""

    positional: ClassVar = ("wait_s",)
    wait_s: Seconds


class SetLeaf(TreeNode, word="set"):
    """Writes a key of the mission and succeeds; words as the effect's."""

    positional: ClassVar = ("set", "value")
    set: Name
    value: Json = None
    from_: Path | None = Field(default=None, alias="from")
    add: Number | None = None

    def effect(self) -> Effect:
        """The effect that it is."""
        words = {"value": self.value, "from_": self.from_, "add": self.add}
        effect: Effect = Effect.kinds["set"](set=self.set, **{word: given for word, given in words.items() if given is not None})
        return effect

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if sum(given is not None for given in (self.value, self.from_, self.add)) != 1:
            raise fault("set", "'set' takes one of value, from, add")
        return self


class PublishLeaf(TreeNode, word="publish"):
    """Publishes a message and succeeds."""

    positional: ClassVar = ("publish", "message")
    publish: Name
    message: dict[str, Json] = Field(default_factory=dict)


class DecisionLeaf(TreeNode, word="decision"):
    """Asks, then runs the subtree of the option; an option without one is success."""

    decision: Asked
    then: dict[Name, NODE] = Field(default_factory=dict)  # type: ignore[valid-type]

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        for option, subtree in self.then.items():
            yield f"then/{option}", subtree


def tree_paths(root: TreeNode, path: str = "") -> Iterator[tuple[str, TreeNode]]:
    """Every node, outer before inner, with its path from the root: `sequence/0/child`."""
    yield path, root
    for pointer, child in root.branches():
        yield from tree_paths(child, f"{path}/{pointer}" if path else pointer)


class Tree(State, word="tree"):
    """Runs a behaviour tree; its success and failure are the outcomes."""

    positional: ClassVar = ("tree",)

    tree: kind_of(TreeNode)  # type: ignore[valid-type]

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed"}

    def activity(self) -> str:
        return "tree"

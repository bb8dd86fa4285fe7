# SPDX-License-Identifier: Apache-2.0
"""Nodes that change what their one child reports, under py_trees' names."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.model import AnyOf, Integer, KeyPath, Name, Number
from rai_missions.model.references import Refers
from rai_missions.states.tree.node import Decorator, TreeNode

__all__ = (
    "Condition", "EternalGuard", "FailureIsRunning", "FailureIsSuccess", "Inverter", "OneShot", "PassThrough", "Repeat",
    "Retry", "RunningIsFailure", "RunningIsSuccess", "StatusToBlackboard", "SuccessIsFailure", "SuccessIsRunning",
    "Timeout",
)  # fmt: skip


class Inverter(Decorator, word="inverter"):
    """Success is failure, failure is success."""

    child: AnyOf[TreeNode] = Field(alias="inverter")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class FailureIsSuccess(Decorator, word="failure_is_success"):
    """Never fails."""

    child: AnyOf[TreeNode] = Field(alias="failure_is_success")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class FailureIsRunning(Decorator, word="failure_is_running"):
    """Begins its child again until it succeeds."""

    child: AnyOf[TreeNode] = Field(alias="failure_is_running")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class SuccessIsFailure(Decorator, word="success_is_failure"):
    """Never succeeds."""

    child: AnyOf[TreeNode] = Field(alias="success_is_failure")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class SuccessIsRunning(Decorator, word="success_is_running"):
    """Begins its child again until it fails."""

    child: AnyOf[TreeNode] = Field(alias="success_is_running")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class RunningIsFailure(Decorator, word="running_is_failure"):
    """Fails where its child would need time; what the child has begun is ended."""

    child: AnyOf[TreeNode] = Field(alias="running_is_failure")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class RunningIsSuccess(Decorator, word="running_is_success"):
    """Succeeds where its child would need time; what the child has begun is ended."""

    child: AnyOf[TreeNode] = Field(alias="running_is_success")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class PassThrough(Decorator, word="pass_through"):
    """Reports what its child reports: a name in the picture."""

    child: AnyOf[TreeNode] = Field(alias="pass_through")

    def __init__(self, child: TreeNode, *, name: str = "") -> None: ...


class OneShot(Decorator, word="one_shot"):
    """Runs to its end once in the life of the tree; afterwards that end is repeated."""

    child: AnyOf[TreeNode] = Field(alias="one_shot")
    policy: Literal["on_completion", "on_successful_completion"] = "on_completion"
    """Which end counts: any, or only success."""

    def __init__(
        self,
        child: TreeNode,
        *,
        policy: Literal["on_completion", "on_successful_completion"] = "on_completion",
        name: str = "",
    ) -> None: ...


class Retry(Decorator, word="retry"):
    """Begins its child again until it succeeds; fails with the failure that has this number."""

    unit: ClassVar = "×"
    num_failures: Annotated[Integer, Field(ge=1)] = Field(alias="retry")
    """The number of the failure that ends it."""

    def __init__(self, child: TreeNode, num_failures: int, *, name: str = "") -> None: ...


class Repeat(Decorator, word="repeat"):
    """Begins its child again until it has succeeded so often; -1 is for ever. A failure ends it."""

    unit: ClassVar = "×"
    num_success: Annotated[Integer, Field(ge=1)] | Literal[-1] = Field(alias="repeat")
    """How many successes end it; -1: none does."""

    def __init__(self, child: TreeNode, num_success: int, *, name: str = "") -> None: ...


class Timeout(Decorator, word="timeout"):
    """Fails when its child takes so long, in seconds."""

    limits: ClassVar = True
    unit: ClassVar = " s"
    duration_s: Annotated[Number, Field(gt=0)] = Field(alias="timeout")
    """The seconds that the child may take."""

    def __init__(self, child: TreeNode, duration_s: float, *, name: str = "") -> None: ...


class EternalGuard(Decorator, word="eternal_guard"):
    """Runs its child while a guard is true; else it fails and what runs inside is ended."""

    guard: AnyOf[Guard] = Field(alias="eternal_guard")
    """What must be true while the child runs."""

    def __init__(self, child: TreeNode, guard: GuardOrKey, *, name: str = "") -> None: ...

    def words(self) -> str:
        return f"while {self.guard.words()}"


class Condition(Decorator, word="condition"):
    """Waits until its child reports this, and succeeds then; never fails."""

    status: Literal["success", "failure", "running"] = Field(alias="condition")
    """The report of the child that it waits for."""

    def __init__(
        self, child: TreeNode, status: Literal["success", "failure", "running"], *, name: str = ""
    ) -> None: ...


class StatusToBlackboard(Decorator, word="status_to_blackboard"):
    """Writes what its child reports under a key of the mission: `success`, `failure` or `running`."""

    key: Annotated[Name, Refers("key", "status")] = Field(alias="status_to_blackboard")
    """The key that the report is written to."""

    def __init__(self, child: TreeNode, key: KeyPath, *, name: str = "") -> None: ...

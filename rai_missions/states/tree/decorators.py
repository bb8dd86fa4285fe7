# SPDX-License-Identifier: Apache-2.0
"""Nodes that change what their one child reports, under py_trees' names."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from rai_missions.guards.guard import Guard
from rai_missions.kinds import Refers
from rai_missions.model import AnyOf, Integer, Name, Number
from rai_missions.states.tree.node import Decorator, TreeNode

__all__ = (
    "Condition", "EternalGuard", "FailureIsRunning", "FailureIsSuccess", "Inverter", "OneShot", "PassThrough", "Repeat",
    "Retry", "RunningIsFailure", "RunningIsSuccess", "StatusToBlackboard", "SuccessIsFailure", "SuccessIsRunning",
    "Timeout",
)  # fmt: skip


class Inverter(Decorator, word="inverter"):
    """Success is failure, failure is success."""

    child: AnyOf[TreeNode] = Field(alias="inverter")


class FailureIsSuccess(Decorator, word="failure_is_success"):
    """Never fails."""

    child: AnyOf[TreeNode] = Field(alias="failure_is_success")


class FailureIsRunning(Decorator, word="failure_is_running"):
    """Begins its child again until it succeeds."""

    child: AnyOf[TreeNode] = Field(alias="failure_is_running")


class SuccessIsFailure(Decorator, word="success_is_failure"):
    """Never succeeds."""

    child: AnyOf[TreeNode] = Field(alias="success_is_failure")


class SuccessIsRunning(Decorator, word="success_is_running"):
    """Begins its child again until it fails."""

    child: AnyOf[TreeNode] = Field(alias="success_is_running")


class RunningIsFailure(Decorator, word="running_is_failure"):
    """Fails where its child would need time; what the child has begun is ended."""

    child: AnyOf[TreeNode] = Field(alias="running_is_failure")


class RunningIsSuccess(Decorator, word="running_is_success"):
    """Succeeds where its child would need time; what the child has begun is ended."""

    child: AnyOf[TreeNode] = Field(alias="running_is_success")


class PassThrough(Decorator, word="pass_through"):
    """Reports what its child reports: a name in the picture."""

    child: AnyOf[TreeNode] = Field(alias="pass_through")


class OneShot(Decorator, word="one_shot"):
    """Runs to its end once in the life of the tree; afterwards that end is repeated."""

    child: AnyOf[TreeNode] = Field(alias="one_shot")
    policy: Literal["on_completion", "on_successful_completion"] = "on_completion"
    """Which end counts: any, or only success."""


class Retry(Decorator, word="retry"):
    """Begins its child again until it succeeds; fails with the failure that has this number."""

    positional: ClassVar = ("child", "num_failures")
    unit: ClassVar = "×"
    num_failures: Annotated[Integer, Field(ge=1)] = Field(alias="retry")


class Repeat(Decorator, word="repeat"):
    """Begins its child again until it has succeeded so often; -1 is for ever. A failure ends it."""

    positional: ClassVar = ("child", "num_success")
    unit: ClassVar = "×"
    num_success: Annotated[Integer, Field(ge=1)] | Literal[-1] = Field(alias="repeat")


class Timeout(Decorator, word="timeout"):
    """Fails when its child takes so long, in seconds."""

    positional: ClassVar = ("child", "duration_s")
    limits: ClassVar = True
    unit: ClassVar = " s"
    duration_s: Annotated[Number, Field(gt=0)] = Field(alias="timeout")


class EternalGuard(Decorator, word="eternal_guard"):
    """Runs its child while a guard is true; else it fails and what runs inside is ended."""

    positional: ClassVar = ("child", "guard")
    guard: AnyOf[Guard] = Field(alias="eternal_guard")

    def words(self) -> str:
        return f"while {self.guard.words()}"


class Condition(Decorator, word="condition"):
    """Waits until its child reports this, and succeeds then; never fails."""

    positional: ClassVar = ("child", "status")
    status: Literal["success", "failure", "running"] = Field(alias="condition")


class StatusToBlackboard(Decorator, word="status_to_blackboard"):
    """Writes what its child reports under a key of the mission: `success`, `failure` or `running`."""

    positional: ClassVar = ("child", "key")
    key: Annotated[Name, Refers("key", "status")] = Field(alias="status_to_blackboard")

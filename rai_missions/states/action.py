# SPDX-License-Identifier: Apache-2.0
"""An action of the robot: a goal that this state owns until its server has confirmed its end."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.guards.guard import Guard
from rai_missions.kinds import TEMPLATE
from rai_missions.model import ActionName, Bool, Json, OneOf, Seconds, Text
from rai_missions.states.state import ResultKey, State

__all__ = ("Action",)


class Action(State, word="action"):
    """Pursues a goal. Its success counts only while `achieved` is true."""

    positional: ClassVar = ("action",)

    action: ActionName
    """The profile's name of it."""
    goal: Annotated[dict[Text, Json], TEMPLATE] = Field(default_factory=dict)
    """The goal's fields; `{"from": key}` takes a value from the blackboard."""
    result: dict[ResultKey, Text] = Field(default_factory=dict)
    """Mission key → the field of the result that it takes."""
    achieved: OneOf[Guard] | None = None
    """What the robot's facts must say before a `succeeded` is believed; else `unverified`."""
    settle_s: Seconds = 0.0
    """How long after the server's `succeeded` the facts may take to agree."""
    cancel_s: Seconds = 5.0
    """How long the end of a canceled goal may take to be confirmed before it counts as orphaned."""
    over_orphan: Bool = False
    """Start even though an earlier goal on the same resources never confirmed its end."""

    def outcomes(self) -> frozenset[str]:
        ends = {"succeeded", "failed", "rejected", "canceled"}
        return super().outcomes() | ends | ({"unverified"} if self.achieved is not None else set())

    def activity(self) -> str:
        return f"action {self.action}"

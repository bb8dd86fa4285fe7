# SPDX-License-Identifier: Apache-2.0
"""An action of the robot: a goal that this state owns until its server has confirmed its end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from rai_missions.guards.guard import Guard
from rai_missions.kinds import TEMPLATE
from rai_missions.model import ActionName, Bool, Json, OneOf, Seconds, Text
from rai_missions.states.effects import call_lines
from rai_missions.states.state import ResultKey, State

if TYPE_CHECKING:
    from rai_missions.states.tree.leaves import ActionLeaf

__all__ = ("Action", "goal_lines")


class Action(State, word="action"):
    """Pursues a goal. Its success counts only while `achieved` is true."""

    positional: ClassVar = ("action",)
    reports_robot: ClassVar = True

    action: ActionName
    """The profile's name of it."""
    goal: Annotated[dict[Text, Json], TEMPLATE] = Field(default_factory=dict)
    """The goal's fields; `{"from": key}` takes a value from the blackboard."""
    result: dict[ResultKey, Text] = Field(default_factory=dict)
    """Mission key → the field of the result that it takes."""
    achieved: OneOf[Guard] | None = None
    """What must be true of the robot before a `succeeded` is believed; else `unverified`."""
    settle_s: Seconds = 0.0
    """How long after the server's `succeeded` the facts may take to agree."""
    cancel_s: Seconds = 5.0
    """How long the end of a canceled goal may take to be confirmed before it counts as orphaned."""
    over_orphan: Bool = False
    """Start even though an earlier goal on the same resources never confirmed its end."""

    def outcomes(self) -> frozenset[str]:
        ends = {"succeeded", "failed", "rejected", "canceled"}
        return super().outcomes() | ends | ({"unverified"} if self.achieved is not None else set())

    def takes_time(self) -> bool:
        return True

    def activity(self) -> str:
        return f"action {self.action}"

    def details(self) -> Iterator[str]:
        return goal_lines(self)


def goal_lines(work: Action | ActionLeaf) -> Iterator[str]:
    """What is sent, how long it may take, and when its success counts."""
    yield from call_lines("goal", work.goal, work.result, work.timeout_s)
    if work.achieved is not None:
        settle = f" (within {work.settle_s:g} s)" if work.settle_s else ""
        yield f"achieved when {work.achieved.words()}{settle}"
    if work.over_orphan:
        yield "starts over an orphan"

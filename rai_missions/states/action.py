# SPDX-License-Identifier: Apache-2.0
"""An action of the robot: a goal that this state owns until its server has confirmed its end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.model import WHOLE, ActionName, AnyOf, Bool, Json, MissionModel, Seconds, Text, Value
from rai_missions.model.references import TEMPLATE
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect, call_lines
from rai_missions.states.state import ResultKey, State
from rai_missions.states.transition import Transition

__all__ = ("Action", "GoalFields")


class GoalFields(MissionModel):
    """What an action's goal is sent with, and when its success counts."""

    action: ActionName
    """The profile's name of it."""
    goal: Annotated[dict[Text, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """The goal's fields; `{"from": key}` takes a value from the blackboard."""
    result: dict[ResultKey, Text] = Field(default_factory=dict)
    """Mission key → the field of the result that it takes."""
    achieved: AnyOf[Guard] | None = None
    """What must be true of the robot before a `succeeded` is believed; else `unverified`."""
    settle_s: Seconds = 0.0
    """Seconds after the server's `succeeded` that the facts may take to agree."""
    cancel_s: Seconds = 5.0
    """Seconds that the end of a canceled goal may take to be confirmed before it counts as orphaned."""
    over_orphan: Bool = False
    """Start even though an earlier goal on the same resources never confirmed its end."""
    timeout_s: Seconds | None = Field(default=None, gt=0)
    """Seconds after which it reports `timed_out` and the goal is canceled."""

    def goal_lines(self) -> Iterator[str]:
        """What is sent, how long it may take, and when its success counts."""
        yield from call_lines("goal", self.goal, self.result, self.timeout_s)
        if self.achieved is not None:
            settle = f" (within {self.settle_s:g} s)" if self.settle_s else ""
            yield f"achieved when {self.achieved.words()}{settle}"
        if self.over_orphan:
            yield "starts over an orphan"


class Action(GoalFields, State, word="action"):
    """Pursues a goal. Its success counts only while `achieved` is true."""

    reports_robot: ClassVar = True

    def __init__(
        self,
        action: str,
        *,
        goal: Mapping[str, Value] = {},
        result: Mapping[str, str] = {},
        achieved: GuardOrKey | None = None,
        settle_s: float = 0.0,
        cancel_s: float = 5.0,
        over_orphan: bool = False,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def outcomes(self) -> frozenset[str]:
        ends = {"succeeded", "failed", "rejected", "canceled"}
        return super().outcomes() | ends | ({"unverified"} if self.achieved is not None else set())

    def takes_time(self) -> bool:
        return True

    def activity(self) -> str:
        return f"action {self.action}"

    def proof(self) -> str:
        settle = f" within {self.settle_s:g} s" if self.settle_s else ""
        return (
            f"{self.action} has succeeded only when {self.achieved.words()}{settle}"
            if self.achieved is not None
            else ""
        )

    def details(self) -> Iterator[str]:
        return self.goal_lines()

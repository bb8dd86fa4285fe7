# SPDX-License-Identifier: Apache-2.0
"""The moves that lead from what the robot sees to a goal: `{"plan": "wanted", "over": "objects", "into": "plan"}`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

from rai_missions.guards.analysis import Distinctions
from rai_missions.model import KeyPath, Name, Path
from rai_missions.model.references import Refers
from rai_missions.planning.examples import PLANS
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State, TypeNeed
from rai_missions.states.transition import Transition

__all__ = ("Plan",)


class Plan(State, word="plan"):
    """Orders the moves to a goal by rule, in the step in which it begins; nothing moves.

    Outcomes: `succeeded`, there is a plan, without moves where the goal is reached; `failed`, with a reason;
    `rejected`, the goal, what is seen or the request is unknown.
    """

    plan: Path
    """The key that holds the goal, an object."""
    over: Path
    """The key that holds what the robot sees."""
    into: Annotated[Name, Refers("key", "plan")]
    """The mission key that the plan is written to, an object: `moves`, `next`, `reason`, `about`, `avoided`;
    and `aside`, a free place for what the gripper holds, where it holds something."""
    asked: Path | None = None
    """The key that holds the request, a string: `about` is in its language. Left out: in English."""
    refused: Path | None = None
    """The key that holds whether the arm refused to set down the thing of the last plan's next move, a boolean. While
    it is true, places that were refused are avoided, if there are others."""

    def __init__(
        self,
        plan: KeyPath,
        *,
        over: KeyPath,
        into: KeyPath,
        asked: KeyPath | None = None,
        refused: KeyPath | None = None,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed", "rejected"}

    def computed(self) -> frozenset[str]:
        return frozenset(("succeeded", "failed"))

    def computed_examples(self, outcome: str) -> Sequence[Mapping[str, Any]]:
        return PLANS[outcome]

    def type_needs(self) -> Iterator[TypeNeed]:
        yield TypeNeed("/plan", self.plan, "object", "a plan leads to a goal, an object", is_goal=True)
        yield TypeNeed("/over", self.over, "object", "a plan begins at what is seen, an object")
        yield TypeNeed("/into", self.into, "object", "a plan is an object")
        if self.asked is not None:
            yield TypeNeed("/asked", self.asked, "string", "the language is that of a request, a string")
        if self.refused is not None:
            yield TypeNeed("/refused", self.refused, "boolean", "a place was refused, or it was not")

    def distinguish(self, by: Distinctions) -> None:
        by.ask(self.plan)
        by.ask(self.over)
        if self.asked is not None:
            by.ask(self.asked)
        if self.refused is not None:
            by.ask(self.refused)

    def activity(self) -> str:
        return f"plan {self.plan}"

    def details(self) -> Iterator[str]:
        yield f"over {self.over}, into {self.into}"
        if self.asked is not None:
            yield f"in the language of {self.asked}"
        if self.refused is not None:
            yield f"elsewhere after {self.refused}"
        yield from super().details()

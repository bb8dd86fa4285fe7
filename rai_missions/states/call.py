# SPDX-License-Identifier: Apache-2.0
"""A call of a service, and its reply as the outcome."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.model import WHOLE, Json, MissionModel, Seconds, ServiceName, Text, Value
from rai_missions.model.references import TEMPLATE
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect, call_lines
from rai_missions.states.state import ResultKey, State
from rai_missions.states.transition import Transition

__all__ = ("Call", "CallFields")


class CallFields(MissionModel):
    """What a service is called with, and what is kept of its reply."""

    call: ServiceName
    """The profile's name of it."""
    request: Annotated[dict[Text, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """The request's fields; `{"from": key}` takes a value from the blackboard."""
    result: dict[ResultKey, Text] = Field(default_factory=dict)
    """Mission key → the field of the reply that it takes."""
    timeout_s: Seconds | None = Field(default=None, gt=0)
    """Seconds after which it reports `timed_out` and a reply counts no more."""

    def call_lines(self) -> Iterator[str]:
        """What is sent, what is taken of the reply, and how long it may take."""
        return call_lines("request", self.request, self.result, self.timeout_s)


class Call(CallFields, State, word="call"):
    """Calls a service once; leaving the state drops the reply."""

    yields: ClassVar = False
    reports_robot: ClassVar = True

    def __init__(
        self,
        call: str,
        *,
        request: Mapping[str, Value] = {},
        result: Mapping[str, str] = {},
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

    def takes_time(self) -> bool:
        return True

    def activity(self) -> str:
        return f"call {self.call}"

    def details(self) -> Iterator[str]:
        return self.call_lines()

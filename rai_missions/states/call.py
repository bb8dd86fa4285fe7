# SPDX-License-Identifier: Apache-2.0
"""A call of a service, and its reply as the outcome."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.kinds import TEMPLATE
from rai_missions.model import Json, ServiceName, Text
from rai_missions.states.effects import call_lines
from rai_missions.states.state import ResultKey, State

__all__ = ("Call",)


class Call(State, word="call"):
    """Calls a service once; leaving the state drops the reply."""

    positional: ClassVar = ("call",)
    yields: ClassVar = False
    reports_robot: ClassVar = True

    call: ServiceName
    """The profile's name of it."""
    request: Annotated[dict[Text, Json], TEMPLATE] = Field(default_factory=dict)
    """The request's fields; `{"from": key}` takes a value from the blackboard."""
    result: dict[ResultKey, Text] = Field(default_factory=dict)
    """Mission key → the field of the reply that it takes."""

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed", "rejected"}

    def takes_time(self) -> bool:
        return True

    def activity(self) -> str:
        return f"call {self.call}"

    def details(self) -> Iterator[str]:
        return call_lines("request", self.request, self.result, self.timeout_s)

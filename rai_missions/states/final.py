# SPDX-License-Identifier: Apache-2.0
"""An end: of its parent, or, at the top, of the mission."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal

from rai_missions.guards.guard import Guard
from rai_missions.model import AnyOf
from rai_missions.states.state import State

__all__ = ("Final", "FinalOutcome", "worst")

FinalOutcome = Literal["succeeded", "failed", "aborted", "canceled"]


class Final(State, word="final"):
    """Reaching it ends its parent with its outcome."""

    positional: ClassVar = ("final",)

    final: FinalOutcome
    requires: AnyOf[Guard] | None = None
    """What must be true then: else the mission `failed`, or a parent's outcome is `unverified`."""

    def title(self) -> str:
        return self.final

    def details(self) -> Iterator[str]:
        if self.requires is not None:
            yield f"requires {self.requires.words()}"
        yield from super().details()


def worst(outcomes: list[str]) -> str:
    """The outcome of regions together: succeeded if all are, else the worst of failed > aborted > canceled."""
    for outcome in ("failed", "unverified", "aborted", "canceled"):
        if outcome in outcomes:
            return outcome
    return "succeeded"

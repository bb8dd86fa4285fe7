# SPDX-License-Identifier: Apache-2.0
"""An end: of its parent, or, at the top, of the mission."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.model import AnyOf, Seconds
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State
from rai_missions.states.transition import Transition

__all__ = ("Final", "FinalOutcome", "worst")

FinalOutcome = Literal["succeeded", "failed", "aborted", "canceled"]


class Final(State, word="final"):
    """Reaching it ends its parent with its outcome."""

    final: FinalOutcome
    """The outcome of what it ends."""
    requires: AnyOf[Guard] | None = None
    """What must be true then: else the mission `failed`, or a parent's outcome is `unverified`."""
    settle_s: Seconds | None = None
    """Seconds that the facts may take to agree with `requires`; without it, those of the mission."""

    def __init__(
        self,
        final: FinalOutcome,
        *,
        requires: GuardOrKey | None = None,
        settle_s: float | None = None,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def title(self) -> str:
        return self.final

    def details(self) -> Iterator[str]:
        if self.requires is not None:
            within = f", within {self.settle_s:g} s" if self.settle_s is not None else ""
            yield f"requires {self.requires.words()}{within}"
        yield from super().details()


def worst(outcomes: list[str]) -> str:
    """The outcome of regions together: succeeded if all are, else the worst of failed > aborted > canceled."""
    for outcome in ("failed", "unverified", "aborted", "canceled"):
        if outcome in outcomes:
            return outcome
    return "succeeded"

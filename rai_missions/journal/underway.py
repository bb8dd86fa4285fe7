# SPDX-License-Identifier: Apache-2.0
"""What a run had under way when its journal ends: started and not ended, asked and not answered, not surely done.

Rule: it is read from rows alone. Whether any of it still goes on is for the robot to say.
"""

from __future__ import annotations

from collections.abc import Iterable

from rai_missions.journal.rows import Confirmation, Row, StepRow
from rai_missions.step import (
    Ask,
    CallService,
    CancelGoal,
    Effect,
    Handover,
    PublishMessage,
    SayAloud,
    StartBehaviour,
    StartGoal,
    Step,
    StopBehaviour,
    Withdraw,
)

__all__ = ("Underway", "underway", "weighty")

WEIGHTY = (StartGoal, CallService, PublishMessage, SayAloud)
OPENING = (StartGoal, CallService, Ask, StartBehaviour)
CLOSING = (Withdraw, StopBehaviour)


def weighty(step: Step) -> bool:
    """Its effects may not be carried out twice, so the journal says when they have been."""
    return any(isinstance(effect, WEIGHTY) for effect in step.effects)


class Underway:
    """What was open after a row; `follow` takes the next one."""

    def __init__(self) -> None:
        self.open: dict[int, StartGoal | CallService | Ask | StartBehaviour] = {}
        """Number → what was begun under it and has not ended, in the order in which it was begun."""
        self.accepted: set[int] = set()
        """Of these, the goals that their server has accepted."""
        self.canceled: set[int] = set()
        """Of these, the goals whose end was asked for."""
        self.unsure: tuple[Effect, ...] = ()
        """The effects of the last step, where nothing says that they were carried out."""
        self.handover: Handover | None = None
        """Asked for and not acknowledged."""
        self.holder_by = ""
        """Who had control handed over last."""

    def follow(self, row: Row) -> None:
        """Take the next row."""
        if isinstance(row, Confirmation):
            self.unsure = ()
        elif isinstance(row, StepRow):
            self._step(row.step)

    def _step(self, step: Step) -> None:
        event = step.event
        if event.kind in ("result", "proposal", "behaviour"):
            self._close(event.number)
        elif event.kind == "accepted" and event.number in self.open:
            self.accepted.add(event.number)
        elif event.kind == "control":
            self.holder_by = str(event.data.get("by", ""))
            if self.handover is not None and self.handover.to == event.name:
                self.handover = None
        for effect in step.effects:
            self._effect(effect)
        is_done = event.kind == "command" and event.name == "kill"  # a kill is written after it was carried out
        self.unsure = step.effects if weighty(step) and not is_done else ()

    def _effect(self, effect: Effect) -> None:
        if isinstance(effect, OPENING):
            number = effect.question.number if isinstance(effect, Ask) else effect.number
            self.open[number] = effect
        elif isinstance(effect, CLOSING):
            self._close(effect.number)
        elif isinstance(effect, CancelGoal):
            self.canceled.add(effect.number)
        elif isinstance(effect, Handover):
            self.handover = effect

    def _close(self, number: int) -> None:
        self.open.pop(number, None)
        self.accepted.discard(number)
        self.canceled.discard(number)


def underway(rows: Iterable[Row]) -> Underway:
    """What a journal's rows leave open."""
    found = Underway()
    for row in rows:
        found.follow(row)
    return found

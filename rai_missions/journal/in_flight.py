# SPDX-License-Identifier: Apache-2.0
"""What a run had under way when its journal ends: started and not ended, asked and not answered, not surely done.

Rule: it is read from rows alone. Whether any of it still continues is for the robot to state.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.engine.step import (
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
from rai_missions.event import Event, is_e_stop
from rai_missions.journal.rows import Confirmation, JournalRow, StepRow

__all__ = ("InFlight", "needs_confirmation")

WEIGHTY = (StartGoal, CallService, PublishMessage, SayAloud)
OPENING = (StartGoal, CallService, Ask, StartBehaviour)
CLOSING = (Withdraw, StopBehaviour)
SPOKEN = frozenset({"accepted", "feedback", "result"})
"""Kinds of events by which a server shows that it was reached."""


def needs_confirmation(step: Step) -> bool:
    """Whether a step has effects that may not be carried out twice: the journal then notes that they were."""
    return any(isinstance(effect, WEIGHTY) for effect in step.effects)


class InFlight:
    """What was open after a row; `follow` takes the next one."""

    def __init__(self) -> None:
        self.open: dict[int, StartGoal | CallService | Ask | StartBehaviour] = {}
        """Number → what was begun under it and has not ended, in the order in which it was begun."""
        self.accepted: set[int] = set()
        """Of these, the goals that their server has accepted."""
        self.canceled: set[int] = set()
        """Of these, the goals whose end was asked for."""
        self.unsure: dict[int, tuple[Effect, ...]] = {}
        """Number of a step → those of its effects of which nothing reports that they were carried out."""
        self.handover: Handover | None = None
        """Asked for and not acknowledged."""

    def follow(self, row: JournalRow) -> None:
        """Take the next row."""
        if isinstance(row, Confirmation):
            left = self.unsure.pop(row.number, ())
            if row.how == "repeated" and (open_ends := tuple(each for each in left if isinstance(each, OPENING))):
                self.unsure[row.number] = open_ends
        elif isinstance(row, StepRow):
            self._step(row.step)

    def stop(self) -> None:
        """An e-stop, which is carried out before it is written: only goals still have an end to come.

        What waited for the disk when it came was not begun; and no one begins anything again after one.
        """
        self.open = {number: effect for number, effect in self.open.items() if isinstance(effect, StartGoal)}
        self.canceled |= self.open.keys()
        self.unsure.clear()
        self.handover = None

    @property
    def unconfirmed(self) -> tuple[Effect, ...]:
        """All effects of which nothing reports that they were carried out."""
        return tuple(effect for effects in self.unsure.values() for effect in effects)

    def _step(self, step: Step) -> None:
        event = step.event
        if event.kind in SPOKEN:
            self._settle(lambda effect: isinstance(effect, StartGoal | CallService) and effect.number == event.number)
        elif event.kind == "doubt":
            name = event.data.get("name")
            self._settle(
                lambda effect: (
                    isinstance(effect, SayAloud) or (isinstance(effect, PublishMessage) and effect.topic == name)
                )
            )
        if event.kind in ("result", "proposal", "behaviour"):
            self._close(event.number)
        elif event.kind == "accepted" and event.number in self.open:
            self.accepted.add(event.number)
        elif event.kind == "control":
            self._control(event)
        for effect in step.effects:
            self._effect(effect)
        if event.kind == "command" and event.name == "migrate":  # what was under way in the run that it continues with
            accepted = event.data.get("accepted")
            self.accepted |= {number for number in self.open if isinstance(accepted, list) and number in accepted}
        if is_e_stop(event):
            self.stop()
        else:
            weighs = tuple(effect for effect in step.effects if isinstance(effect, WEIGHTY))
            self.unsure |= {step.seq: weighs} if weighs else {}

    def _settle(self, is_settled: Callable[[Effect], bool]) -> None:
        """What came back since reports that they were carried out, or the mission has learned of the doubt."""
        left = {seq: tuple(each for each in effects if not is_settled(each)) for seq, effects in self.unsure.items()}
        self.unsure = {seq: effects for seq, effects in left.items() if effects}

    def _control(self, event: Event) -> None:
        if self.handover is not None and self.handover.to == event.name:
            self.handover = None

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

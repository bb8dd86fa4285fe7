# SPDX-License-Identifier: Apache-2.0
"""What a transition is: how a state is left, or what is done without leaving it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field, model_validator

from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.model import AnyOf, Bool, MissionModel, Seconds, StateName, Text, fault, one_or_many
from rai_missions.model.references import TRIGGER
from rai_missions.states.effects import Effect

__all__ = ("ANY_EVENT", "Effects", "Transition", "Transitions")

ANY_EVENT = "*"


def _several(given: Any) -> Any:
    return (given,) if isinstance(given, Effect) else given


Effects = Annotated[tuple[AnyOf[Effect], ...], BeforeValidator(_several)]
"""In Python a single effect needs no list."""
TriggerName = Annotated[str, Field(pattern=r"^(\*|[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*)$", strict=True)]


class Transition(MissionModel):
    """What triggers it, under which guard, where it leads and what it does on the way."""

    meant: ClassVar[Mapping[str, str]] = (
        dict.fromkeys(("target", "goto", "next"), "to")
        | dict.fromkeys(("event", "trigger", "outcome"), "on")
        | dict.fromkeys(("guard", "cond", "condition", "if"), "when")
        | dict.fromkeys(("actions", "effects"), "do")
        | {
            "delay": "after_s",
            "wait": "after_s",
            "description": "about",
        }
    )

    on: Annotated[tuple[TriggerName, ...], TRIGGER, *one_or_many] = ()
    """Events or outcomes; `*` is any declared event. Without `on` and `after_s` it fires as soon as its guard holds."""
    of: StateName | None = None
    """The state whose outcome is meant, if not that of the state it is written in."""
    after_s: Seconds | None = None
    """Seconds after the entry at which it fires, once; if the guard is not true then, it is lost."""
    when: AnyOf[Guard] | None = None
    """What must be true for it to fire."""
    to: Annotated[tuple[StateName, ...], *one_or_many] = ()
    """The target, or one a region; without one the state is not left."""
    do: Effects = ()
    """What is done on the way, in this order."""
    internal: Bool = False
    """From a compound state into itself without leaving it."""
    about: Text = ""
    """What it is for, in a sentence."""

    def __init__(
        self,
        on: str | Sequence[str] = (),
        *,
        of: str | None = None,
        after_s: float | None = None,
        when: GuardOrKey | None = None,
        to: str | Sequence[str] = (),
        do: Effect | Sequence[Effect] = (),
        internal: bool = False,
        about: str = "",
    ) -> None: ...

    @model_validator(mode="after")
    def _one_trigger(self) -> Self:
        has_event, is_timed = bool(self.on), self.after_s is not None
        if has_event and is_timed:
            raise fault("trigger", "a transition has 'on' or 'after_s', not both; write two transitions")
        if not has_event and not is_timed and self.when is None:
            raise fault(
                "trigger",
                "a transition without 'on', 'after_s' and 'when' would fire at once, always; give one of them",
            )
        if not has_event and self.of is not None:
            raise fault("of", "'of' names the state whose outcome 'on' means; give 'on' too", at=("of",))
        return self

    @property
    def eventless(self) -> bool:
        """Whether the transition fires as soon as its guard holds."""
        return not self.on and self.after_s is None

    def leads(self) -> str:
        """Where it leads, when, and what it does, in words."""
        to = f"leads to {', '.join(self.to)}" if self.to else "stays"
        guard = f" when {self.when.words()}" if self.when is not None else ""
        do = f", does {'; '.join(effect.details() for effect in self.do)}" if self.do else ""
        return f"{to}{guard}{do}"

    def words(self) -> str:
        """Trigger and guard in words."""
        trigger = " or ".join(self.on) + (f" of {self.of}" if self.of else "")
        if self.after_s is not None:
            trigger = f"after {self.after_s:g} s"
        guard = f"[{self.when.words()}]" if self.when is not None else ""
        return f"{trigger} {guard}".strip()


Transitions = tuple[Transition, ...]

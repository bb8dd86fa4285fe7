# SPDX-License-Identifier: Apache-2.0
"""A way back: to where its parent was when it was last left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, Self

from pydantic import Field, GetJsonSchemaHandler, model_validator

from rai_missions.model import fault
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State
from rai_missions.states.transition import Transition

__all__ = ("Default", "History")


class Default(Transition):
    """Where a history leads while there is no memory. Nothing triggers it, guards it or is done by it."""

    def __init__(self, to: str | Sequence[str], *, about: str = "") -> None: ...

    @model_validator(mode="after")
    def _one_trigger(self) -> Self:
        given = [word for word in type(self).model_fields if word in self.model_fields_set - {"to", "about"}]
        if given or not self.to:
            what = f"this has {', '.join(given)}" if given else "this has none"
            raise fault("default", f"a history's transition has only where it leads without memory, 'to'; {what}")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Only what its validator lets through."""
        schema = handler.resolve_ref_schema(handler(core))
        kept = {word: schema["properties"][word] for word in ("to", "about")}
        return {**schema, "properties": kept, "required": ["to"]}

    @property
    def eventless(self) -> bool:
        """Whether it fires without an event: never, it is part of entering."""
        return False

    def words(self) -> str:
        return "without memory"


class History(State, word="history"):
    """Never active itself; without memory it leads to its own transition's target, else to the parent's `initial`."""

    history: Literal["shallow", "deep"]
    """`shallow` remembers the parent's active child, `deep` all that was active inside."""
    transitions: tuple[Default, ...] = Field(default=(), max_length=1)
    """Its default, `[{"to": …}]`: inside its parent; of a `shallow` one a child."""

    def __init__(
        self,
        history: Literal["shallow", "deep"],
        *,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Default] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def title(self) -> str:
        return f"{self.history} history"

    @property
    def default(self) -> tuple[str, ...]:
        """Where it leads without memory; empty for the parent's `initial`."""
        return self.transitions[0].to if self.transitions else ()

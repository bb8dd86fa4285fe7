# SPDX-License-Identifier: Apache-2.0
"""Another mission as a state: expanded when the file is loaded, so that nothing here runs it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated

from pydantic import Field

from rai_missions.model import Json, Name, Text, Value
from rai_missions.model.references import TEMPLATE, template_words
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State
from rai_missions.states.transition import Transition

__all__ = ("Include",)


class Include(State, word="mission"):
    """A mission in a mission. Its keys and events are private unless mapped; its finals are its outcomes."""

    mission: Text
    """The file, relative to the one that names it and inside that one's folder."""
    with_: Annotated[dict[Name, Json], TEMPLATE] = Field(default_factory=dict, alias="with")
    """Its key or event → a value, or `{"from": key}` to share one of this mission's keys."""

    def __init__(
        self,
        mission: str,
        *,
        with_: Mapping[str, Value] = {},
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def activity(self) -> str:
        return f"mission {self.mission}"

    def details(self) -> Iterator[str]:
        if self.with_:
            yield f"with {template_words(self.with_)}"
        yield from super().details()

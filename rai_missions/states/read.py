# SPDX-License-Identifier: Apache-2.0
"""A request in free words, read into a goal over the things that the robot sees: `{"read": "request", …}`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

from pydantic import Field

from rai_missions.guards.analysis import Distinctions
from rai_missions.model import KeyPath, Name, Path
from rai_missions.model.references import Refers
from rai_missions.planning.examples import READINGS
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State, TypeNeed
from rai_missions.states.transition import Transition

__all__ = ("Read",)


class Read(State, word="read"):
    """Reads a request by the grammar, in the step in which it begins; nothing is asked, nothing moves.

    Where `into` holds a reading with candidates, the text may also be an answer to its question: `the second`.

    Outcomes: `succeeded`, there is a goal; `unclear`, there is a question to the person; `refused`, with a reason;
    `rejected`, the request or what is seen is unknown.
    """

    read_: Path = Field(alias="read")
    """The key that holds the request, a string."""
    over: Path
    """The key that holds what the robot sees: the goal names its things."""
    into: Annotated[Name, Refers("key", "read")]
    """The mission key that is written, an object: `goal`, `question`, `candidates`, `reason`, `about`,
    `covers_all`."""

    def __init__(
        self,
        read_: KeyPath,
        *,
        over: KeyPath,
        into: KeyPath,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "unclear", "refused", "rejected"}

    def computed(self) -> frozenset[str]:
        return frozenset(("succeeded", "unclear", "refused"))

    def computed_examples(self, outcome: str) -> Sequence[Mapping[str, Any]]:
        return READINGS[outcome]

    def type_needs(self) -> Iterator[TypeNeed]:
        yield TypeNeed("/read", self.read_, "string", "a request is read from a string")
        yield TypeNeed("/over", self.over, "object", "a request is read over what is seen, an object")
        yield TypeNeed("/into", self.into, "object", "a reading is an object")

    def distinguish(self, by: Distinctions) -> None:
        by.ask(self.read_)
        by.ask(self.over)

    def activity(self) -> str:
        return f"read {self.read_}"

    def details(self) -> Iterator[str]:
        yield f"over {self.over}, into {self.into}"
        yield from super().details()

# SPDX-License-Identifier: Apache-2.0
"""What came of a request: a goal, a question back to the person, or a refusal."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PlainSerializer

from rai_missions.model import MissionModel, Text
from rai_missions.planning.goal import Goal

__all__ = ("RequestReading",)


class RequestReading(MissionModel):
    """A request as it was read."""

    goal: Goal | None = None
    """What is wanted, where exactly one reading is sure."""
    question: Annotated[Text, Field(max_length=4000)] = ""
    """What the person is asked, where none or several are."""
    candidates: Annotated[tuple[Goal, ...], PlainSerializer(list)] = ()
    """The goals that the question offers, in its order."""
    reason: Annotated[Text, Field(max_length=64)] = ""
    """Why there is no goal: a code, such as `unknown_word`, `ambiguous`, `absent`, `forbidden`."""
    about: Annotated[Text, Field(max_length=4000)] = ""
    """The reason as a sentence."""
    covers_all: bool = False
    """Whether the goal is about all that there is of something: what is seen later belongs to it, too."""

    def __init__(
        self,
        goal: Goal | None = None,
        question: str = "",
        candidates: tuple[Goal, ...] = (),
        reason: str = "",
        about: str = "",
        covers_all: bool = False,
    ) -> None: ...

    @property
    def outcome(self) -> Literal["succeeded", "unclear", "refused"]:
        """How the reading ended."""
        return "succeeded" if self.goal is not None else "unclear" if self.question else "refused"

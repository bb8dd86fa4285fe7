# SPDX-License-Identifier: Apache-2.0
"""What a sentence may mean, as a value: an order, its repetition or correction, yes or no, a question, or a fault."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

__all__ = ("FAULT", "STOP", "Sense", "SenseKind", "is_fault")

SenseKind = Literal["order", "yes", "no", "quiet", "withdraw", "again", "other", "question", "fault"]


class Sense(NamedTuple):
    """One thing that a sentence may mean in this moment."""

    kind: SenseKind
    name: str = ""
    """The order, or the question's name in the language file."""
    mission: str = ""
    arguments: Mapping[str, Any] = {}
    question: int = 0
    """Of an answer: the number of the open question."""
    option: str = ""
    parameters: Mapping[str, Any] = {}
    key: str = ""
    """The key that a question is about, or a field of it: `obstacle.height_m`."""
    thing: str = ""
    """What a question is about that may be in a fact, in its words."""
    is_partial: bool = False
    """Only a part of an option's words was named: it is read back."""
    fault: str = ""
    """Of a `fault`: what is wrong and what would be right, in the dialogue's language."""
    named: tuple[str, ...] = ()
    """Of a start: the arguments whose values the sentence itself has; a correction may replace them."""
    lacks: tuple[str, ...] = ()
    """Of a `fault`: the arguments that the sentence gave no value which fits."""
    is_correction: bool = False
    """It is an order read before, with another value; it takes the place of that one."""
    rest: str = ""
    """What the sentence orders besides, in its words; it is not taken."""

    @property
    def identity(self) -> str:
        """Equal for the same sense, whatever the words were; two recognisers agree by it."""
        data = [
            self.kind,
            self.name,
            self.mission,
            self.arguments,
            self.question,
            self.option,
            self.parameters,
            self.key,
            self.thing,
        ]
        return json.dumps(data, sort_keys=True, default=str)


STOP = Sense("order", "stop")
FAULT = (Sense("fault"),)


def is_fault(senses: Sequence[Sense]) -> bool:
    """Whether it gives values that do not fit, and means nothing else."""
    return bool(senses) and all(sense.kind == "fault" for sense in senses)

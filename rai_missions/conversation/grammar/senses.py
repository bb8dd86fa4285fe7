# SPDX-License-Identifier: Apache-2.0
"""What a sentence may mean, as a value: an order, its repetition or correction, yes or no, a question, or a fault."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

__all__ = ("FAULT", "STOP", "Sense", "SenseKind", "is_fault", "joined")

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
    """Only a part of an option's words was named, or a yes is doubtful: the order is read back."""
    fault: str = ""
    """Of a `fault`: what is wrong and what would be right, in the dialogue's language."""
    named: tuple[str, ...] = ()
    """Of a start: the arguments whose values the sentence itself has; a correction may replace them."""
    lacks: tuple[str, ...] = ()
    """Of a `fault`: the arguments that the sentence gave no value which fits."""
    is_correction: bool = False
    """It is an order read before, with another value; it takes the place of that one."""
    then: tuple[Sense, ...] = ()
    """What the sentence means besides: orders, each of which follows the one before it, and questions."""
    rest: str = ""
    """The end of the sentence, in its words, where that is not read."""

    @property
    def each(self) -> tuple[Sense, ...]:
        """What the sentence means, one by one."""
        return (self._replace(then=()), *self.then) if self.then else (self,)

    @property
    def orders(self) -> tuple[Sense, ...]:
        """The orders that it is, in their turn."""
        return tuple(sense for sense in self.each if sense.kind == "order")

    @property
    def asked(self) -> tuple[Sense, ...]:
        """The questions that it is."""
        return tuple(sense for sense in self.each if sense.kind == "question")

    @property
    def is_stop(self) -> bool:
        """Whether it orders to stop; a stop is the first of what a sentence means."""
        return self.kind == "order" and self.name == "stop"

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
            [each.identity for each in self.then],
        ]
        return json.dumps(data, sort_keys=True, default=str)


STOP = Sense("order", "stop")
FAULT = (Sense("fault"),)


def is_fault(senses: Sequence[Sense]) -> bool:
    """Whether it gives values that do not fit, and means nothing else."""
    return bool(senses) and all(sense.kind == "fault" for sense in senses)


def joined(each: Sequence[Sense]) -> Sense:
    """What several parts of a sentence mean together, with what counts first ahead: the first order, or question.

    A stop comes first, and what was ordered ahead of it is dropped. One order given twice in turn is one.
    """
    parts = [part for part, before in zip(each, (None, *each), strict=False) if part != before]
    stops = [at for at, part in enumerate(parts) if part.is_stop]
    orders = [part for part in parts[stops[0] if stops else 0 :] if part.kind == "order"]
    first, *then = [*orders, *(part for part in parts if part.kind != "order")]
    return first._replace(then=tuple(then)) if then else first

# SPDX-License-Identifier: Apache-2.0
"""Answers in free words: to an option that takes one text, such as the request in other words.

Rule: what does not begin with the option's name is read back, for it may be meant otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.engine.decision import Offer, Question

__all__ = ("TextOption", "is_ordinal", "text_option")


class TextOption(NamedTuple):
    """An option of an open question that is chosen by a text, and the parameter that holds it."""

    question: Question
    offer: Offer
    parameter: str

    def named(self, words: Sequence[str]) -> Sense | None:
        """The answer that is the option's name and a text; None where the words are another."""
        name = spoken(self.offer.name).split()
        rest = words[len(name) :]
        is_named = rest and list(words[: len(name)]) == name
        return self.free(rest)._replace(is_partial=False) if is_named else None

    def free(self, words: Sequence[str]) -> Sense:
        """The answer in these words, to be read back."""
        values = {self.parameter: " ".join(words)}
        return Sense(
            "order",
            "answer",
            question=self.question.number,
            option=self.offer.name,
            parameters=values,
            is_partial=True,
        )


def is_ordinal(words: Sequence[str], language: Language) -> bool:
    """Whether a whole sentence is an ordinal, `the second`; options that take a text are counted by numbers."""
    bare = language.without_articles(words)
    return len(bare) == 1 and not bare[0].isdigit() and bare[0] in language.data["ordinals"]


def text_option(questions: Sequence[Question]) -> TextOption | None:
    """The option of the open questions that takes one text; None where there is none, or several."""
    found = [
        TextOption(question, offer, parameter)
        for question in questions
        for offer in question.options
        if (parameter := _text_parameter(offer))
    ]
    return found[0] if len(found) == 1 else None


def _text_parameter(offer: Offer) -> str:
    schema = offer.parameters or {}
    required: Sequence[str] = schema.get("required") or ()
    if len(required) != 1:
        return ""
    form: Mapping[str, Any] = (schema.get("properties") or {}).get(required[0]) or {}
    is_free = form.get("type") == "string" and not {"enum", "const", "pattern", "format"} & form.keys()
    return required[0] if is_free else ""

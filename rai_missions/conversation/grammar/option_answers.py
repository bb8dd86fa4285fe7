# SPDX-License-Identifier: Apache-2.0
"""Answers to open questions: the option that words name, its parameters, or the text that is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rai_missions.conversation.grammar.arguments import (
    BadValue,
    amount,
    amounts_in,
    key_value,
    parameter_keys,
    read_arguments,
)
from rai_missions.conversation.grammar.free_answers import TextOption, is_ordinal, text_option
from rai_missions.conversation.grammar.names import option_named
from rai_missions.conversation.grammar.option_senses import OptionSenses
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import KeyView, StatusView
from rai_missions.engine.decision import Offer, Question

__all__ = ("OptionAnswers",)


class OptionAnswers:
    """Reads answers of one language.

    Args:
        language: Its data.
    """

    def __init__(self, language: Language) -> None:
        self._language, self._senses = language, OptionSenses(language)
        self._no_count = language.articles.union(language.data["substitutes"])

    def senses(self, words: list[str], view: StatusView) -> list[Sense]:
        """What it answers: the one open question that has such an option; of several the oldest, to be read back."""
        each = [self._answers_to(question, words) for question in view.questions]
        found = [sense for sense in each if sense is not None]
        whole = [sense for sense in found if not sense.is_partial]
        chosen = (whole or found)[:1]
        return chosen if len(whole or found) < 2 else [sense._replace(is_partial=True) for sense in chosen]

    def by_sense(self, text: str, view: StatusView) -> list[Sense]:
        """What a sentence answers by the sense of its words, each to be read back."""
        return [
            self._with_amounts(offer, words)._replace(question=question.number, is_partial=True)
            for question in view.questions
            for offer, words in self._senses.asked_for(text, question.options)
        ]

    def are_in(self, text: str, view: StatusView) -> bool:
        """Whether a sentence has own words of an option."""
        return any(self._senses.are_in(text, question.options) for question in view.questions)

    def fits(self, words: list[str], questions: Sequence[Question]) -> bool:
        """Whether the words answer one of these questions by a whole option."""
        found = (self._answers_to(question, words) for question in questions)
        return any(sense is not None and not sense.is_partial for sense in found)

    def _answers_to(self, question: Question, words: list[str]) -> Sense | None:
        found, text = list[Sense](), text_option([question])
        if text is not None and is_ordinal(words, self._language):
            return text.free(words)
        for slots in self._language.answer.match(words):
            named = option_named(slots["option"].split(), question.options, self._language)
            is_text = text is not None and named is not None and named.is_partial and named.offer is text.offer
            if named is not None and not is_text:
                found.append(self._answer(named.offer, is_partial=named.is_partial))
        whole = [sense for sense in found if not sense.is_partial]
        found = whole or found or self._with_values(words, question.options) or self._with_text(words, text)
        return found[0]._replace(question=question.number) if found else None

    def _answer(self, offer: Offer, *, is_partial: bool, words: Sequence[str] = ()) -> Sense:
        try:
            values = read_arguments(words, parameter_keys(offer), self._language, owner=offer.name)
        except BadValue as error:
            return Sense("fault", "answer", fault=str(error))
        return self._given(offer, values, is_partial=is_partial)

    def _with_amounts(self, offer: Offer, words: Sequence[str]) -> Sense:
        """An option with the values of its parameters that a clause has: `honk twice`, `wait ten minutes`."""
        values, keys = dict[str, Any](self._listed(offer, words)), parameter_keys(offer)
        numbers = [key for key in keys if key.type in ("integer", "number")]
        for key in numbers:
            spans = list(amounts_in(words, key, self._language)) or self._bare_number(words, numbers)
            try:
                values |= [(key.name, key_value(span, key, self._language)) for span in spans[:1]]
            except BadValue as error:
                return Sense("fault", "answer", fault=str(error))
        return self._given(offer, values, is_partial=True)

    def _listed(self, offer: Offer, words: Sequence[str]) -> Iterator[tuple[str, Any]]:
        """The parameters of which a clause names one of the values that they list."""
        properties: Mapping[str, Mapping[str, Any]] = (offer.parameters or {}).get("properties") or {}
        for name, each in properties.items():
            ways = {value: self._language.normaliser.words(spoken(str(value))) for value in each.get("enum", ())}
            named = [
                value for value, way in ways.items() if any(words[at:][: len(way)] == way for at in range(len(words)))
            ]
            yield from [(name, named[0])] if len(named) == 1 else []

    def _bare_number(self, words: Sequence[str], numbers: Sequence[KeyView]) -> list[list[str]]:
        """The one number of a clause, where an option takes one, and no other thing is counted."""
        counted = (at for at, word in enumerate(words) if amount([word], numbers[0], self._language) is not None)
        places = [at for at in counted if words[at] not in self._no_count]
        if len(places) != 1 or len(numbers) != 1:
            return []
        (at,) = places
        is_last = all(not self._language.meanings(word) for word in words[at + 1 : at + 2])
        return [[words[at]]] if is_last else []

    def _given(self, offer: Offer, values: Mapping[str, Any], *, is_partial: bool) -> Sense:
        """The option with these values; a fault where it requires more."""
        required: Sequence[str] = (offer.parameters or {}).get("required") or ()
        lacking = [spoken(name) for name in required if name not in values]
        if lacking:
            names = self._language.listed(lacking)
            return Sense(
                "fault", "answer", fault=self._language.text("needs_values", option=spoken(offer.name), names=names)
            )
        return Sense("order", "answer", option=offer.name, parameters=values, is_partial=is_partial)

    def _with_values(self, words: list[str], options: Sequence[Offer]) -> list[Sense]:
        taking = [offer for offer in options if offer.parameters]
        for slots in self._language.with_values.match(words) if taking else ():
            for way in self._language.answer.match(slots["option"].split()):
                named = option_named(way["option"].split(), taking, self._language)
                if named is not None:
                    return [self._answer(named.offer, is_partial=named.is_partial, words=slots["arguments"].split())]
        return []

    def _with_text(self, words: list[str], text: TextOption | None) -> list[Sense]:
        if text is None:
            return []
        found = (text.named(slots["option"].split()) for slots in self._language.answer.match(words))
        return [sense for sense in found if sense is not None][:1]

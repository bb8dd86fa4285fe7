# SPDX-License-Identifier: Apache-2.0
"""Answers to open questions: the option that words name, its parameters, or the text that is asked for."""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.conversation.grammar.arguments import IN_WORDS, BadValue, read_arguments
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
            self._answer(offer, is_partial=True)._replace(question=question.number)
            for question in view.questions
            for offer in self._senses.asked_for(text, question.options)
        ]

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
        schema = offer.parameters or {}
        properties = schema.get("properties") or {}
        if not words and not schema.get("required"):
            return Sense("order", "answer", option=offer.name, is_partial=is_partial)
        kinds = {name: str(each.get("type")) for name, each in properties.items()}
        keys = [KeyView(name, kind if kind in IN_WORDS else "object") for name, kind in kinds.items()]  # type: ignore[arg-type]
        try:
            values = read_arguments(words, keys, self._language, owner=offer.name)
        except BadValue as error:
            return Sense("fault", "answer", fault=str(error))
        lacking = [spoken(name) for name in schema.get("required") or () if name not in values]
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

# SPDX-License-Identifier: Apache-2.0
"""The mission's open questions in words: with their options, by the numbers that answer them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.values import about_words
from rai_missions.engine.decision import Question
from rai_missions.plain_data import at_path
from rai_missions.redaction import cut

__all__ = ("options_text", "question_text")

LONGEST_EVIDENCE = 500
"""Characters of a text that is spoken with a question."""


def question_text(question: Question, language: Language, asked_with: Sequence[str] = ()) -> str:
    """The question with its options, numbered.

    Args:
        question: An open one.
        language: Its templates.
        asked_with: The evidence whose text is spoken with it.
    """
    lines = list[str]()
    for number, offer in enumerate(question.options, start=1):
        name, about = spoken(offer.name), about_words(offer.about)
        form = "option_about" if about and about != name else "option"
        lines.append(language.text(form, number=number, name=name, about=about))
    text = " ".join([question.text.strip(), *_evidence_texts(question, asked_with)])
    return language.text("question", question=text, options="; ".join(lines))


def _evidence_texts(question: Question, asked_with: Sequence[str]) -> Iterator[str]:
    """The texts among its evidence that are spoken with it."""
    values = {each.key: each.value for each in question.evidence}
    for path in asked_with:
        value = at_path(values, path)
        if isinstance(value, str) and value.strip():
            yield cut(value.strip(), LONGEST_EVIDENCE)


def options_text(questions: Sequence[Question], language: Language) -> str:
    """The names of the options of all questions, numbered in each."""
    numbered = [(number, offer) for each in questions for number, offer in enumerate(each.options, start=1)]
    return "; ".join(language.text("option", number=number, name=spoken(offer.name)) for number, offer in numbered)

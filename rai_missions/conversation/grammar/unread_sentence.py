# SPDX-License-Identifier: Apache-2.0
"""Sentences that no rule reads: a question, a statement or neither, and what they are about."""

from __future__ import annotations

from typing import Literal, NamedTuple

from rai_missions.conversation.language.language import Language

__all__ = ("UnreadSentence", "is_question", "unread_sentence")

SentenceKind = Literal["question", "statement", "other"]
LEAST_WORDS = 2
"""Words of the shortest statement."""


class UnreadSentence(NamedTuple):
    """The kind of a sentence, and what it is about: the subject of a statement, or all words of a question."""

    kind: SentenceKind
    subject: tuple[str, ...] = ()


def unread_sentence(text: str, language: Language) -> UnreadSentence:
    """The kind of a sentence, by its first word, its sign at the end, and the place of its verb."""
    words = language.normaliser.bare(language.normaliser.words(text))
    is_forbidding = bool(language.negations.intersection(words[1:2]))  # `do not`
    is_asking = bool(words) and words[0] in language.data["asking"] and not is_forbidding
    if text.rstrip().endswith("?") or is_asking:
        return UnreadSentence("question", tuple(words))
    if len(words) < LEAST_WORDS or language.wish.fits(words):
        return UnreadSentence("other")
    found = next(language.statement.match(words), None)
    return UnreadSentence("other" if found is None else "statement", tuple((found or {}).get("thing", "").split()))


def is_question(text: str, language: Language) -> bool:
    """Whether a sentence that no rule reads asks for something."""
    return unread_sentence(text, language).kind == "question"

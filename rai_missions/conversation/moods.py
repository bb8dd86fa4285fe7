# SPDX-License-Identifier: Apache-2.0
"""What kind of sentence it is that the rules do not read: a question, a statement, or anything else.

Rule: a statement of a person is no fact. It changes no state, and the answer to it rests on what the robot reports.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from rai_missions.conversation.language import Language

__all__ = ("Mood", "MoodKind", "mood_of")

MoodKind = Literal["question", "statement", "other"]
LEAST_WORDS = 2
"""Words of the shortest statement."""


class Mood(NamedTuple):
    """The kind of a sentence, and what it is about: the subject of a statement, or all words of a question."""

    kind: MoodKind
    subject: tuple[str, ...] = ()


def mood_of(text: str, language: Language) -> Mood:
    """The mood of a sentence, by its first word, its sign at the end, and the place of its verb."""
    words = language.normaliser.bare(language.normaliser.words(text))
    if text.rstrip().endswith("?") or (words and words[0] in language.data["asking"]):
        return Mood("question", tuple(words))
    if len(words) < LEAST_WORDS or language.wish.fits(words):
        return Mood("other")
    found = next(language.statement.match(words), None)
    return Mood("other") if found is None else Mood("statement", tuple(found.get("thing", "").split()))

# SPDX-License-Identifier: Apache-2.0
"""Answers to sentences that no rule reads: what kind they are, and what the robot reports of that which they are about.

Rule: a statement of a person is no fact. It changes no state, and the answer to it rests on what the robot reports.
"""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.conversation.answers.state_answers import StateAnswers
from rai_missions.conversation.grammar.names import key_named
from rai_missions.conversation.grammar.unread_sentence import unread_sentence
from rai_missions.conversation.language.values import key_sentence
from rai_missions.conversation.view import StatusView

__all__ = ("UnreadAnswers",)

OPENINGS = {"question": "unknown", "statement": "statement", "other": "unread"}
"""Kind of a sentence → the text that an answer to it begins with."""


class UnreadAnswers:
    """Answers sentences that no rule reads.

    Args:
        answers: What the robot reports.
    """

    def __init__(self, answers: StateAnswers) -> None:
        self._answers, self._language = answers, answers.language

    def answer(self, text: str, view: StatusView, *, is_first: bool) -> str:
        """The answer to a sentence, with what the robot reports of that which it is about.

        Args:
            text: The sentence.
            view: The run.
            is_first: It is the first such sentence of the conversation: what is read is named.
        """
        language, sentence = self._language, unread_sentence(text, self._language)
        parts = [language.text(OPENINGS[sentence.kind])]
        if sentence.kind == "question":
            if facts := self._answers.nearest(sentence.subject, view):
                return facts
            parts += [self._asked(sentence.subject, view)]
        elif facts := self._reported(sentence.subject, view):
            parts += [language.text("reported", facts=facts)]
        parts += [language.text("unknown_more")] if is_first else []
        return " ".join(filter(None, parts))

    def knows(self, text: str, view: StatusView) -> bool:
        """Whether facts answer a sentence that asks for them, and for nothing to be done: `how hot is the hob?`.

        Args:
            text: The sentence.
            view: The run.
        """
        sentence, words = unread_sentence(text, self._language), self._language.normaliser.words(text)
        is_request = not set(self._language.data["requesting"]).isdisjoint(words)
        return sentence.kind == "question" and not is_request and bool(self._answers.nearest(sentence.subject, view))

    def _asked(self, words: Sequence[str], view: StatusView) -> str:
        """The robot's own state, where a question is put to it; else nothing."""
        return self._answers.status(view) if set(words) & set(self._language.data["addressing"]) else ""

    def _reported(self, subject: Sequence[str], view: StatusView) -> str:
        """What the robot reports of the subject of a statement: a key, its own state, or the facts that name it."""
        if subject and subject[0] in self._language.data["addressed"]:
            return self._answers.status(view)
        if not subject or subject[-1] in self._language.data["pronouns"]:
            return ""
        path = key_named(subject, view.keys, self._language, strict=True)
        return key_sentence(path, view.keys, self._language) if path else " ".join(self._answers.facts(subject, view))

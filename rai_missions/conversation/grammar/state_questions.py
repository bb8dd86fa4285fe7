# SPDX-License-Identifier: Apache-2.0
"""Questions of state: which of a language, or of the robot's own, words are, and which key they are about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rai_missions.conversation.grammar.names import key_asked, key_named, key_within
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language
from rai_missions.conversation.view import StatusView

__all__ = ("ALWAYS", "StateQuestions")

ALWAYS = ("hello", "thanks", "bye", "sorry", "rude")
"""Questions, or what is none, whose answer is always the same: the text of that name."""


class StateQuestions:
    """Reads questions of one language.

    Args:
        language: Its data.
        own: Questions of the robot's own → the key, or the field of one, whose value answers them.

    Raises:
        UsageError: A question is not closed, or names a part that does not exist.
    """

    def __init__(self, language: Language, own: Mapping[str, str]) -> None:
        self._language = language
        self._own = [(language.own_phrases([each]), path) for each, path in own.items()]
        self.words = frozenset(word for each, _ in self._own for word in each.words)

    def sense(self, words: list[str], view: StatusView) -> Sense | None:
        """The question that the words are; None for any other words."""
        for own, path in self._own:
            if path.partition(".")[0] in view.keys and own.fits(words):
                return Sense("question", "value", key=path)
        if path := key_asked(words, view.keys, self._language):
            return Sense("question", "key", key=path)
        read = (
            self._read(name, slots, words, view)
            for name, phrases in self._language.questions.items()
            for slots in phrases.match(words)
        )
        return next(filter(None, read), None)

    def by_sense(self, text: str, view: StatusView) -> Sense | None:
        """The question in a clause that asks in words of its own, by what it asks for; None in any other sentence."""
        for clause in self._language.normaliser.remarks(text):
            openings = list(self._language.normaliser.openings(self._language.normaliser.words(clause))) or [[""]]
            words, is_asked = openings[0], any(map(self._is_asking, openings)) or clause.rstrip().endswith("?")
            for name, phrases in self._language.question_senses.items() if is_asked else ():
                path = key_within(words, view.keys, self._language) if name == "key" else ""
                if phrases.within(words) and (path or name != "key"):
                    return Sense("question", name, key=path)
        return None

    def _is_asking(self, words: Sequence[str]) -> bool:
        """Whether a clause begins with a word that asks, `where`, or a preposition and such a word: `in which`."""
        data = self._language.data
        is_within = len(words) > 1 and words[0] in data["prepositions"]
        return words[is_within] in data["asking"]

    def _read(self, name: str, slots: Mapping[str, str], words: list[str], view: StatusView) -> Sense | None:
        """The question of that name, where its slots name a thing or a key that there is."""
        if thing := slots.get("thing", "").split():
            is_named = thing[0] not in self._language.data["pronouns"] and self._language.without_articles(thing)
            return self._thing(name, thing, view) if is_named else None
        if "key" not in slots:
            return Sense("question", name)
        named, done, of = (slots.get(slot, "").split() for slot in ("key", "done", "of"))
        if of:  # `how humid is the air`: one key has both in its name or its `about`
            path = key_named([*named, *of], view.keys, self._language)
            return Sense("question", name, key=path) if path else None
        path = self._key_done(named, done, view) if done else ""
        path = path or key_named(named, view.keys, self._language, strict=len(named) == len(words))
        return Sense("question", name, key=path) if path else None

    def _key_done(self, named: list[str], done: list[str], view: StatusView) -> str:
        """The key that counts what was done: `alleys driven` for `how many alleys did you drive`."""
        for ending in ("", *self._language.data["participle_endings"]):
            if path := key_named(
                [*named, *done[:-1], done[-1] + ending], view.keys, self._language, strict=bool(ending)
            ):
                return path
        return ""

    def _thing(self, name: str, thing: list[str], view: StatusView) -> Sense:
        """A question about a thing: of a key of that name, or of whatever fact has it."""
        path = key_named(thing, view.keys, self._language, strict=True)
        return Sense("question", "key", key=path) if path else Sense("question", name, thing=" ".join(thing))

# SPDX-License-Identifier: Apache-2.0
"""Questions of state: which of a language, or of the robot's own, words are, and which key they are about."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rai_missions.conversation.language import Language
from rai_missions.conversation.names import key_named
from rai_missions.conversation.senses import Sense
from rai_missions.conversation.view import StatusView

__all__ = ("StateQuestions",)


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

    def senses(self, words: list[str], view: StatusView) -> Iterator[Sense]:
        """The one question that the words are."""
        for own, path in self._own:
            if path.partition(".")[0] in view.keys and own.fits(words):
                yield Sense("question", "value", key=path)
                return
        for name, phrases in self._language.questions.items():
            for slots in phrases.match(words):
                if thing := slots.get("thing", "").split():
                    if thing[0] in self._language.data["pronouns"] or not self._language.without_articles(thing):
                        continue
                    yield self._thing(name, thing, view)
                    return
                if "key" not in slots:
                    yield Sense("question", name)
                    return
                named, done = slots["key"].split(), slots.get("done", "").split()
                path = self._key_done(named, done, view) if done else ""
                path = path or key_named(named, view, self._language, strict=len(named) == len(words))
                if path:
                    yield Sense("question", name, key=path)
                    return

    def _key_done(self, named: list[str], done: list[str], view: StatusView) -> str:
        """The key that counts what was done: `alleys driven` for `how many alleys did you drive`."""
        for ending in ("", *self._language.data["participle_endings"]):
            if path := key_named([*named, *done[:-1], done[-1] + ending], view, self._language, strict=bool(ending)):
                return path
        return ""

    def _thing(self, name: str, thing: list[str], view: StatusView) -> Sense:
        """A question about a thing: of a key of that name, or of whatever fact has it."""
        path = key_named(thing, view, self._language, strict=True)
        return Sense("question", "key", key=path) if path else Sense("question", name, thing=" ".join(thing))

# SPDX-License-Identifier: Apache-2.0
"""What a robot calls a start with arguments: `go to the {place}` for the task go and a place.

Rule: a text that is used gives every argument of the order; where none does, the order is spoken with its arguments.
Of a run, whose arguments all have values, it may leave out those that have their initial value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

from rai_missions.conversation.arguments import IN_WORDS
from rai_missions.conversation.language import Language, spoken
from rai_missions.conversation.start_phrases import SLOT, Names
from rai_missions.conversation.values import value_words
from rai_missions.conversation.view import KeyView

__all__ = ("SpokenStart", "SpokenStarts", "arguments_spoken")


class SpokenStart(NamedTuple):
    """A text, and the starts that it is for."""

    text: str
    """`{key}` is the value of an argument, in words."""
    arguments: Mapping[str, Any] = {}
    """The arguments that such a start has, without a place in the text."""


def arguments_spoken(form: SpokenStart) -> frozenset[str]:
    """Every argument that a text gives."""
    return frozenset(SLOT.findall(form.text)) | form.arguments.keys()


class SpokenStarts:
    """The texts of a profile.

    Args:
        forms: Each of them; the first that gives all arguments of a start is used.
        names: Argument → the words for each of its values.
        language: Its numbers.
    """

    def __init__(self, forms: Sequence[SpokenStart], names: Names, language: Language) -> None:
        self._forms, self._names, self._language = forms, names, language

    def words(
        self, given: Mapping[str, Any], keys: Mapping[str, KeyView], initial: AbstractSet[str] = frozenset()
    ) -> str:
        """What a start is called; empty where no text gives all of its arguments.

        Args:
            given: The arguments of the start.
            keys: The arguments of its mission.
            initial: Which of the given ones have their initial value: a text may leave them out.
        """
        for form in self._forms:
            has_all = given.keys() - initial <= arguments_spoken(form) <= given.keys()
            if has_all and all(given[name] == each for name, each in form.arguments.items()):
                slots = [keys.get(name, KeyView(name, "string")) for name in SLOT.findall(form.text)]
                if all(key.type in IN_WORDS for key in slots):
                    words = {key.name: self._value(given[key.name], key) for key in slots}
                    return SLOT.sub(lambda found, words=words: words[found[1]], form.text)  # type: ignore[misc]
        return ""

    def _value(self, value: Any, key: KeyView) -> str:
        named = (spoken(words) for words, meant in self._names.get(key.name, {}).items() if meant == value)
        return next(named, "") or value_words(value, key, self._language)

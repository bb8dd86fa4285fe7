# SPDX-License-Identifier: Apache-2.0
"""What a robot calls a start with arguments: `go to the {place}` for the task go and a place.

Rule: a text that is used gives every argument of the order; where none does, the order is spoken with its arguments.
Of a run, whose arguments all have values, it may leave out those that have their initial value.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.conversation.grammar.arguments import IN_WORDS
from rai_missions.conversation.grammar.start_phrases import Names, arguments_of
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.phrases import SLOT
from rai_missions.conversation.language.values import value_words
from rai_missions.conversation.view import KeyView
from rai_missions.profile.conversation import SentenceArguments

__all__ = ("SpokenStarts",)


class SpokenStarts:
    """The texts of a profile.

    Args:
        forms: Each of them, with `{key}` for an argument in words → the arguments that such a start has besides; the
            first that gives all arguments of a start is used.
        names: Argument → the words for each of its values.
        language: Its numbers.
    """

    def __init__(self, forms: SentenceArguments, names: Names, language: Language) -> None:
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
        for text, arguments in self._forms.items():
            named = SLOT.findall(text)
            has_all = given.keys() - initial <= arguments_of(frozenset(named), arguments) <= given.keys()
            if has_all and all(given[name] == each for name, each in arguments.items()):
                slots = [keys.get(name, KeyView(name, "string")) for name in named]
                if all(key.type in IN_WORDS for key in slots):
                    parts = SLOT.split(text)  # texts at the even places, slots at the odd ones
                    for place, key in enumerate(slots):
                        parts[2 * place + 1] = self._value(given[key.name], key, before=parts[2 * place + 2])
                    return "".join(parts)
        return ""

    def _value(self, value: Any, key: KeyView, before: str) -> str:
        """A value in words, without its unit before a text that begins with it."""
        named = (spoken(each) for each, meant in self._names.get(key.name, {}).items() if meant == value)
        unit, text = self._language.unit_of(key.name), before.lstrip()
        is_written = any(
            size == 1 and text.startswith(word) and not text[len(word) :][:1].isalnum()
            for word, size in self._language.factors(unit).items()
        )
        words = next(named, "") or value_words(value, key, self._language)
        return words.removesuffix(f" {unit}") if is_written else words

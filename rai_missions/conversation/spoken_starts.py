# SPDX-License-Identifier: Apache-2.0
"""What a robot calls a start with arguments: `go to the {place}` for the task go and a place.

Rule: a text that is used gives every argument of the order; where none does, the order is spoken with its arguments.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.conversation.arguments import IN_WORDS
from rai_missions.conversation.language import Language, spoken
from rai_missions.conversation.values import value_words
from rai_missions.conversation.view import KeyView

__all__ = ("SpokenStart", "arguments_spoken", "spoken_start")

SLOT = re.compile(r"\{(\w+)\}")

Names = Mapping[str, Mapping[str, Any]]


class SpokenStart(NamedTuple):
    """A text, and the starts that it is for."""

    text: str
    """`{key}` is the value of an argument, in words."""
    arguments: Mapping[str, Any] = {}
    """The arguments that such a start has, without a place in the text."""


def arguments_spoken(form: SpokenStart) -> frozenset[str]:
    """Every argument that a text gives."""
    return frozenset(SLOT.findall(form.text)) | form.arguments.keys()


def spoken_start(
    forms: Sequence[SpokenStart],
    names: Names,
    given: Mapping[str, Any],
    keys: Mapping[str, KeyView],
    language: Language,
) -> str:
    """The first text that gives all arguments of a start; empty where none does.

    Args:
        forms: Of the profile.
        names: Argument → the words for each of its values.
        given: The arguments of the start.
        keys: The arguments of its mission.
        language: Its numbers.
    """
    for form in forms:
        if arguments_spoken(form) == given.keys() and all(given[name] == each for name, each in form.arguments.items()):
            slots = [keys.get(name, KeyView(name, "string")) for name in SLOT.findall(form.text)]
            if all(key.type in IN_WORDS for key in slots):
                words = {key.name: _words(given[key.name], key, names, language) for key in slots}
                return SLOT.sub(lambda found, words=words: words[found[1]], form.text)  # type: ignore[misc]
    return ""


def _words(value: Any, key: KeyView, names: Names, language: Language) -> str:
    named = (spoken(words) for words, meant in names.get(key.name, {}).items() if meant == value)
    return next(named, "") or value_words(value, key, language)

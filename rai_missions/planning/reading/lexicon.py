# SPDX-License-Identifier: Apache-2.0
"""Words of a language as data: what each phrase may be in a request; one file each in `languages/`.

Rule: no word and no sentence of a language is in code; a new language is a new file, and word forms of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.planning.reading.phrases import Unread
from rai_missions.planning.text.language_file import LanguageTexts, language_codes, language_file, word_forms
from rai_missions.planning.text.normalise import each_way, is_near, is_slip

__all__ = ("Noun", "Vocabulary", "WordSense", "lexicon", "lexicons")

FOLDER = Path(__file__).parent / "languages"
REPEATED = re.compile(r"(.)\1\1+")
"""A letter that is drawn out: `pleeease`."""
VERBS = frozenset({"put", "stack", "sort", "group", "apart", "swap", "grasp", "toss", "fill", "unstack"})
"""Kinds of words that may have what is before a verb written together with it."""
SHORTEST_NEAR = 4
"""Letters of the shortest word that another one is taken for, when it is asked whether it is meant."""


class Noun(NamedTuple):
    """What a noun covers."""

    types: frozenset[str]
    """Types of things; empty for a noun such as `thing` that may be any."""
    is_many: bool | None
    """Whether it means all that there are: `cubes`, `fruit`; None where the article decides: `die Würfel`."""


class WordSense(NamedTuple):
    """What a phrase is to the grammar."""

    kind: str
    """Such as `relation`, `noun`, `colour`; the sections of the language's file."""
    value: Any
    """Which one: `left_of`, a `Noun`, `red`."""


class Vocabulary(LanguageTexts):
    """The phrases of one language.

    Args:
        data: The file's content, and the language's word forms.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        super().__init__(data)
        self.units: Mapping[str, float] = {name: float(size) for size, names in data["units"].items() for name in names}
        self.phrases: Mapping[tuple[str, ...], WordSense] = {
            tuple(words): meaning for phrase, meaning in _phrases(data) for words in each_way(phrase)
        }
        self._longest = max(map(len, self.phrases))
        self.words = frozenset(word for phrase in self.phrases for word in phrase) | frozenset(self.units)
        self._by_letter = dict[str, list[str]]()
        for word in sorted(self.words):
            self._by_letter.setdefault(word[0], []).append(word)
        self.turning = frozenset(data["turning"])
        """Words that are not read and turn what they are about, so that nothing is offered without them."""
        self.cutting = frozenset(data["cutting"])
        """Words that are not read and may say where a thing is to be, so that what is after them is not offered."""
        self.number_words = frozenset(data["numbers"]) | frozenset(data["hundred"]) | {data["minus"]}

    def unread(self, text: str = "unread", *values: object, reason: str = "", refused: bool = False) -> Unread:
        """What a request is not read for, in the language's words.

        Args:
            text: The name of the sentence.
            values: For its places, in their order.
            reason: Its code, where that is not the sentence's name.
            refused: Whether it is refused and not asked back.
        """
        return Unread(reason or text, self.text(text, *values), refused=refused)

    def longest(self, words: Sequence[str], at: int) -> tuple[int, WordSense] | None:
        """The longest phrase that begins at a word: its number of words, and what it is."""
        for count in range(min(self._longest, len(words) - at), 0, -1):
            meaning = self.phrases.get(tuple(words[at : at + count]))
            if meaning is not None:
                return count, meaning
        return None

    def knows(self, word: str) -> bool:
        """Whether the word occurs in any phrase, unit or number, or is one that is never another by a slip."""
        others = (self.words, self.number_words, self.turning, self.cutting)
        return any(word in each for each in others) or word == self.data["point"]

    def parts(self, word: str) -> list[str]:
        """The word as it is known: a verb and what is before it as two, `zusammenschieben`, and slips mended."""
        if not self.knows(word):
            word = REPEATED.sub(r"\1", word)
            for prefix, meant in self.data["prefixes"].items():
                rest = word.removeprefix(prefix)
                for verb in (rest, rest.removeprefix(self.data["infinitive"])):
                    if rest != word and (sense := self.phrases.get((verb,))) and sense.kind in VERBS:
                        return f"{meant} {verb}".split()
        return [self.mended(word)]

    def nearest(self, word: str) -> WordSense | None:
        """What the one known word is that differs from this one by a letter; None where there are none or several."""
        alike = (known for letter in {*word[:2]} for known in self._by_letter.get(letter, ()))
        near = [each for each in alike if len(each) >= SHORTEST_NEAR and is_near(word, each)]
        return self.phrases.get((near[0],)) if len(near) == 1 else None

    def mended(self, word: str) -> str:
        """The one known word that a slip of the keyboard turned into this one; the word itself where there is none.

        A word of another language is no slip: `like` is not `linke`.
        """
        if self.knows(word) or any(lexicon(code).knows(word) for code in lexicons()):
            return word
        near = {known for letter in {*word[:2]} for known in self._by_letter.get(letter, ()) if is_slip(word, known)}
        return near.pop() if len(near) == 1 else word


def _phrases(data: Mapping[str, Any]) -> Iterator[tuple[str, WordSense]]:
    for name, each in data["types"].items():
        yield from _nouns(frozenset({name}), each)
    for each in data["groups"].values():
        yield from _nouns(frozenset(each["types"]), each)
    for colour, phrases in data["colours"].items():
        yield from ((phrase, WordSense("colour", colour)) for phrase in phrases)
    for kind, values in data["words"].items():
        for value, phrases in values.items():
            yield from ((phrase, WordSense(kind, value)) for phrase in phrases)


def _nouns(types: frozenset[str], forms: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, WordSense]]:
    for form, is_many in (("one", False), ("many", True), ("both", None)):
        yield from ((phrase, WordSense("noun", Noun(types, is_many))) for phrase in forms.get(form, ()))


@cache
def lexicons() -> tuple[str, ...]:
    """The languages that there are, by their codes."""
    return language_codes(FOLDER)


@cache
def lexicon(code: str) -> Vocabulary:
    """The lexicon of a language.

    Raises:
        UsageError: There is no file for it.
    """
    own, forms = language_file(FOLDER, code, "words of the language"), word_forms(code)
    return Vocabulary({**forms, **own, "contractions": {**forms["contractions"], **own["contractions"]}})

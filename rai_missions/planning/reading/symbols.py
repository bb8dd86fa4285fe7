# SPDX-License-Identifier: Apache-2.0
"""The symbols of a request: each phrase, number and sign with what it is to the grammar, by itself.

Rule: every word becomes a symbol, also one that is not known; the grammar must account for each.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.scene import CONTAINERS
from rai_missions.planning.text.normalise import readable
from rai_missions.planning.text.numbers import number

__all__ = (
    "BETWEEN", "DIVIDING", "ENDS", "LONGEST_REQUEST", "MOST_WORDS", "NAMING", "RANKING", "RANKS", "SUBJECTS",
    "Quantity", "Symbol", "kind_at", "past", "spelled_symbols", "up_to", "words_of",
)  # fmt: skip

LONGEST_REQUEST = 600
"""Characters of a request; a longer text is not read."""
MOST_WORDS = 100
"""Words and signs of a request; a longer text is not read."""
LONGEST_NUMBER = 8
"""Words of the longest number."""
TOKENS = {sign: re.compile(rf"(?<![\w.])-?\d+(?:[{sign}]\d+)?|\d+|[^\W\d_]+(?:'[^\W\d_]+)*|\S") for sign in (".", ".,")}
"""By what divides decimals: people who write a comma write a point too."""
SIGNS = {
    ",": ",", "/": ",", ".": ".", ";": ".", "!": ".", "?": ".", ":": ":", "(": "(", "[": "(", ")": ")", "]": ")",
    "=": "=", "&": "and", "-": ",", "–": ",", "—": ",", "…": ",",
}  # fmt: skip
ARROW = re.compile(r"[-=]*>|⇒|➡")
"""Written as one sign, which a language may have among its words."""
HYPHEN = re.compile(r"(?<=[^\W\d_])[-‐‑–_](?=[^\W\d_])")
SMILE = re.compile(r"[:;]-?[()dp](?!\w)|[\U0001f300-\U0001faff\u2600-\u27bf]")
"""A face in signs or as one; an arrow was read before."""
LONE = re.compile(r"(?<!\w)'(?=\w)|(?<=\w)'(?!\w)")
"""An apostrophe or a quotation mark at one end of a word: `stack 'em`."""
BETWEEN = (",", ".", "and", "then")
"""Kinds of symbols between two wishes."""
DIVIDING = (*BETWEEN, ":")
"""Kinds of symbols between two wishes, or between a heading and its wishes."""
ENDS = (*BETWEEN, "too", "empty")
SUBJECTS = frozenset({"noun", "colour", "generic", "pronoun", "all", "rest", "everything"})
"""Kinds of symbols that end a phrase about things."""
RANKS = ("rank", "compared")
"""Kinds of symbols that name an order before a noun."""
RANKING = (*RANKS, "ordinal")
"""Kinds of symbols that name an order, or a place in one, before a noun."""
NAMING = SUBJECTS | {"the", "a", "any", "other", "number", "epithet", *RANKING}
"""Kinds of symbols of which such a phrase consists."""


class Quantity(NamedTuple):
    """A number as it was given."""

    value: float
    unit: float | None
    """Metres of its unit; None where it has none."""
    is_whole: bool
    """Whether it was given without decimals."""


class Symbol(NamedTuple):
    """A phrase, a number or a sign of a request."""

    kind: str
    value: Any
    text: str

    @property
    def is_container(self) -> bool:
        """Whether it is a noun for nothing but trays and bins."""
        return self.kind == "noun" and bool(self.value.types <= CONTAINERS)


def words_of(request: str, lexicon: Vocabulary) -> list[str]:
    """The words, numbers and signs of a request in lower case, contractions written out and slips mended."""
    text = HYPHEN.sub(" ", ARROW.sub(" → ", readable(request).lower())).replace("−", "-")
    text = LONE.sub("", SMILE.sub(" ", text)).replace("\n", " . ")
    found = list[str]()
    contractions = lexicon.data["contractions"]
    for token in TOKENS["." if lexicon.data["decimal"] == "." else ".,"].findall(text):
        written: str = contractions.get(token, token)
        for each in _with_owner(written, lexicon).split():
            found += lexicon.parts(each) if each[0].isalpha() else [each]
    return found


def _with_owner(word: str, lexicon: Vocabulary) -> str:
    """`Cube's` as two words, where it is a known one with an ending that names an owner."""
    for ending in lexicon.data["owner_endings"]:
        owner = word.removesuffix(ending)
        if owner != word and owner in lexicon.words:
            return f"{owner} {ending}"
    return word


def spelled_symbols(request: str, lexicon: Vocabulary) -> Iterator[Symbol]:
    """The phrases, numbers and signs of a request, each as what it is by itself."""
    words, at = words_of(request, lexicon), 0
    while at < len(words):
        count, symbol = _symbol(words, at, lexicon)
        yield symbol
        at += count


def _symbol(words: Sequence[str], at: int, lexicon: Vocabulary) -> tuple[int, Symbol]:
    if words[at] in SIGNS:
        return 1, Symbol(SIGNS[words[at]], "", words[at])
    phrase = lexicon.longest(words, at)
    quantity = _quantity(words, at, lexicon)
    if quantity is not None and (phrase is None or quantity[0] > phrase[0]):
        return quantity[0], Symbol("number", quantity[1], " ".join(words[at : at + quantity[0]]))
    if phrase is None:
        return 1, Symbol("unknown", "", words[at])
    count, meaning = phrase
    return count, Symbol(meaning.kind, meaning.value, " ".join(words[at : at + count]))


def _quantity(words: Sequence[str], at: int, lexicon: Vocabulary) -> tuple[int, Quantity] | None:
    if words[at] not in lexicon.number_words and not words[at][-1].isdigit():
        return None
    for count in range(min(LONGEST_NUMBER, len(words) - at), 0, -1):
        ends_open = words[at + count - 1] == lexicon.data["number_joint"]
        value = None if ends_open else _value(words[at : at + count], lexicon)
        if value is None:
            continue
        unit = lexicon.units.get(words[at + count]) if at + count < len(words) else None
        return count + (unit is not None), Quantity(float(value), unit, isinstance(value, int))
    return None


def _value(words: Sequence[str], lexicon: Vocabulary) -> float | None:
    if len(words) == 1 and words[0][-1].isdigit():
        return _digits(words[0])
    return number(words, lexicon.data)


def _digits(word: str) -> float | None:
    """A place and a gap never have thousands: a sign in a number divides its decimals, whatever the language."""
    whole, sign, decimals = word.replace(",", ".").partition(".")
    if len(whole) > 9 or len(decimals) > 9:
        return None
    return float(f"{whole}.{decimals}") if sign else int(whole)


def kind_at(found: Sequence[Symbol], at: int) -> str:
    """The kind of the symbol at a place; empty ahead of the first and past the last."""
    return found[at].kind if 0 <= at < len(found) else ""


def past(found: Sequence[Symbol], at: int, kinds: Collection[str]) -> int:
    """The place past all symbols of some kinds from here."""
    return next((place for place in range(at, len(found)) if found[place].kind not in kinds), len(found))


def up_to(found: Sequence[Symbol], at: int, kinds: Collection[str]) -> int:
    """The place of the first symbol of some kinds from here; past the last where there is none."""
    return next((place for place in range(at, len(found)) if found[place].kind in kinds), len(found))

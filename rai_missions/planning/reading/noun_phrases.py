# SPDX-License-Identifier: Apache-2.0
"""Phrases about things, from symbols: `the red and the blue cube`, `all of the apples`, `everything but the corn`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from rai_missions.planning.reading.phrases import Phrase, Rank
from rai_missions.planning.reading.symbols import RANKING, RANKS, Symbol

__all__ = ("PREDICATES", "Cursor", "noun_phrase", "noun_phrases", "ordered_phrases", "with_limits")

LISTED = (",", "and")
PREDICATES = ("relation", "stays", "holds", "each_other", "level", ":", "=")
"""Kinds of symbols that come after the things of which a wish is."""


class Cursor:
    """A place in a list of symbols.

    Args:
        symbols: The symbols of a request.
    """

    def __init__(self, symbols: Sequence[Symbol]) -> None:
        self.symbols = symbols
        self.at = 0

    def kind(self, ahead: int = 0) -> str:
        """The kind of a symbol from here; empty past the end."""
        place = self.at + ahead
        return self.symbols[place].kind if place < len(self.symbols) else ""

    def value(self) -> Any:
        """The value of the symbol here; None past the end."""
        return self.symbols[self.at].value if self.kind() else None

    def take(self) -> Symbol:
        """The symbol here; the cursor moves past it."""
        self.at += 1
        return self.symbols[self.at - 1]

    def skip(self, *kinds: str) -> bool:
        """Moves past all symbols of some kinds from here, and reports whether there were any."""
        before = self.at
        while self.kind() in kinds:
            self.at += 1
        return self.at > before

    def back_to(self, at: int) -> None:
        """Moves to a place where it was before."""
        self.at = at

    def text(self, since: int) -> str:
        """The words from a place to here."""
        return " ".join(symbol.text for symbol in self.symbols[since : self.at])


def noun_phrases(cursor: Cursor, among: frozenset[str] = frozenset(), *, most: int | None = None) -> tuple[Phrase, ...]:
    """A list of phrases, such as `red, blue and the yellow cube`; empty where none begins here.

    A colour alone before a noun in the list has the noun's types.

    Args:
        cursor: At the first of them.
        among: The list ends ahead of a phrase that names none of these types; empty: any.
        most: The list ends after so many.
    """
    found = list[Phrase]()
    while len(found) != most:
        before = cursor.at
        if found and not cursor.skip(*LISTED):
            break
        phrase = noun_phrase(cursor)
        if (
            phrase is None
            or (found and phrase.kind == "there")
            or (among and phrase.types and among.isdisjoint(phrase.types))
        ):
            cursor.back_to(before)
            break
        found.append(phrase)
    return _with_heads(found)


def ordered_phrases(cursor: Cursor) -> tuple[Phrase, ...]:
    """Phrases whose order is given: `: red, then blue, then green`; empty where none begins here."""
    cursor.skip(",", ":")
    found, before = noun_phrases(cursor), cursor.at
    while cursor.skip(",", "then", "and") and (more := noun_phrases(cursor)):
        found, before = found + more, cursor.at
    cursor.back_to(before)
    return found


def _with_heads(found: Sequence[Phrase]) -> tuple[Phrase, ...]:
    if len(found) == 2 and found[0].is_all and found[0].count == 2 and not found[0].is_many:
        found = [replace(found[0], is_all=False, count=None), found[1]]  # `both the apple and the carrot`
    done, head = list[Phrase](), None
    for phrase in reversed(found):
        is_short = phrase.kind == "things" and bool(phrase.colour or phrase.rank) and not phrase.has_noun
        if head is not None and is_short:
            done.append(replace(phrase, types=head.types, has_noun=True))
            continue
        if phrase.has_noun and (phrase.colour or phrase.rank):
            head = phrase
        done.append(phrase)
    return tuple(reversed(done))


def noun_phrase(cursor: Cursor) -> Phrase | None:
    """One phrase, with what it excepts and what else it may mean; None where none begins here."""
    before = cursor.at
    phrase = _single(cursor)
    if phrase is None:
        cursor.back_to(before)
        return None
    others = list[Phrase]()
    while cursor.kind() == "or":
        place = cursor.at
        cursor.skip("or")
        other = _single(cursor)
        if other is None:
            cursor.back_to(place)
            break
        others.append(other)
    if others:
        first, *rest = _with_heads([phrase, *others])
        phrase = replace(first, others=tuple(rest), text=cursor.text(before))
    return phrase


def _single(cursor: Cursor) -> Phrase | None:
    kind = cursor.kind()
    if kind == "rest" or (kind == "other" and cursor.kind(1) == "number" and cursor.kind(2) not in NOUNS):
        begun = cursor.at
        cursor.take()
        is_counted = cursor.kind() == "number" and cursor.value().unit is None and cursor.value().is_whole
        count = int(cursor.take().value.value) if is_counted and cursor.kind(1) not in NOUNS else None
        return Phrase("rest", cursor.text(begun), is_many=True, is_all=True, count=count)
    if kind == "everything" and cursor.kind(1) == "colour":  # `everything red`
        cursor.take()
        colour: str = cursor.take().value
        every = Phrase("things", cursor.text(cursor.at - 2), colour=colour, is_many=True, is_all=True)
        return with_limits(cursor, every)
    if kind == "everything" and cursor.value() == "any" and cursor.kind(1) != "not_a":
        return None  # `anything` alone may be any one thing
    if kind == "everything" or (kind == "all" and cursor.kind(1) == "except"):
        return with_limits(cursor, Phrase("everything", cursor.take().text, is_many=True, is_all=True))
    if kind == "there":
        return Phrase("there", cursor.take().text)
    if (
        kind == "the" and cursor.value() not in ("the", "own") and cursor.kind(1) in PREDICATES
    ):  # `leg das in den Eimer`
        symbol = cursor.take()
        return Phrase("pronoun", symbol.text, is_many=symbol.value == "many")
    if kind == "pronoun" and cursor.kind(1) not in ("noun", "colour", "generic", "epithet"):
        symbol = cursor.take()
        return Phrase("pronoun", symbol.text, is_many=symbol.value == "many")
    return _things(cursor)


def _things(cursor: Cursor) -> Phrase | None:
    before = cursor.at
    words = _before_noun(cursor)
    if words is None:
        return None
    if cursor.kind() == "desk":
        return Phrase("desk", cursor.take().text)
    kinds = {each.kind for each in words}
    colour = cursor.take().value if cursor.kind() == "colour" else ""
    noun, is_many, is_one = None, False, False
    if cursor.kind() == "noun":
        noun = cursor.take().value
        is_many = _are_many(words) if noun.is_many is None else noun.is_many
    elif not (colour or kinds & {"other", *RANKS} or (cursor.kind() == "generic" and _is_rank(cursor, 1))):
        return None  # `the one` alone may be any
    elif cursor.kind() == "generic":
        is_many, is_one = cursor.take().value == "many", True
    ranks = [*_ranks(words), *_rank_after(cursor)]
    is_any, place = bool(kinds & {"a", "any", "generic"}), max(map(_place, words), default=1)
    if len(ranks) > 1 or (ranks and is_any) or (place > 1 and not ranks):
        return None  # the leftmost and the nearest; a cube and the leftmost; the second of what?
    phrase = Phrase(
        "things",
        cursor.text(before),
        types=noun.types if noun else frozenset(),
        has_noun=noun is not None,
        colour=colour,
        is_many=is_many,
        is_all="all" in kinds,
        is_any=is_any,
        is_one=is_one,
        is_free="any" in kinds,
        count=next((count for each in reversed(words) if (count := _count(each)) is not None), None),
        is_other="other" in kinds,
        epithet=next((each.text for each in words if each.kind == "epithet"), ""),
        rank=replace(ranks[0], place=place) if ranks else None,
    )
    return with_limits(cursor, phrase)


def _before_noun(cursor: Cursor) -> list[Symbol] | None:
    """What is before the colour and the noun of a phrase; None where a number in it counts nothing."""
    found = list[Symbol]()
    while cursor.kind() in BEFORE_NOUN or _counts(cursor):
        found.append(cursor.take())
        number = found[-1].value if found[-1].kind == "number" else None
        if number is not None and (number.unit is not None or not number.is_whole or cursor.kind() not in NOUNS):
            return None
    return found


def _are_many(words: Sequence[Symbol]) -> bool:
    """Whether a noun that may be of one or many is of many, by the words before it."""
    return next((each.value == "many" for each in reversed(words) if each.kind not in ("number", *RANKING)), True)


def _count(word: Symbol) -> int | None:
    """How many things a word before a noun counts; None where it counts none."""
    if word.kind == "number":
        return int(word.value.value)
    return 1 if word.kind == "generic" else {("all", "two"): 2, ("any", "one"): 1}.get((word.kind, word.value))


def _place(word: Symbol) -> int:
    return int(word.value) if word.kind == "ordinal" else 1


def _ranks(words: Sequence[Symbol]) -> list[Rank]:
    return [Rank(each.value, is_of_two=each.kind == "compared") for each in words if each.kind in RANKS]


def _is_rank(cursor: Cursor, ahead: int = 0) -> bool:
    """Whether a rank begins here or so many symbols ahead: `… that is closest to the tray`."""
    ahead += cursor.kind(ahead) == "pronoun"
    ahead += cursor.kind(ahead) == "is"
    return cursor.kind(ahead) in (*RANKS, "counted_from")


def _rank_after(cursor: Cursor) -> Iterator[Rank]:
    """A rank after what it is about, if one is here: `… closest to the tray`, `… on the left`, `… from the right`."""
    if not _is_rank(cursor):
        return
    before = cursor.at
    cursor.skip("pronoun", "is")
    symbol = cursor.take()
    rank = Rank(symbol.value, is_of_two=symbol.kind == "compared", is_after=True)
    if symbol.value not in DISTANCES:
        yield rank
        return
    other = noun_phrase(cursor)
    if other is None or other.kind != "things":
        cursor.back_to(before)
        return
    cursor.skip("is")
    yield replace(rank, of=other)


def _excluded(cursor: Cursor) -> frozenset[str]:
    """The types of `that is not a cube or an apple`."""
    return frozenset().union(*(each.value.types for each in _limits(cursor, "noun")))


def _other_colours(cursor: Cursor, phrase: Phrase) -> tuple[Phrase, ...]:
    """What is left out by `that is not blue or red`: the same things of these colours."""
    whole = replace(phrase, is_many=True, is_all=True, count=None, is_any=False, rank=None)
    return tuple(replace(whole, text=each.text, colour=each.value) for each in _limits(cursor, "colour"))


def _limits(cursor: Cursor, kind: str) -> list[Symbol]:
    """The words of a kind after `that is not`, with `or` between them; past what ends the limit."""
    cursor.take()
    found = [cursor.take()]
    while cursor.kind() in ("or", "and", ","):
        before = cursor.at
        cursor.skip("or", "and", ",")
        cursor.skip("a", "not_a", "no")
        if cursor.kind() != kind:
            cursor.back_to(before)
            break
        found.append(cursor.take())
    cursor.skip("is")
    if cursor.kind() == "," and cursor.kind(1) == "relation":
        cursor.take()
    return found


DISTANCES = ("near", "far")
"""Ranks that are measured from another thing."""
BEFORE_NOUN = ("the", "a", "any", "all", "other", "number", "pronoun", "epithet", *RANKING)
NOUNS = ("noun", "colour", "generic", "other", "any", *RANKING)


def _counts(cursor: Cursor) -> bool:
    """`one` before a noun counts; alone it stands for a noun."""
    return cursor.kind() == "generic" and cursor.value() == "one" and cursor.kind(1) in NOUNS[:2]


def with_limits(cursor: Cursor, phrase: Phrase) -> Phrase:
    """The phrase with what is excepted here: `… except the corn`, `…, but not the red one`, `… that is not a cube`."""
    comma = int(cursor.kind() == ",")
    if cursor.kind(comma) == "not_a" and cursor.kind(comma + 1) == "colour":
        cursor.skip(",")
        return replace(phrase, without=_other_colours(cursor, phrase))
    if cursor.kind(comma) == "not_a" and cursor.kind(comma + 1) == "noun":
        cursor.skip(",")
        return replace(phrase, not_types=_excluded(cursor))
    if cursor.kind(comma) == "except" and (phrase.is_many or phrase.is_all) and not phrase.without:
        place = cursor.at
        cursor.skip(",")
        if comma and cursor.value() == "but":  # `…, but the red one` may begin another wish
            cursor.back_to(place)
            return phrase
        cursor.take()
        without = noun_phrases(cursor, phrase.types)
        if without and not any(each.without for each in without):
            if comma and cursor.kind() == "," and cursor.kind(1) in ("relation", "put"):
                cursor.take()
            return replace(phrase, without=tuple(_of_types(each, phrase.types) for each in without))
        cursor.back_to(place)
    return phrase


def _of_types(phrase: Phrase, types: frozenset[str]) -> Phrase:
    """`… but not the leftmost` is of the things from which it is excepted."""
    return replace(phrase, types=types, has_noun=True) if phrase.rank is not None and not phrase.has_noun else phrase

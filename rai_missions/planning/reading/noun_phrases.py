# SPDX-License-Identifier: Apache-2.0
"""Phrases about things, from symbols: `the red and the blue cube`, `all of the apples`, `everything but the corn`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from rai_missions.planning.reading.phrases import Phrase
from rai_missions.planning.reading.symbols import Symbol

__all__ = ("Cursor", "noun_phrase", "noun_phrases", "ordered_phrases", "with_limits")

LISTED = (",", "and")


class Cursor:
    """A place in a list of symbols.

    Args:
        symbols: Of a request.
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
        if phrase is None or (among and phrase.types and among.isdisjoint(phrase.types)):
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
        if head is not None and phrase.kind == "things" and phrase.colour and not phrase.has_noun:
            done.append(replace(phrase, types=head.types, has_noun=True))
            continue
        if phrase.has_noun and phrase.colour:
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
    if kind == "rest":
        return Phrase("rest", cursor.take().text, is_many=True, is_all=True)
    if kind == "everything" or (kind == "all" and cursor.kind(1) == "except"):
        return with_limits(cursor, Phrase("everything", cursor.take().text, is_many=True, is_all=True))
    if kind == "there":
        return Phrase("there", cursor.take().text)
    if kind == "pronoun" and cursor.kind(1) not in ("noun", "colour", "generic"):
        symbol = cursor.take()
        return Phrase("pronoun", symbol.text, is_many=symbol.value == "many")
    return _things(cursor)


def _things(cursor: Cursor) -> Phrase | None:
    before = cursor.at
    all_, any_, free, other, count = False, False, False, False, None
    before_many = True
    while cursor.kind() in ("the", "a", "any", "all", "other", "number", "pronoun") or _counts(cursor):
        symbol = cursor.take()
        free = free or symbol.kind == "any"
        any_ = any_ or symbol.kind in ("a", "any")
        before_many = before_many if symbol.kind == "number" else symbol.value == "many"
        other = other or symbol.kind == "other"
        all_ = all_ or symbol.kind == "all"
        if symbol.kind == "all" and symbol.value == "two":
            count = 2
        if symbol.kind == "any" and symbol.value == "one":
            count = 1
        if symbol.kind == "generic":
            count, any_ = 1, True
        if symbol.kind == "number":
            if symbol.value.unit is not None or not symbol.value.is_whole or cursor.kind() not in NOUNS:
                return None
            count = int(symbol.value.value)
    if cursor.kind() == "desk":
        return Phrase("desk", cursor.take().text)
    colour = cursor.take().value if cursor.kind() == "colour" else ""
    noun, is_many, is_one = None, False, False
    if cursor.kind() == "noun":
        noun = cursor.take().value
        is_many = before_many if noun.is_many is None else noun.is_many
    elif not colour and not other:
        return None  # `the one` alone may be any
    elif cursor.kind() == "generic":
        is_many, is_one = cursor.take().value == "many", True
    phrase = Phrase(
        "things", cursor.text(before), types=noun.types if noun else frozenset(), has_noun=noun is not None,
        colour=colour, is_many=is_many, is_all=all_, is_any=any_, count=count, is_other=other,
        is_one=is_one, is_free=free,
    )  # fmt: skip
    return with_limits(cursor, phrase)


def _excluded(cursor: Cursor) -> frozenset[str]:
    """The types of `that is not a cube or an apple`."""
    return frozenset().union(*(each.value.types for each in _limits(cursor, "noun")))


def _other_colours(cursor: Cursor, phrase: Phrase) -> tuple[Phrase, ...]:
    """What is left out by `that is not blue or red`: the same things of these colours."""
    whole = replace(phrase, is_many=True, is_all=True, count=None, is_any=False)
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


NOUNS = ("noun", "colour", "generic", "other", "any")


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
            return replace(phrase, without=without)
        cursor.back_to(place)
    return phrase

# SPDX-License-Identifier: Apache-2.0
"""A request as symbols: each phrase, number and sign with what it is to the grammar.

Rule: every word becomes a symbol, also one that is not known; the grammar must account for each.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.scene import CONTAINERS
from rai_missions.planning.text.normalise import readable
from rai_missions.planning.text.numbers import number

__all__ = (
    "BETWEEN",
    "DIVIDING",
    "LONGEST_REQUEST",
    "MOST_WORDS",
    "Quantity",
    "Symbol",
    "past",
    "symbols",
    "up_to",
    "words_of",
)

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
"""The same, and what is between a heading and its wishes."""
ENDS = (*BETWEEN, "too", "empty")
SUBJECTS = frozenset({"noun", "colour", "generic", "pronoun", "all", "rest", "everything"})
"""Kinds of symbols that end a phrase about things."""
RANKS = ("rank", "compared")
"""Kinds of symbols that name an order before a noun."""
RANKING = (*RANKS, "ordinal")
"""The same with a place in it."""
NEXT_SIDE = {"left": "left_of", "right": "right_of"}
"""Sides of a thing → where another one is then."""
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


def symbols(request: str, lexicon: Vocabulary) -> list[Symbol]:
    """What a request consists of."""
    words = words_of(request, lexicon)
    found, at = list[Symbol](), 0
    while at < len(words):
        count, symbol = _symbol(words, at, lexicon)
        found.append(symbol)
        at += count
    found = list(_measured(_off_desk(_unbracketed(_unnumbered(found))), lexicon.data["measured"]))
    found = list(_asking(_excepting(found), lexicon.data))
    found = _with_sides_last(_owned(found))
    found = _compared(_without_noise(_with_other_wishes(found)))
    return _without_contrast(_clearing(found), lexicon.data["contrast"])


def _unnumbered(found: Sequence[Symbol]) -> list[Symbol]:
    """With a sign in place of the number of a step: `1. red on blue 2. green on red`, `step 1: …`."""
    kept, at = list[Symbol](), 0
    while at < len(found):
        before, sign = kept[-1].kind if kept else ".", found[at + 1].kind if at + 1 < len(found) else ""
        is_step = found[at].kind == "number" and found[at].value.unit is None and before in (".", "noise", *SUBJECTS)
        if is_step and sign in (".", ")", ":"):
            kept.append(Symbol(".", "", found[at].text))
            at += 1
        else:
            kept.append(found[at])
        at += 1
    return kept


def _off_desk(found: Sequence[Symbol]) -> list[Symbol]:
    """Without `off the desk` ahead of where things go: `everything off the desk into the bin`."""
    return [
        symbol
        for symbol, after in zip_longest(found, found[1:])
        if symbol.value != "off_desk" or after is None or (after.kind, after.value) != ("relation", "in")
    ]


def _measured(found: Sequence[Symbol], by: Collection[str]) -> list[Symbol]:
    """With how far as it is elsewhere: `5 cm to the left` for `to the left by 5 cm`."""
    kept = list[Symbol]()
    for symbol, after in zip_longest(found, found[1:]):
        if symbol.text in by and after is not None and after.kind == "number" and after.value.unit is not None:
            continue
        is_turned = symbol.kind == "number" and [each.kind == "side" for each in kept[-1:]] == [True]
        is_alone = is_turned and kept[-2:-1] and kept[-2].kind != "number" and (after is None or after.kind != "side")
        kept[len(kept) - bool(is_alone) : len(kept)] = [symbol, kept[-1]] if is_alone else [symbol]
    return kept


def _unbracketed(found: Sequence[Symbol]) -> list[Symbol]:
    """With brackets as commas, where they are not around coordinates."""
    kept, is_place = list[Symbol](), True
    for at, symbol in enumerate(found):
        if symbol.kind == "(":
            is_place = any(each.kind in ("number", "axis") for each in found[at + 1 : at + 3])
        kept.append(symbol if is_place or symbol.kind not in ("(", ")") else symbol._replace(kind=","))
    return kept


def _with_other_wishes(found: list[Symbol]) -> list[Symbol]:
    """With what is no exception, but how another thing is wanted, as a negation: `the cubes …, but the red one first`.

    Words that may close any wish are none of that: `everything but the apple, please`.
    """
    for at, symbol in enumerate(found):
        if symbol.kind == "except":
            named = past(found, at + 1, NAMING)
            end = past(found, named, ("noise",))
            is_closed = end == len(found) or found[end].kind in ENDS
            is_too = past(found, end, ("too",)) > end
            is_how = is_too or any(each.value != "closing" for each in found[named:end])
            if found[at + 1 : at + 2] and found[at + 1].kind == "keep":
                found[at] = symbol._replace(kind=",")  # `…, but leave the red one alone`
            elif named == at + 1 < end or (is_closed and is_how):
                found[at] = symbol._replace(kind="no")
    return found


def past(found: Sequence[Symbol], at: int, kinds: Collection[str]) -> int:
    """The place past all symbols of some kinds from here."""
    return next((place for place in range(at, len(found)) if found[place].kind not in kinds), len(found))


def up_to(found: Sequence[Symbol], at: int, kinds: Collection[str]) -> int:
    """The place of the first symbol of some kinds from here; past the last where there is none."""
    return next((place for place in range(at, len(found)) if found[place].kind in kinds), len(found))


def _clearing(found: list[Symbol]) -> list[Symbol]:
    """With a verb of clearing as what it is there: `clear the tray` empties it, `clear the desk into it` moves all."""
    for at, symbol in enumerate(found):
        if symbol.kind == "empty" or (symbol.kind == "put" and symbol.value in ("clear", "arrange")):
            end = past(found, at + 1, ("the", "all"))
            is_desk = end + 1 < len(found) and found[end].kind == "desk" and found[end + 1].kind == "relation"
            if is_desk and found[end + 1].value in ("in", "on", "to"):
                every = Symbol("everything", "", found[end].text)
                return [*found[:at], symbol._replace(kind="put", value="clear"), every, *found[end + 1 :]]
        if (symbol.kind, symbol.value) == ("put", "clear"):
            is_container = end < len(found) and found[end].kind == "noun" and found[end].value.types <= CONTAINERS
            if is_container and (end + 1 == len(found) or found[end + 1].kind in (*ENDS, "particle")):
                found[at] = symbol._replace(kind="empty", value="")
    return found


def _compared(found: list[Symbol]) -> list[Symbol]:
    """With a side of the thing itself as what it is there: `the left cube`, `the cube on the left`."""
    kept = list[Symbol]()
    shift = next((at for at, symbol in enumerate(found) if symbol.value == "shift"), len(found))
    for at, symbol in enumerate(found):
        before, after = found[at - 1].kind if at else "", found[at + 1].kind if at + 1 < len(found) else ""
        is_side = symbol.kind == "side" and symbol.value in NEXT_SIDE
        if is_side and at <= shift and before in ("noun", "colour", "generic") and after in ("", *ENDS):
            kept.append(symbol._replace(kind="compared"))  # `the cubes to the left, the fruit to the right`
        elif not is_side or before != "the":
            kept.append(symbol)
        elif after in ("noun", "colour", "generic"):
            kept.append(symbol._replace(kind="compared"))
        elif [each.kind for each in kept[-3:]] in [[kind, "relation", "the"] for kind in ("noun", "generic", "colour")]:
            text = " ".join(each.text for each in (*kept[-2:], symbol))
            is_on = kept[-2].value == "on"
            kept[-2:] = [] if is_on else kept[-2:]
            kept.append(Symbol("compared", symbol.value, text) if is_on else symbol)
        else:
            kept.append(symbol)
    return kept


def _owned(found: Sequence[Symbol]) -> list[Symbol]:
    """With a side of a thing as a relation to it: `on the cube's right`; `5 cm to its left` is a shift."""
    kept = list[Symbol]()
    for symbol in found:
        before = kept[-1] if kept else None
        if symbol.kind != "side" or symbol.value not in NEXT_SIDE or before is None or before.kind == "number":
            kept.append(symbol)
            continue
        placed = Symbol("relation", NEXT_SIDE[symbol.value], symbol.text)
        begun = len(kept) - 1
        if before.kind == "owner":
            while begun and kept[begun - 1].kind in NAMING:
                begun -= 1
            owner = kept[begun:-1]
        elif (before.kind, before.value) == ("the", "own"):
            owner = [Symbol("pronoun", "one", before.text)]
        else:
            kept.append(symbol)
            continue
        if begun and kept[begun - 1].kind == "relation" and kept[begun - 1].value in ("on", "to", "next_to"):
            begun -= 1
        is_shift = begun > 0 and kept[begun - 1].kind == "number" and before.kind == "the"
        kept[begun:] = [symbol] if is_shift else [placed, *owner]
    return kept


def _excepting(found: Sequence[Symbol]) -> list[Symbol]:
    """Without the `but` ahead of a word of exception: `the cubes, but without the red one`."""
    return [
        symbol
        for symbol, after in zip_longest(found, found[1:])
        if after is None or after.kind != "except" or (symbol.kind != "then" and symbol.value != "but")
    ]


def _with_sides_last(found: list[Symbol]) -> list[Symbol]:
    """With the two sides of the desk after what is to be there: `on the left the cubes, on the right: the fruit`."""
    starts = [at for at, each in enumerate(found) if each.kind == "side" and each.value in NEXT_SIDE]
    ahead = [next((at - back for back in (0, 1, 2) if _is_start(found, at - back)), -1) for at in starts]
    if [found[at].value for at in starts] not in (["left", "right"], ["right", "left"]) or -1 in ahead:
        return found
    kept = found[: ahead[0]]
    for at, end in zip(starts, (ahead[1], len(found)), strict=True):
        body = [*found[at + 1 : end]]
        while body and body[0].kind in (",", ":", "put"):
            body.pop(0)
        while body and body[-1].kind in (*ENDS, ":"):
            body.pop()
        if not body or body[-1].kind not in ("noun", "colour", "generic"):
            return found
        kept += [*body, found[at]._replace(kind="compared"), Symbol(",", "", ",")]
    return kept


def _is_start(found: Sequence[Symbol], at: int) -> bool:
    """Whether the words of a side begin here: `on the left`, at the beginning or after a sign."""
    is_first = at == 0 or (at > 0 and found[at - 1].kind in (*ENDS, "put", ":"))
    return is_first and found[at].kind in ("side", "relation", "the")


def _asking(found: Sequence[Symbol], data: Mapping[str, Any]) -> Iterator[Symbol]:
    """With a verb at the beginning of a sentence as what it is there, a question: `should red be on blue`.

    `Can the cube …` asks what is possible, unless it has a place to which it moves.
    One that follows its things, where no word of a wish came before, reports: `the cubes lie on the tray`. After such
    a word a verb that reports is none: `make sure the apple is in the tray`. `Where it is` stays as it is.
    """
    is_first, is_address, is_wish, is_where, before = True, True, False, False, ""
    wishing = set(data["wishing"])
    is_moved = any(each.kind == "relation" for each in found) and not any(
        each.text in data["reports"] for each in found
    )
    asks = {
        *data["asks"],
        *(data["addressed"] if found and found[-1].text == "?" else ()),
        *(() if is_moved else data["asks_if_it_can"]),
    }
    for symbol in found:
        is_wish = symbol.kind != "." and (is_wish or not wishing.isdisjoint(symbol.text.split()))
        if (is_first and symbol.text in asks) or (
            before in SUBJECTS and not is_wish and symbol.text in data["reports"]
        ):
            yield symbol._replace(kind="asked")
        else:
            yield symbol._replace(kind="noise") if is_wish and symbol.kind == "is" and not is_where else symbol
        is_where = symbol.value == "place_of" or (is_where and symbol.kind == "pronoun")
        before = before if symbol.kind == "noise" else symbol.kind
        is_address = symbol.kind == "." or (is_address and symbol.kind in ("noise", ","))
        is_first = is_address and symbol.kind in (".", ",")  # `hey robot, should …`, and not `you should …`


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


def _without_noise(found: Sequence[Symbol]) -> list[Symbol]:
    """Without what means nothing here, and without a pair of commas around it: `the, um, green cube`."""
    kept, at = list[Symbol](), 0
    while at < len(found):
        after = at
        while after < len(found) and found[after].kind == "noise":
            after += 1
        if after == at:
            kept.append(found[at])
            at += 1
        elif kept and kept[-1].kind == "," and after < len(found) and found[after].kind == ",":
            kept.pop()
            at = after + 1
        else:
            at = after
    return [
        each
        for place, each in enumerate(kept)
        if place == 0 or each.kind not in (",", ".") or each.kind != kept[place - 1].kind
    ]


def _without_contrast(found: list[Symbol], contrast: Mapping[str, Sequence[str]]) -> list[Symbol]:
    """Without what is named only to exclude it: `not the blue but the red cube`, `on red, not on blue`.

    What follows `rather than` is left out wherever it is.
    After a comma that is sure only where each phrase is about one thing: `the cubes …, not the red one` excepts.
    """
    is_many = any(each.kind in ("all", "everything", "rest") or each.value == "many" for each in found) or any(
        each.kind == "noun" and each.value.is_many is not False for each in found
    )
    for at, symbol in enumerate(found):
        is_than = symbol.text in contrast["than"]
        if symbol.text not in contrast["not"] and not is_than:
            continue
        end = at + 1 + (at + 1 < len(found) and found[at + 1].kind == "relation")
        begun = end
        while end < len(found) and found[end].kind in NAMING:
            end += 1
        rest = found[end + 1 :] if end < len(found) and found[end].kind == "," else found[end:]
        if end == begun:
            continue
        if is_than:
            return [*found[:at], *found[end:]]
        if rest and rest[0].text in contrast["but"]:
            return [*found[:at], *rest[1:]]
        if at > 1 and found[at - 1].kind == "," and found[at - 2].kind in NAMING and not is_many:
            return [*found[: at - 1], *rest]
    return found

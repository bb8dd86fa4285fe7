# SPDX-License-Identifier: Apache-2.0
"""A request as symbols, each as what it is among its neighbours: a comma, the number of a step, the owner of a side.

Rule: a symbol changes by what is around it, whatever the language; forms of a whole wish are rewritten in `rewrites`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.symbols import ENDS, NAMING, SUBJECTS, Symbol, kind_at, past, spelled_symbols

__all__ = ("symbols",)

NEXT_SIDE = {"left": "left_of", "right": "right_of"}
"""Sides of a thing → where another one is then."""


def symbols(request: str, lexicon: Vocabulary) -> list[Symbol]:
    """What a request consists of."""
    spelled = [*spelled_symbols(request, lexicon)]
    found = list(_measured(_off_desk(_unbracketed(_unnumbered(spelled))), lexicon.data["measured"]))
    found = list(_asking(_excepting(found), lexicon.data))
    found = _with_sides_last(_owned(found))
    found = _compared(_without_noise(_with_other_wishes(found)))
    return _without_contrast(_clearing(found), lexicon.data["contrast"])


def _unnumbered(found: Sequence[Symbol]) -> list[Symbol]:
    """With a sign in place of the number of a step: `1. red on blue 2. green on red`, `step 1: …`."""
    kept, at = list[Symbol](), 0
    while at < len(found):
        before, sign = kept[-1].kind if kept else ".", kind_at(found, at + 1)
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
            if kind_at(found, at + 1) == "keep":
                found[at] = symbol._replace(kind=",")  # `…, but leave the red one alone`
            elif named == at + 1 < end or (is_closed and is_how):
                found[at] = symbol._replace(kind="no")
    return found


def _clearing(found: list[Symbol]) -> list[Symbol]:
    """With a verb of clearing as what it is there: `clear the tray` empties it, `clear the desk into it` moves all."""
    for at, symbol in enumerate(found):
        if symbol.kind == "empty" or (symbol.kind == "put" and symbol.value in ("clear", "arrange")):
            end = past(found, at + 1, ("the", "all"))
            is_desk = kind_at(found, end) == "desk" and kind_at(found, end + 1) == "relation"
            if is_desk and found[end + 1].value in ("in", "on", "to"):
                every = Symbol("everything", "", found[end].text)
                return [*found[:at], symbol._replace(kind="put", value="clear"), every, *found[end + 1 :]]
        if (symbol.kind, symbol.value) == ("put", "clear"):
            is_container = end < len(found) and found[end].is_container
            if is_container and kind_at(found, end + 1) in ("", *ENDS, "particle"):
                found[at] = symbol._replace(kind="empty", value="")
    return found


def _compared(found: list[Symbol]) -> list[Symbol]:
    """With a side of the thing itself as what it is there: `the left cube`, `the cube on the left`."""
    kept = list[Symbol]()
    shift = next((at for at, symbol in enumerate(found) if symbol.value == "shift"), len(found))
    for at, symbol in enumerate(found):
        before, after = kind_at(found, at - 1), kind_at(found, at + 1)
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
    is_first = at == 0 or kind_at(found, at - 1) in (*ENDS, "put", ":")
    return is_first and kind_at(found, at) in ("side", "relation", "the")


def _asking(found: Sequence[Symbol], data: Mapping[str, Any]) -> Iterator[Symbol]:
    """With a verb at the beginning of a sentence as what it is there, a question: `should red be on blue`.

    `Can the cube …` asks what is possible, unless it has a place to which it moves, or another to trade places with.
    One that follows its things, where no word of a wish came before, reports: `the cubes lie on the tray`. After such
    a word a verb that reports is none: `make sure the apple is in the tray`. `Where it is` stays as it is.
    """
    is_first, is_address, is_wish, is_where, before = True, True, False, False, ""
    wishing = set(data["wishing"])
    is_moved = any(each.kind == "relation" or each.value == "swap" for each in found) and not any(
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


def _without_noise(found: Sequence[Symbol]) -> list[Symbol]:
    """Without what means nothing here, and without a pair of commas around it: `the, um, green cube`."""
    kept, at = list[Symbol](), 0
    while at < len(found):
        after = past(found, at, ("noise",))
        if after == at:
            kept.append(found[at])
            at += 1
        elif kind_at(kept, len(kept) - 1) == kind_at(found, after) == ",":
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
        begun = at + 1 + (kind_at(found, at + 1) == "relation")
        end = past(found, begun, NAMING)
        rest = found[end + (kind_at(found, end) == ",") :]
        if end == begun:
            continue
        if is_than:
            return [*found[:at], *found[end:]]
        if rest and rest[0].text in contrast["but"]:
            return [*found[:at], *rest[1:]]
        if at > 1 and found[at - 1].kind == "," and found[at - 2].kind in NAMING and not is_many:
            return [*found[: at - 1], *rest]
    return found

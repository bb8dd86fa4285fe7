# SPDX-License-Identifier: Apache-2.0
"""Forms of a wish, rewritten to the ones that the grammar reads: `bau … ab`, `put it in A, no wait, in B`.

Rule: a form that is open to another reading stays as it is, and is asked about.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rai_missions.planning.reading.asides import without_asides
from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.neighbours import symbols
from rai_missions.planning.reading.symbols import DIVIDING, ENDS, NAMING, Symbol, kind_at, past, up_to
from rai_missions.planning.scene import CONTAINERS

__all__ = ("names_bin", "put_away", "rewritten", "taken_out")


def rewritten(request: str, lexicon: Vocabulary) -> list[Symbol]:
    """The symbols of a request with each form rewritten."""
    found, data = without_asides(symbols(request, lexicon), lexicon), lexicon.data
    for each in data["separated"]:
        found = _joined(found, each)
    found = [
        symbol
        for at, symbol in enumerate(found)
        if not _is_particle(found, at, data) and not _is_formal(found, at, data)
    ]
    found = _off_towers(_kept_apart(_excluding(_without_reasons(found), data)))
    return _cleared_tops(_moved_out(_removed(_corrected(_taken_back(found, data)), data), data), data)


def _is_particle(found: Sequence[Symbol], at: int, data: Mapping[str, Any]) -> bool:
    """Whether it only completes a verb: `räum … auf`, `setz … ab`."""
    is_last = kind_at(found, at + 1) in ("", *DIVIDING)
    return found[at].kind == "particle" or (is_last and data["prefixes"].get(found[at].text) == "")


def _is_formal(found: Sequence[Symbol], at: int, data: Mapping[str, Any]) -> bool:
    """Whether it is who is addressed after a verb: `legen Sie den Apfel …`; what is to be put follows."""
    is_verb = kind_at(found, at - 1) in ("put", "grasp", "stack", "swap", "group", "apart", "sort")
    return found[at].text in data["formal"] and is_verb and kind_at(found, at + 1) in NAMING


def _excluding(found: Sequence[Symbol], data: Mapping[str, Any]) -> list[Symbol]:
    """`everything that is`, `not a`: a limit, and no negation."""
    return [
        symbol._replace(kind="not_a")
        if at and symbol.text in data["contrast"]["not"] and found[at - 1].text in data["whatever"]
        else symbol
        for at, symbol in enumerate(found)
        if not (at > 1 and symbol.kind == "a" and found[at - 2].text in data["whatever"])
    ]


def _without_reasons(found: Sequence[Symbol]) -> list[Symbol]:
    """Without what comes after `because`, up to the next sign or `and`: a reason is no wish."""
    kept, is_reason = list[Symbol](), False
    for symbol in found:
        is_reason = symbol.kind == "reason" or (is_reason and symbol.kind not in ENDS)
        if not is_reason:
            kept.append(symbol)
    return kept


def _kept_apart(found: Sequence[Symbol]) -> list[Symbol]:
    """`Not near each other` as apart; `no cube may touch another` as all of them apart."""
    for at, symbol in enumerate(found):
        named = past(found, at + 1, ("with", "the", "noun", "colour"))
        if symbol.kind != "no" or named == len(found):
            continue
        near, others = found[named], past(found, named + 1, (*NAMING, "each_other"))
        if near.kind not in ("each_other", "relation") or near.value not in ("next_to", "group"):
            continue
        is_alone = named > at + 1 or others == named + 1
        apart = near._replace(kind="each_other" if is_alone else near.kind, value="apart")
        every = [each for each in found[at + 1 : named] if each.kind in ("noun", "colour")]
        of = [Symbol("all", "all", symbol.text), *every] if every else []
        return _kept_apart([*found[:at], *of, apart, *found[others if is_alone else named + 1 :]])
    return [*found]


def _off_towers(found: Sequence[Symbol]) -> list[Symbol]:
    """With a tower from which something is taken as a thing: `off the stack` asks for none."""
    kept = list[Symbol]()
    for symbol in found:
        is_off = kept[-1:] and (kept[-1].kind, kept[-1].value) == ("relation", "off")
        ahead = kept[-2:]
        is_before_article = [each.kind for each in ahead] in (["relation", "the"], ["relation", "pronoun"])
        is_off_the = is_before_article and ahead[0].value == "off"
        kept.append(symbol._replace(kind="tower") if symbol.kind == "stack" and (is_off or is_off_the) else symbol)
    return kept


def _joined(found: list[Symbol], form: Mapping[str, Any]) -> list[Symbol]:
    """With a verb and the word that ends its clause as one: `bau den Turm ab`, `take the cube down`."""
    for at, symbol in enumerate(found):
        if symbol.text not in form["verb"]:
            continue
        end = up_to(found, at, ENDS)
        if end - 1 > at and found[end - 1].text in form["particle"]:
            if form["kind"] == "down":
                onto = [Symbol("relation", "on", found[end - 1].text), Symbol("desk", "", "")]
                begun = [*found[:at], symbol._replace(kind="put", value=""), *found[at + 1 : end - 1]]
                return [*begun, *onto, *_joined(found[end:], form)]
            verb = symbol._replace(kind=form["kind"], value="")
            rest = [each for each in found[at + 1 : end - 1] if each.kind not in ("the", "stack")]
            return [*found[:at], verb, *rest, *_joined(found[end:], form)]
    return found


def _taken_back(found: list[Symbol], data: Mapping[str, Any]) -> list[Symbol]:
    """With a no that is alone between two signs as a word of correction: `the apple in the tray, no, the tomato`."""
    signs = (",", ".")
    return [
        symbol._replace(kind="rather")
        if symbol.text in data["no"] and kind_at(found, at - 1) in signs and kind_at(found, at + 1) in signs
        else symbol
        for at, symbol in enumerate(found)
    ]


def _corrected(found: list[Symbol]) -> list[Symbol]:
    """With what follows a word of correction in place of what it corrects: the last place, or the one thing alike."""
    at = next((place for place, symbol in enumerate(found) if symbol.kind == "rather"), None)
    if at is None:
        return found
    before, after = [*found[:at]], [*found[at + 1 :]]
    while before and before[-1].kind in (",", "."):
        before.pop()
    while after and after[0].kind in (",", ".", "rather"):
        after.pop(0)
    if not after and found[at].value == "back":
        return found
    if not before or not after:
        return [*before, *after]
    if after[0].kind == "reverse" and (turned := _turned(before)):
        return _corrected([*turned, *after[1:]])
    if after[0].kind == "relation":
        place = [index for index, symbol in enumerate(before) if symbol.kind == "relation"]
        return _corrected([*before[: place[-1]], *after]) if place else found
    relations = [sum(each.kind in ("relation", "each_other") for each in part) for part in (before, after)]
    if relations[0] == 1 <= relations[1] and after[0].kind in NAMING and past(after, 0, NAMING) < len(after):
        return _corrected(after)  # `blue on orange, never mind, red on orange`
    named = up_to(after, 0, (".", ","))
    runs = [run for run in _runs(before) if _may_replace(after[:named], before[run])]
    if all(symbol.kind in NAMING for symbol in after[:named]) and len(runs) == 1:
        instead = _with_noun(after[:named], before[runs[0]])
        return _corrected([*before[: runs[0].start], *instead, *before[runs[0].stop :], *after[named:]])
    return after if after[0].kind in ("put", "grasp", "swap", "toss") else found


def _turned(found: Sequence[Symbol]) -> list[Symbol]:
    """`A on B` as `B on A`; empty where no relation is between two phrases at the end."""
    at = max((place for place, symbol in enumerate(found) if symbol.kind == "relation"), default=0)
    begun = at
    while begun and found[begun - 1].kind in NAMING:
        begun -= 1
    is_whole = begun < at and at + 1 < len(found) and all(symbol.kind in NAMING for symbol in found[at + 1 :])
    return [*found[:begun], *found[at + 1 :], found[at], *found[begun:at]] if is_whole else []


def _may_replace(words: Sequence[Symbol], others: Sequence[Symbol]) -> bool:
    """Whether a phrase may be named in place of another one: both hold things, or both are moved, or of any colour."""
    types, replaced = _types(words), _types(others)
    has_colour = any(symbol.kind == "colour" for symbol in others)
    if types and replaced:
        return (types <= CONTAINERS) == (replaced <= CONTAINERS)
    return types == replaced or has_colour


def _with_noun(words: Sequence[Symbol], others: Sequence[Symbol]) -> list[Symbol]:
    """`the green one` with the noun of what it replaces."""
    noun = next((symbol for symbol in others if symbol.kind == "noun"), None)
    return [noun if symbol.kind == "generic" and noun is not None else symbol for symbol in words]


def _runs(found: Sequence[Symbol]) -> Iterator[slice]:
    """Where phrases about things are."""
    at = 0
    while at < len(found):
        end = past(found, at, NAMING)
        if end > at:
            yield slice(at, end)
        at = end + 1


def _types(found: Sequence[Symbol]) -> frozenset[str]:
    return frozenset[str]().union(*(symbol.value.types for symbol in found if symbol.kind == "noun"))


def _removed(found: list[Symbol], data: Mapping[str, Any]) -> list[Symbol]:
    """`remove the cube from the red one`: `from` after a verb of removing is `off`."""
    at = next((place for place, symbol in enumerate(found) if symbol.text in data["removing"]), len(found))
    return [
        symbol._replace(kind="relation", value="off")
        if place > at and symbol.kind == "with" and symbol.text in data["out_of"]
        else symbol
        for place, symbol in enumerate(found)
    ]


def _moved_out(found: list[Symbol], data: Mapping[str, Any]) -> list[Symbol]:
    """`whatever is in the bin`: what is there, off where it is."""
    return [
        symbol._replace(value="off")
        if symbol.kind == "relation"
        and place
        and found[place - 1].text in data["whatever"]
        and _is_container_next(found[place + 1 :])
        else symbol
        for place, symbol in enumerate(found)
    ]


def _is_container_next(found: Sequence[Symbol]) -> bool:
    noun = next((symbol for symbol in found if symbol.kind not in ("the", "a")), None)
    return noun is not None and noun.is_container


def _cleared_tops(found: list[Symbol], data: Mapping[str, Any]) -> list[Symbol]:
    """`nothing on the blue cube` as a wish: everything off it. `Nothing is on it` reports, and stays."""
    found = found[next((at for at, symbol in enumerate(found) if symbol.kind != ","), 0) :]
    is_wish = len(found) > 1 and found[0].text in data["nothing"] and found[1].kind == "relation"
    if not is_wish or found[1].value not in ("on", "in"):
        return found
    every = Symbol("everything", "", found[0].text)
    return [every, found[1]._replace(value="off"), *found[2:]]


def put_away(found: Sequence[Symbol], words: Vocabulary) -> Iterator[Symbol]:
    """`throw the carrot away` with the bin as where; any other throw stays as it is, and is forbidden."""
    into_bin = [
        Symbol(sense.kind, sense.value, " ".join(phrase))
        for phrase, sense in words.phrases.items()
        if sense.kind == "noun" and sense.value.types == {"bin"}
    ]
    is_binned = names_bin(found)
    found = [  # `throw the carrot out`
        symbol._replace(kind="away") if symbol.text in words.data["out"] else symbol for symbol in found
    ]
    is_away = any(symbol.kind == "away" or _is_thrown_away(symbol) for symbol in found)
    for symbol in found:
        if symbol.kind == "toss" and (is_binned or is_away):
            yield symbol._replace(kind="put")
        elif symbol.kind != "away":
            yield symbol
        if not is_binned and (symbol.kind == "away" or _is_thrown_away(symbol)):
            yield Symbol("relation", "in", symbol.text)
            yield from into_bin[:1]


def names_bin(found: Sequence[Symbol]) -> bool:
    return any(symbol.kind == "noun" and symbol.value.types == {"bin"} for symbol in found)


def _is_thrown_away(symbol: Symbol) -> bool:
    return symbol.kind == "toss" and bool(symbol.value == "away")


def taken_out(found: list[Symbol], words: Vocabulary) -> list[Symbol]:
    """`take the apple out of the tray`: `out of` a container is `off`; words for what is apart are not."""
    if any(symbol.kind == "apart" or symbol.value == "apart" for symbol in found):
        return found
    return [
        symbol._replace(kind="relation", value="off")
        if symbol.kind == "with" and symbol.text in words.data["out_of"] and _is_container_next(found[at + 1 :])
        else symbol
        for at, symbol in enumerate(found)
    ]

# SPDX-License-Identifier: Apache-2.0
"""Values in a sentence: `with alleys four and speed 1.5`, held to the types of the mission's keys.

Rule: a value that does not fit its key is a fault in words; nothing is guessed or coerced.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import dropwhile
from typing import Any

from rai_missions.conversation.grammar.names import key_named
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import KeyView
from rai_missions.engine.decision import Offer
from rai_missions.errors import MissionError
from rai_missions.keys import is_within
from rai_missions.planning.text.numbers import number

__all__ = ("IN_WORDS", "BadValue", "amount", "amounts_in", "key_value", "parameter_keys", "read_arguments")

ReadValue = Callable[[Sequence[str], KeyView, Language], Any]
DECIMALS = 12
"""Decimals of a number that was given in another unit than its key's."""
SHORTEST_UNIT = 4
"""Letters of the shortest unit in a sentence of the mission: `min` may be the least there."""
LONGEST_VALUE = 4
"""Words of the longest number with its unit."""
NOTHING: Mapping[str, Any] = {}
IN_WORDS = frozenset({"integer", "number", "boolean", "string"})
"""The types of keys whose values can be spoken."""


class BadValue(MissionError):
    """A sentence gives a value that does not fit; its text is for the person, in the dialogue's language.

    Args:
        text: What is wrong, and what would be right.
        key: The argument that it was for, where that is known.
        others: The values of the other parts of a list of arguments.
    """

    def __init__(self, text: str, key: str = "", others: Mapping[str, Any] = NOTHING) -> None:
        super().__init__(text)
        self.key, self.others = key, others


def key_value(words: Sequence[str], key: KeyView, language: Language) -> Any:
    """The value that the words are for a key.

    Raises:
        BadValue: They are none of its type.
    """
    name, kind = language.name_of(key.name), _kind(key, language)
    if key.type not in IN_WORDS:
        raise BadValue(language.text("not_spoken", name=name, type=kind), key.name)
    value: Any = amount(words, key, language)
    if key.type == "boolean":
        given = " ".join(words)
        value = True if given in language.data["true"] else False if given in language.data["false"] else None
    elif key.type == "string":
        value = " ".join(words)
    elif key.type == "integer" and not isinstance(value, int):
        value = None
    if value is None or not is_within(value, key.minimum, key.maximum):
        raise BadValue(language.text("bad_value", given=" ".join(words), name=name, type=kind), key.name)
    return value


def _kind(key: KeyView, language: Language) -> str:
    """The type of a key in words, with its range: `a whole number from 1 to 3600`."""
    kind: str = language.data["texts"]["types"][key.type]
    unit = language.unit_of(key.name)
    least, most = ("" if each is None else language.decimals(f"{each:g}") for each in (key.minimum, key.maximum))
    if not least and not most:
        return kind
    form = "range" if least and most else "range_least" if least else "range_most"
    return f"{language.text(form, kind=kind, least=least, most=most)} {unit}".rstrip()


def unit_for(key: KeyView, language: Language) -> str:
    """The unit of a number: its name ends with it, or its `about` has the word, `how many minutes to wait`."""
    named = (
        word for word in language.normaliser.words(key.about) if len(word) >= SHORTEST_UNIT and language.factors(word)
    )
    return language.unit_of(key.name) or language.data["units"].get(key.name) or next(named, "")


def amounts_in(words: Sequence[str], key: KeyView, language: Language) -> Iterator[list[str]]:
    """The words of each number for a key, the longest first: with its unit, or where its name is in the clause.

    Args:
        words: The words of a clause.
        key: Of a number.
        language: Its numbers and units.
    """
    unit, name = unit_for(key, language), language.singular(key.name)
    units = frozenset(each.split()[-1] for each in language.factors(unit))
    is_named = name in map(language.singular, words)
    for size in range(LONGEST_VALUE, 1 if unit else 0, -1):
        for at in range(len(words) - size + 1):
            span = list(words[at : at + size])
            is_amount = span[-1] in units if unit else is_named and not set(span) <= language.articles
            bare = span[span[0] in language.articles :]
            if is_amount and any(amount(each, key, language) is not None for each in (span, bare)):
                yield span


def amount(words: Sequence[str], key: KeyView, language: Language) -> int | float | None:
    """The number that the words are, with or without a unit: `five minutes` are 300 for a key in seconds.

    A word that makes it less exact is left out, `about five`, `a minute` is one, and `twice` are two of no unit.
    """
    data = language.data
    words = list(dropwhile(frozenset(data["approximating"]).__contains__, words))
    if (value := number(words, data)) is not None:
        return value
    unit, given = unit_for(key, language), " ".join(words)
    if not unit and given in data["repetitions"]:
        return int(data["repetitions"][given])
    shares: Mapping[str, int] = data["shares"] if "%" in language.factors(unit) else {}
    if given in shares:
        return shares[given]
    factors = language.factors(unit) or {language.name_of(key.name).split()[-1]: 1.0}
    singular = {language.singular(unit): factor for unit, factor in factors.items()}
    for at in range(1, len(words)):
        measure = " ".join([*words[at:-1], language.singular(words[-1])])
        count = data["indefinite"].get(" ".join(words[:at]), number(words[:at], data))
        if count is not None and measure in singular:
            return _whole(round(count * singular[measure], DECIMALS))
    return None


def _whole(value: float) -> int | float:
    """`1.5 minutes` are 90 seconds, a whole number."""
    return round(value) if value == round(value) else value


def parameter_keys(offer: Offer) -> list[KeyView]:
    """The parameters of an option as keys."""
    properties: Mapping[str, Mapping[str, Any]] = (offer.parameters or {}).get("properties") or {}
    kinds = {name: str(each.get("type")) for name, each in properties.items()}
    return [
        KeyView(
            name,
            kind if (kind := kinds[name]) in IN_WORDS else "object",  # type: ignore[arg-type]
            about=str(each.get("description", "")),
            minimum=each.get("minimum"),
            maximum=each.get("maximum"),
        )
        for name, each in properties.items()
    ]


def read_arguments(
    words: Sequence[str], keys: Sequence[KeyView], language: Language, *, owner: str, value: ReadValue = key_value
) -> Mapping[str, Any]:
    """The values of a list of arguments.

    Args:
        words: What follows `with`.
        keys: The arguments that there are.
        language: The grammar.
        owner: Whose arguments they are, for a fault.
        value: Reads the words for an argument.

    Raises:
        BadValue: A part names no argument, or its value does not fit.
    """
    values, misfit = dict[str, Any](), None
    for chunk in _chunks(words, language):
        try:
            key, found = _one(chunk, keys, language, owner, value)
            values[key.name] = found
        except BadValue as error:
            misfit = misfit or error
    if misfit is not None:
        raise BadValue(str(misfit), misfit.key, values)
    return values


def _chunks(words: Sequence[str], language: Language) -> list[list[str]]:
    chunks: list[list[str]] = [[]]
    for word in words:
        if word in language.data["argument_joints"]:
            chunks.append([])
        else:
            chunks[-1].append(word)
    return [chunk for chunk in chunks if chunk]


def _one(
    chunk: list[str], keys: Sequence[KeyView], language: Language, owner: str, value: ReadValue
) -> tuple[KeyView, Any]:
    by_name, misfit = {key.name: key for key in keys}, None
    for slots in language.argument.match(chunk):
        path = key_named(slots["key"].split(), by_name, language, strict=True)
        if path not in by_name:
            continue
        try:
            return by_name[path], value(slots["value"].split(), by_name[path], language)
        except BadValue as error:
            misfit = misfit or error
    if misfit is not None:
        raise misfit
    names = language.listed([language.name_of(key.name) for key in keys]) or language.text("no_arguments")
    raise BadValue(language.text("bad_argument", given=" ".join(chunk), mission=spoken(owner), arguments=names))

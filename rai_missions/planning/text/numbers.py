# SPDX-License-Identifier: Apache-2.0
"""Numbers in words and digits: `twenty five`, `one and a half`, `minus two`, `2.5`; in German `fünfundzwanzig`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

__all__ = ("number", "numbered", "ordinal")

DIGITS = re.compile(r"-?\d{1,15}(?:[.,]\d{1,9})?")


def number(words: Sequence[str], data: Mapping[str, Any]) -> int | float | None:
    """The number that the words are as a whole; None where they are none.

    Args:
        words: In lower case.
        data: The language's file.
    """
    if not words:
        return None
    if words[0] == data["minus"]:
        rest = number(words[1:], data)
        return None if rest is None else -rest
    if len(words) == 1 and DIGITS.fullmatch(words[0]):
        return _digits(words[0], data["decimal"])
    if (half := _with_half(words, data)) is not None:
        return half
    if data["point"] in words:
        return _with_decimals(words, data)
    return _whole(words, data)


def _with_half(words: Sequence[str], data: Mapping[str, Any]) -> float | None:
    """`half an`, `eine halbe`, `one and a half`."""
    text = " ".join(words)
    if text in data["halves"]:
        return float(data["halves"][text])
    before = text.removesuffix(f" {data['and_half']}")
    whole = None if before == text else _whole(before.split(), data)
    return None if whole is None else whole + 0.5


def _digits(text: str, decimal: str) -> int | float | None:
    sign = next((each for each in text if each in ".,"), "")
    if not sign:
        return int(text)
    is_grouped = sign != decimal and re.fullmatch(r"-?\d{1,3}[.,]\d{3}", text) is not None
    value = float(text.replace(sign, "" if is_grouped else "."))
    return int(value) if is_grouped else value if math.isfinite(value) else None


def _with_decimals(words: Sequence[str], data: Mapping[str, Any]) -> float | None:
    at = list(words).index(data["point"])
    whole = number(words[:at], data)
    decimals = [number([word], data) for word in words[at + 1 :]]
    if (
        not isinstance(whole, int)
        or not decimals
        or not all(isinstance(each, int) and 0 <= each < 10 for each in decimals)
    ):
        return None
    return float(f"{whole}." + "".join(str(each) for each in decimals))


def _whole(words: Sequence[str], data: Mapping[str, Any]) -> int | None:
    numbers, factors, joint = data["numbers"], data["hundred"], data["number_joint"]
    total, part, used = 0, 0, False
    for word in words:
        values = [numbers.get(word)] if word in numbers else _compound(word, numbers, joint)
        if word in factors and used:
            part = max(part, 1) * factors[word]
            if factors[word] == 1000:
                total, part = total + part, 0
        elif word in factors:
            part, used = factors[word], True
        elif word == joint and used:
            continue
        elif values[0] is not None and (part % 10 == 0) and (part == 0 or values[0] < 10 or part >= 100):
            part, used = part + values[0], True
        else:
            return None
    return total + part if used else None


def _compound(word: str, numbers: Mapping[str, int], joint: str) -> list[int | None]:
    """`fünfundzwanzig` is one word."""
    for tens, value in numbers.items():
        ones = word.removesuffix(joint + tens)
        if value >= 20 and ones != word and (ones in numbers or ones == "ein"):
            return [value + numbers.get(ones, 1)]
    return [None]


def ordinal(words: Sequence[str], data: Mapping[str, Any]) -> int | None:
    """`second`, `2nd`, `two` or `2` is 2; `last` is −1."""
    if len(words) == 1 and words[0] in data["ordinals"]:
        found: int = data["ordinals"][words[0]]
        return found
    value = number(words, data)
    return value if isinstance(value, int) else None


def numbered(words: Sequence[str], data: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """The other forms of a name that ends with a number: `bay 2`, `bay number 2` and `second bay` of `bay two`.

    Args:
        words: The words of the name, in lower case.
        data: The language's file.
    """
    starts = (at for at in range(1, len(words)) if isinstance(number(words[at:], data), int))
    if (at := next(starts, None)) is None:
        return
    noun, value = words[:at], int(number(words[at:], data) or 0)
    for each in (str(value), *_in_words(value, data)):
        yield (*noun, *each.split())
        yield (*noun, data["number_word"], *each.split())
    for each, place in data["ordinals"].items():
        if place == value and len(each) > 1:
            yield (each, *noun)


def _in_words(value: int, data: Mapping[str, Any]) -> Iterator[str]:
    """A number below a hundred in words."""
    words = {each: word for word, each in data["numbers"].items()}
    tens = words.get(value - value % 10, "") if value >= 20 else ""
    ones = words.get(value % 10, "")
    ways = (words.get(value, ""), f"{tens} {ones}", f"{ones}{data['number_joint']}{tens}")
    yield from (way for way in ways if way.strip() == way and way and number(way.split(), data) == value)

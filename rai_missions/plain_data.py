# SPDX-License-Identifier: Apache-2.0
"""Values as plain data: copies that share nothing, JSON for readers, and one line of text for people.

Rule: what a client, a server or an answerer receives is a copy; changing it changes neither mission nor blackboard.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, TypeGuard

from rai_missions.image import Image

__all__ = (
    "apart",
    "are_finite",
    "at_path",
    "carried",
    "is_number",
    "is_numeric",
    "json_object",
    "json_value",
    "listed",
    "plain",
    "printable",
    "quoted",
    "rounded",
    "text_fault",
)

FLOATS = frozenset({float})
LEAVES = frozenset({str, int, float, bool, type(None)})
DECIMALS = {"m": 3, "s": 2}
"""The decimals of a number whose name ends in a unit."""
LEAST, MOST = 1e-5, 1e15
"""A number below the one, or from the other on, is shown with its power of ten."""


def apart(value: Any) -> Any:
    """The value with objects and lists of its own, at every depth; a picture stays the one it is."""
    if type(value) is dict or isinstance(value, Mapping):
        return {name: apart(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        made = [item if type(item) in LEAVES else apart(item) for item in value]
        return made if isinstance(value, list) else tuple(made)
    return value


def is_numeric(value: Any) -> TypeGuard[int | float]:
    """Whether it is of a type of numbers, also where it is infinite or NaN; true and false are no numbers."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_number(value: Any) -> TypeGuard[int | float]:
    """Whether it is a number that can be reckoned with: finite, and no integer beyond all floating-point numbers."""
    try:
        return is_numeric(value) and math.isfinite(value)
    except OverflowError:
        return False


def are_finite(values: Sequence[Any]) -> bool:
    """Whether all are floating-point numbers, and finite: a scan or a map, which needs no look at each number."""
    return FLOATS.issuperset(map(type, values)) and all(map(math.isfinite, values))


def text_fault(text: str) -> str:
    """Why no message can carry a text; empty where it can.

    NUL ends a text of C, so what follows would be lost; half a surrogate pair has no form in UTF-8.
    """
    if "\0" in text:
        return f"character {text.index(chr(0))} is NUL, which no message carries"
    try:
        text.encode()
    except UnicodeEncodeError as fault:
        return f"character {fault.start} is half a surrogate pair, which is no text"
    return ""


def carried(value: Any) -> Any:
    """Plain data whose texts a message can carry: what `text_fault` finds is replaced. For reports alone."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode().replace("\0", "?") if text_fault(value) else value
    if isinstance(value, Mapping):
        return {carried(name): carried(item) for name, item in value.items()}
    return [carried(item) for item in value] if isinstance(value, list | tuple) else value


def plain(value: Any) -> Any:
    """Any value as JSON has it: bytes in base64, a picture by its reference, NaN and infinity as text."""
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, bytes | bytearray | memoryview):
        return base64.b64encode(value).decode()
    if isinstance(value, Image):
        return {"picture": value.ref, "width": value.width, "height": value.height, "encoding": value.encoding}
    if isinstance(value, Sequence | AbstractSet):
        return value.copy() if type(value) is list and are_finite(value) else [plain(item) for item in value]
    return str(value)


def at_path(message: Any, path: str) -> Any:
    """The field at a path, `pose.position.x`, or an item of a list, `ranges.0`; None where there is none."""
    for word in path.split(".") if path else ():
        if isinstance(message, Mapping):
            message = message.get(word)
        elif isinstance(message, list | tuple) and word.isdecimal() and int(word) < len(message):
            message = message[int(word)]
        else:
            return None
    return message


def json_value(text: str | bytes, other: Any = None) -> Any:
    """The value that JSON text holds; `other` where it holds none, or one that is nested too deeply."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return other


def json_object(text: str | bytes) -> dict[str, Any] | None:
    """The object that JSON text holds; None where it holds none."""
    found = json_value(text)
    return found if isinstance(found, dict) else None


def printable(text: str, instead: str = "�") -> str:
    """A text that cannot move the cursor, ring the bell or turn the line around.

    Args:
        text: Anyone's.
        instead: What is shown for each character that would.
    """
    return "".join(letter if letter.isprintable() else instead for letter in text)


def listed(value: Any, name: str = "") -> str:
    """A value in one line: `pose x 1.5, y 2, speed 1.2`; numbers are rounded to their meaning.

    Objects in a list are apart from each other: `[x 1, y 2; x 3, y 4]`.

    Args:
        value: Anything.
        name: The name of the key or field: its last part is the unit.
    """
    if isinstance(value, Mapping):
        return ", ".join(f"{each} {listed(item, str(each))}" for each, item in value.items())
    if isinstance(value, list | tuple):
        between = "; " if any(isinstance(item, Mapping) for item in value) else ", "
        return "[" + between.join(listed(item, name) for item in value) + "]"
    if isinstance(value, Image):
        return f"picture {value.ref}"
    if isinstance(value, float):
        return rounded(value, name)
    if value is None or isinstance(value, bool):
        return {None: "none", True: "true", False: "false"}[value]
    return str(value)


def quoted(value: Any, name: str = "") -> str:
    """A value as JSON in one line, with `rounded` numbers: a text inside it cannot look like another field.

    Args:
        value: Anything; a text alone is as it is.
        name: The name of the key or field: its last part is the unit.
    """
    return value if isinstance(value, str) else json.dumps(_coarse(plain(value), name), ensure_ascii=False)


def _coarse(value: Any, name: str) -> Any:
    if isinstance(value, dict):
        return {each: _coarse(item, each) for each, item in value.items()}
    if isinstance(value, list):
        return [_coarse(item, name) for item in value]
    if not isinstance(value, float):
        return value
    coarse = float(rounded(value, name))
    return int(coarse) if coarse.is_integer() and abs(coarse) < MOST else coarse


def rounded(value: float, name: str = "") -> str:
    """A number as a person reads it: `0.3` for 0.30000000000000004.

    A millimetre of a name in `_m` and a hundredth of a second of one in `_s` are the least that is shown. Of other
    numbers three decimals are, and of one below 0.1 three digits.

    Args:
        value: The number.
        name: The name of the key or field: its last part is the unit.
    """
    if not math.isfinite(value):
        return str(value)
    if not LEAST <= abs(value) < MOST:
        return f"{value:.3g}"
    places = DECIMALS.get(name.rpartition("_")[2]) or max(3, 2 - math.floor(math.log10(abs(value))))
    text = f"{value:.{places}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text

# SPDX-License-Identifier: Apache-2.0
"""Places and gaps from symbols: `x 0.5 y 0.1`, `(0.4, -0.2)`, `40 cm ahead and 10 to your left`, `a gap of 5 cm`.

Rule: without any unit a place is in metres, a gap is asked back; a number takes the unit of the one before it only
where it has no decimals.
"""

from __future__ import annotations

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.noun_phrases import Cursor
from rai_missions.planning.reading.symbols import Quantity

__all__ = ("gap", "has_place", "place", "shift")

FARTHEST, WIDEST = 10.0, 1.0
"""Metres of a coordinate and of a gap, at the most: those of the format."""
DIGITS = 6
"""Decimals of metres that are kept: a micrometre."""


def has_place(cursor: Cursor) -> bool:
    """Whether coordinates begin here."""
    ahead = int(cursor.kind() == "relation" and cursor.value() in ("to", "on"))
    ahead += int(cursor.kind(ahead) == "the" and cursor.kind(ahead + 1) == "place")
    kinds = [cursor.kind(ahead), cursor.kind(ahead + 1)]
    if kinds[0] in ("axis", "place", "("):
        return True
    return kinds[0] == "number" and kinds[1] not in ("relation", "gap", "with")


def place(cursor: Cursor, lexicon: Vocabulary) -> tuple[float, float]:
    """The coordinates here, in metres.

    Raises:
        Unread: They are not both there, or their unit is not sure.
    """
    cursor.skip("relation", "the", "place", ":")
    is_open = cursor.skip("(")
    cursor.skip("the")
    found = dict[str, Quantity]()
    for name in "xy":
        quantity, axis = _coordinate(cursor, name)
        if quantity is None or axis in found:
            raise lexicon.unread("coordinates")
        found[axis] = quantity
        if len(found) == 1:
            cursor.skip(",", "and")
    if is_open and not cursor.skip(")"):
        raise lexicon.unread("coordinates")
    first, second = found.values()
    metres = dict(zip(found, (_metres(first, None, lexicon), _metres(second, first, lexicon)), strict=True))
    if first.unit is None and second.unit is not None:
        raise lexicon.unread("number", f"{first.value:g}")
    if set(metres) != {"x", "y"}:
        raise lexicon.unread("coordinates")
    return metres["x"], metres["y"]


def _coordinate(cursor: Cursor, name: str) -> tuple[Quantity | None, str]:
    if cursor.kind() == "axis":
        name = cursor.take().value
        cursor.skip("=", ":", "is")
    if cursor.kind() != "number":
        return None, name
    quantity: Quantity = cursor.take().value
    if cursor.kind() == "side":
        side = cursor.take().value
        name = "x" if side in ("ahead", "back") else "y"
        quantity = quantity._replace(value=-quantity.value) if side in ("right", "back") else quantity
    return quantity, name


def _metres(quantity: Quantity, before: Quantity | None, lexicon: Vocabulary) -> float:
    unit = quantity.unit
    if unit is None and before is not None and before.unit not in (None, 1.0):
        if not quantity.is_whole:
            raise lexicon.unread("number", f"{quantity.value:g}")
        unit = before.unit
    return _near(quantity.value * (unit or 1.0), FARTHEST, lexicon)


def _near(metres: float, most: float, lexicon: Vocabulary) -> float:
    if abs(metres) > most:
        raise lexicon.unread("off_desk", f"{metres:g}", refused=True)
    return round(metres, DIGITS)


def shift(cursor: Cursor, lexicon: Vocabulary) -> tuple[float, float] | None:
    """How far ahead and to the left in metres, where one number with a side is here: `10 cm to the left`.

    Two numbers may be those of a place: then it is None, and the cursor stays.

    Raises:
        Unread: The number has no unit, or is further than the desk reaches.
    """
    before = cursor.at
    if cursor.kind() != "number" or cursor.kind(1) != "side":
        return None
    quantity, axis = _coordinate(cursor, "x")
    after = 1 if cursor.kind() in (",", "and") else 0
    if quantity is None or cursor.kind(after) in ("number", "side"):
        cursor.back_to(before)
        return None
    if quantity.unit is None:
        raise lexicon.unread("number", f"{abs(quantity.value):g}")
    metres = _near(quantity.value * quantity.unit, FARTHEST, lexicon)
    return (metres, 0.0) if axis == "x" else (0.0, metres)


def gap(cursor: Cursor, lexicon: Vocabulary) -> float | None:
    """The gap in metres that is given here; None where none is.

    Raises:
        Unread: It has no unit, or is less than nothing.
    """
    before = cursor.at
    cursor.skip("with", "the", "a")
    cursor.skip("gap")
    cursor.skip("with")
    if cursor.kind() != "number":
        cursor.back_to(before)
        return None
    quantity: Quantity = cursor.take().value
    cursor.skip("gap")
    if quantity.unit is None:
        raise lexicon.unread("number", f"{quantity.value:g}")
    if quantity.value < 0:
        raise lexicon.unread("left_out", f"{quantity.value:g}", reason="number")
    return _near(quantity.value * quantity.unit, WIDEST, lexicon)

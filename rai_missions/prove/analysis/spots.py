# SPDX-License-Identifier: Apache-2.0
"""Where numbers lie that guards compare with each other: as many as represent every order that a run can bring.

Rule: arguments stay where they are in a run, so there is room on both sides of each for what moves.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from itertools import pairwise
from typing import NamedTuple

__all__ = ("NumberRange", "Spots")


class NumberRange(NamedTuple):
    """Between which numbers keys may lie."""

    low: float
    high: float

    @property
    def every(self) -> range:
        """All whole numbers that lie there; none where it has no two ends."""
        is_closed = math.isfinite(self.low) and math.isfinite(self.high)
        return range(math.ceil(self.low), math.floor(self.high) + 1) if is_closed else range(0)

    def wholes(self, many: int) -> range:
        """`many` successive whole numbers that lie there; none where there are fewer."""
        first = math.ceil(self.low) if self.low > -math.inf else math.floor(min(self.high - many + 1, 0))
        return range(first, first + many if first + many - 1 <= self.high else first)


class Spots(NamedTuple):
    """The numbers of keys that are compared with each other.

    Between two constants lie spots for what moves, one for what stays, spots for what moves, and so on. Where whole
    numbers are too few there for all spots, each of them counts as a constant.
    """

    constants: Collection[float]
    stays: int
    """How many of the keys stay where they are."""
    moves: int
    """How many of the others can differ from each other, between two numbers; one where that makes no difference."""
    whole: bool
    """Some of the keys take whole numbers only."""
    first: int = 0
    """The first spot, if there are no constants."""
    within: NumberRange = NumberRange(-math.inf, math.inf)
    """Where the only key that stays lies; where several stay, the ends of their ranges are constants."""

    def of(self, *, stays: bool) -> Iterator[float]:
        """The numbers of a key that stays, or of one that moves, ascending."""
        constants = sorted({*self.constants, *self._few()})
        for low, high in pairwise((-math.inf, *constants, math.inf)):
            spots, staying = self._around_one(low, high) if self.stays == 1 else self._alternating(low, high)
            yield from staying if stays else spots
            if high != math.inf:
                yield high

    def _alternating(self, low: float, high: float) -> tuple[list[float], list[float]]:
        """The spots between two constants, and those of them for what stays."""
        spots = self._between(low, high, self._many)
        return spots, spots[self.moves :: self.moves + 1]

    def _around_one(self, low: float, high: float) -> tuple[list[float], list[float]]:
        """The spots between two constants, with one for what stays, within its range, if any of it lies there."""
        middle, many = self._middle(low, high), self.moves
        if middle is None:
            return self._between(low, high, many), []
        return [*self._between(low, middle, many), middle, *self._between(middle, high, many)], [middle]

    def _middle(self, low: float, high: float) -> float | None:
        """A number of the range between two constants, with room on both sides of it if there is any."""
        least, most = max(low, self.within.low), min(high, self.within.high)
        if self.whole:
            first = math.floor(least) + 1 if least == low > -math.inf else least
            last = math.ceil(most) - 1 if most == high < math.inf else most
            wished = (
                low + self.moves + 1 if low > -math.inf else high - self.moves - 1 if high < math.inf else self.first
            )
            found: float = math.ceil(min(max(wished, first), last))
        elif math.isfinite(least) and math.isfinite(most):
            found = (least + most) / 2
        else:
            found = least + 1 if math.isfinite(least) else most - 1 if math.isfinite(most) else self.first
        return found if low < found < high and least <= found <= most else None

    @property
    def _many(self) -> int:
        return self.moves * (self.stays + 1) + self.stays

    def _few(self) -> Iterator[float]:
        """The whole numbers between two constants that are too few for all spots."""
        for low, high in pairwise(sorted(self.constants)):
            inside = self._wholes(low, high, self._many)
            yield from inside if len(inside) < self._many else ()

    def _wholes(self, low: float, high: float, many: int) -> list[float]:
        """Whole numbers between two others, so many at the most."""
        first = math.floor(low) + 1
        return [each for each in range(first, first + many) if each < high] if self.whole else []

    def _between(self, low: float, high: float, many: int) -> list[float]:
        if high == math.inf:
            first = self.first if low == -math.inf else math.floor(low) + 1
            return [*range(first, first + many)]
        if low == -math.inf:
            least = math.ceil(high) if self.whole else high
            return [least - step for step in range(many, 0, -1)]
        return self._wholes(low, high, many) or [low + (high - low) * step / (many + 1) for step in range(1, many + 1)]

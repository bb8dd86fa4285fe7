# SPDX-License-Identifier: Apache-2.0
"""Where things are in the orchard: alleys, tree rows, headlands, home.

Alley `i` runs along x from 0 to `length_m` at `y = i * width_m`; a row of trees stands half a width to either side.
The headlands, where the tractor turns, lie beyond the mouths of the alleys in the west (x < 0) and in the east.
"""

from __future__ import annotations

from dataclasses import dataclass

from rai_missions.errors import UsageError

__all__ = ("Layout",)

MARGIN_M = 2.0
"""From the end of the tree rows to the place where the rear axle begins to turn."""
TREE_SPACING_M = 3.0


@dataclass(frozen=True)
class Layout:
    """The plan of an orchard; metres, x along the alleys, y across them."""

    alleys: int = 6
    length_m: float = 20.0
    width_m: float = 4.5
    """From alley to alley; the tractor turns from one into the next in a half circle of this diameter."""

    def __post_init__(self) -> None:
        if not 1 <= self.alleys <= 30:
            raise UsageError(f"alleys: an orchard has 1 to 30 alleys, not {self.alleys}")
        if not 12.0 <= self.length_m <= 200.0:
            raise UsageError(f"length_m: an alley is 12 to 200 m long, not {self.length_m}")

    @property
    def radius_m(self) -> float:
        """Radius of every turn, at the rear axle."""
        return self.width_m / 2

    @property
    def mouths_m(self) -> tuple[float, float]:
        """x of the western and of the eastern mouths of the alleys."""
        return -MARGIN_M, self.length_m + MARGIN_M

    @property
    def home(self) -> tuple[float, float, float]:
        """Where the tractor lives: x, y and heading (rad, 0 looks east)."""
        return -MARGIN_M - 3 * self.radius_m, 0.0, 0.0

    def centre_m(self, alley: int) -> float:
        """y of an alley's middle."""
        return alley * self.width_m

    def alley_at(self, x: float, y: float) -> int | None:
        """The alley that a point lies in, if it lies in one."""
        alley = round(y / self.width_m)
        inside = 0 <= alley < self.alleys and -MARGIN_M <= x <= self.length_m + MARGIN_M
        return alley if inside and abs(y - self.centre_m(alley)) < self.radius_m else None

    def trees(self) -> tuple[tuple[float, float], ...]:
        """Where the trunks are."""
        count = int((self.length_m - 2.0) / TREE_SPACING_M) + 1
        step = (self.length_m - 2.0) / (count - 1)
        rows = (self.centre_m(row) - self.radius_m for row in range(self.alleys + 1))
        return tuple((1.0 + step * k, y) for y in rows for k in range(count))

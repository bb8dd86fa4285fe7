# SPDX-License-Identifier: Apache-2.0
"""A map of cells, as small as a reader can take it in: the worst of the cells that share a character.

Rule: nothing here knows a connector. Where the map ends, and where it is unknown, is never shown as free.

Source: nav_msgs/msg/OccupancyGrid (rows from the origin on, -1 unknown, 0 to 100 percent); map_server's thresholds.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut_repr
from rai_missions.tools.transforms import planar

__all__ = ("LEGEND", "OccupancyGrid", "Window", "grid_of")

FREE, UNKNOWN, UNCERTAIN, OCCUPIED = ".", "?", "+", "#"
LEGEND = "'#' occupied, '+' uncertain, '?' unknown or outside of the map, '.' free"
WORST_LAST = (FREE, UNKNOWN, UNCERTAIN, OCCUPIED)
FREE_UP_TO, OCCUPIED_FROM = 25, 65
"""Percent."""
MOST_SHOWN = 40
"""Characters of a row, and rows."""
KINDS = bytes(
    WORST_LAST.index(
        UNKNOWN if cell > 100 else OCCUPIED if cell >= OCCUPIED_FROM else FREE if cell <= FREE_UP_TO else UNCERTAIN
    )
    for cell in range(256)
)
"""A cell's byte → its place in `WORST_LAST`; what is no percentage is unknown, -1 among it."""


class Window(NamedTuple):
    """A part of a map, in characters."""

    rows: tuple[str, ...]
    """From the last row of the map to its first: the y axis of the grid points up, its x axis right."""
    cell_m: float
    """The side of what one character represents, in metres."""
    corner: tuple[float, float]
    """Where the lower left corner of the first character of the last row lies in the map's frame, in metres."""

    def labelled(self) -> dict[str, str]:
        """Each row under its height above the corner, in metres along the grid's y axis."""
        heights = range(len(self.rows) - 1, -1, -1)
        return {f"{round(height * self.cell_m, 3):g}": row for height, row in zip(heights, self.rows, strict=True)}


class OccupancyGrid:
    """A checked map.

    Args:
        width: Cells of a row.
        height: Rows.
        resolution: The side of a cell, in metres.
        origin: x, y and yaw of the first cell's corner in the map's frame, in metres and radians.
        cells: A byte a cell, each a place in `WORST_LAST`.
    """

    def __init__(
        self, width: int, height: int, resolution: float, origin: tuple[float, float, float], cells: bytes
    ) -> None:
        self.width, self.height, self.resolution, self.origin = width, height, resolution, origin
        self._cells = cells

    def counts(self) -> dict[str, int]:
        """How many cells are of each kind."""
        names = ("free", "unknown", "uncertain", "occupied")
        return {name: self._cells.count(place) for place, name in enumerate(names)}

    def cell_at(self, x: float, y: float) -> str:
        """The kind of the cell at a point of the map's frame; outside of the map it is unknown."""
        column, row = (math.floor(each / self.resolution) for each in self._inside(x, y))
        if not (0 <= column < self.width and 0 <= row < self.height):
            return UNKNOWN
        return WORST_LAST[self._cells[row * self.width + column]]

    def window(self, center: tuple[float, float] | None = None, radius_m: float = math.inf) -> Window:
        """The map, or the square around a point, with at most `MOST_SHOWN` characters a side.

        Raises:
            UsageError: The square is wholly outside of the map.
        """
        left, bottom, right, top = 0, 0, self.width, self.height
        if center is not None and math.isfinite(radius_m):
            x, y = (each / self.resolution for each in self._inside(*center))
            reach = radius_m / self.resolution
            left, right = math.floor(x - reach), math.ceil(x + reach)
            bottom, top = math.floor(y - reach), math.ceil(y + reach)
            if right <= 0 or top <= 0 or left >= self.width or bottom >= self.height:
                raise UsageError(f"({center[0]:g}, {center[1]:g}) ± {radius_m:g} m is outside of the map")
        step = max(1, math.ceil(max(right - left, top - bottom) / MOST_SHOWN))
        rows = [
            "".join(self._worst(column, row, step) for column in range(left, right, step))
            for row in range(bottom, top, step)
        ]
        return Window(tuple(reversed(rows)), step * self.resolution, self._outside(left, bottom))

    def _worst(self, left: int, bottom: int, step: int) -> str:
        """The worst of the cells of a square; what is outside of the map is unknown."""
        right, top = left + step, bottom + step
        is_inside = left >= 0 and bottom >= 0 and right <= self.width and top <= self.height
        worst = 0 if is_inside else 1
        for row in range(max(bottom, 0), min(top, self.height)):
            part = self._cells[row * self.width + max(left, 0) : row * self.width + max(0, min(right, self.width))]
            for place in range(len(WORST_LAST) - 1, worst, -1):
                if place in part:
                    worst = place
                    break
        return WORST_LAST[worst]

    def _inside(self, x: float, y: float) -> tuple[float, float]:
        """A point of the map's frame, in metres along the grid's axes."""
        x0, y0, yaw = self.origin
        dx, dy, cosine, sine = x - x0, y - y0, math.cos(yaw), math.sin(yaw)
        return dx * cosine + dy * sine, dy * cosine - dx * sine

    def _outside(self, column: float, row: float) -> tuple[float, float]:
        """A corner of a cell, in the map's frame."""
        x0, y0, yaw = self.origin
        dx, dy, cosine, sine = column * self.resolution, row * self.resolution, math.cos(yaw), math.sin(yaw)
        return x0 + dx * cosine - dy * sine, y0 + dx * sine + dy * cosine


def grid_of(message: Mapping[str, Any]) -> OccupancyGrid:
    """The map of a nav_msgs/msg/OccupancyGrid.

    Raises:
        ConnectorError: It is none, or its numbers contradict each other.
    """
    try:
        info = message["info"]
        width, height, resolution = int(info["width"]), int(info["height"]), float(info["resolution"])
        origin = planar(info["origin"])
        cells = array("b", message["data"]).tobytes().translate(KINDS)
    except (KeyError, TypeError, ValueError, OverflowError) as fault:
        raise ConnectorError(
            f"{cut_repr(message, 80)} is no nav_msgs/msg/OccupancyGrid: {cut_repr(fault, 60)}"
        ) from None
    if width < 1 or height < 1 or len(cells) != width * height:
        raise ConnectorError(f"the map has {len(cells)} cells, and states {width} × {height}")
    if not 0 < resolution < math.inf or not all(map(math.isfinite, origin)):
        raise ConnectorError(f"the map states a resolution of {resolution} m and an origin at {origin}")
    return OccupancyGrid(width, height, resolution, origin, cells)

# SPDX-License-Identifier: Apache-2.0
"""Plots as inline SVG, one a line of a table: intervals, shares and lengths on a common scale.

Rule: positions are percentages of the plot's width, so that it fits a phone and a wall; each value is in the table as
text, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rai_missions.campaign.statistics import Interval
from visualize.campaign_page.markup import Markup, node

__all__ = (
    "COLOURS",
    "at_most",
    "axis",
    "chance",
    "colour",
    "interval_plot",
    "lasting",
    "length_plot",
    "percent",
    "share_plot",
    "span",
)

COLOURS = 7
"""Colours of options, then they begin again; classes `c0` to `c6` of the style sheet."""
GRID = (0, 25, 50, 75, 100)
HIGH = 22
"""Pixels."""
INSET = 1.5
"""Per cent at each end, so that a dot at 0 or 1 is whole."""


def percent(share: float) -> str:
    """A share as text; a dash where it is none."""
    return "–" if math.isnan(share) else f"{100 * share:.1f} %"


def at_most(found: Interval) -> str:
    """A share with the upper end of its interval; a dash where it is none."""
    return percent(found.share) + ("" if math.isnan(found.share) else f" (≤ {percent(found.high)})")


def chance(p: float) -> str:
    """A probability, as a reader needs it."""
    return f"{p:.2g}" if p >= 1e-4 else "< 0.0001"


def lasting(seconds: float) -> str:
    """A span of time: seconds from one on, else milliseconds."""
    if seconds >= 1:
        return f"{seconds:.3g} s"
    return f"{1000 * seconds:.3g} ms" if seconds >= 1e-3 else "< 1 ms"


def span(found: Interval) -> str:
    """The ends of an interval as text."""
    return "–" if math.isnan(found.share) else f"{100 * found.low:.1f} – {100 * found.high:.1f}"


def interval_plot(found: Interval, words: str) -> Markup:
    """A dot at the share and a line from the interval's one end to the other, between 0 and 1."""
    if math.isnan(found.share):
        return _plot(words, [])
    line = {"x1": _at(found.low), "x2": _at(found.high), "y1": HIGH / 2, "y2": HIGH / 2, "class": "range"}
    dot = {"cx": _at(found.share), "cy": HIGH / 2, "r": 4.5, "class": "dot"}
    return _plot(words, [*_grid(), node("line", {**line}), node("circle", {**dot})])


def axis() -> Markup:
    """The scale above interval plots."""
    marks = [
        node("text", {"x": _at(mark / 100), "y": 12, "text-anchor": "middle", "class": "mark"}, str(mark))
        for mark in GRID[1:-1]
    ]
    ends = [
        node("text", {"x": "0", "y": 12, "class": "mark"}, "0"),
        node("text", {"x": "100%", "y": 12, "text-anchor": "end", "class": "mark"}, "100 %"),
    ]
    return node("svg", {"class": "plot axis", "height": 16, "aria-hidden": "true"}, ends, marks)


def share_plot(shares: Sequence[tuple[str, float]], colours: Sequence[int], words: str) -> Markup:
    """Parts of a whole next to each other; each names itself when it is pointed at."""
    parts, left = [], 0.0
    for (name, share), number in zip(shares, colours, strict=True):
        title = node("title", None, f"{name}: {percent(share)}")
        place = {"x": f"{100 * left:.2f}%", "width": f"{100 * share:.2f}%", "y": 2, "height": HIGH - 4}
        parts.append(node("rect", {**place, "class": colour(number)}, title))
        left += share
    return _plot(words, parts)


def length_plot(values: Sequence[float], longest: float, words: str) -> Markup:
    """Bars over each other, the shorter in front: the median before the 95th percentile."""
    bars = []
    for number, value in enumerate(sorted(values, reverse=True)):
        if not math.isnan(value) and longest > 0:
            width = f"{max(0.3, 100 * value / longest):.2f}%"
            bars.append(node("rect", {"x": 0, "y": 4, "height": HIGH - 8, "width": width, "class": f"bar{number}"}))
    return _plot(words, bars)


def colour(number: int) -> str:
    """The class of an option's colour."""
    return f"c{number % COLOURS}"


def _plot(words: str, parts: Sequence[Markup]) -> Markup:
    return node("svg", {"class": "plot", "height": HIGH, "role": "img", "aria-label": words}, parts)


def _grid() -> list[Markup]:
    return [
        node("line", {"x1": _at(mark / 100), "x2": _at(mark / 100), "y1": 0, "y2": HIGH, "class": "grid"})
        for mark in GRID
    ]


def _at(share: float) -> str:
    return f"{INSET + (100 - 2 * INSET) * share:.2f}%"

# SPDX-License-Identifier: Apache-2.0
"""The page itself, without anything of the mission: one HTML file, one script and one style.

Rule: the chart and its words are the review page's own; here stands only what a live page has beside them.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from visualize.page.html import bundle

__all__ = ("page", "script", "style")

ASSETS = Path(__file__).parent / "assets"
SHARED = (
    "dom.js", "text.js", "boxes.js", "tree.js", "graph.js", "order.js", "layout.js", "shapes.js", "chart.js",
    "gestures.js", "details.js",
)  # fmt: skip
OWN = ("line.js", "acts.js", "question.js", "panel.js", "live.js")


@cache
def page() -> bytes:
    """The HTML."""
    return (ASSETS / "live.html").read_bytes()


@cache
def script() -> bytes:
    """All scripts as one."""
    return bundle(SHARED, [(ASSETS / name).read_text(encoding="utf-8") for name in OWN]).encode()


@cache
def style() -> bytes:
    """The review page's style, and what is particular to this one."""
    from visualize.page.html import asset

    return (asset("page.css") + (ASSETS / "live.css").read_text(encoding="utf-8")).encode()

# SPDX-License-Identifier: Apache-2.0
"""One HTML file of data, scripts and styles.

Rule: the script that runs is the package's own, named by its hash in the page's policy; whatever is in the data is
read as JSON, and could not run even if it broke out.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable
from functools import cache
from html import escape
from pathlib import Path

from visualize.page.as_json import Json
from visualize.style import clean

__all__ = ("CHART_SCRIPTS", "SCRIPTS", "assembled", "asset", "bundle", "document")

ASSETS = Path(__file__).parent / "assets"
CHART_SCRIPTS = (
    "dom.js", "text.js", "detail.js", "boxes.js", "tree.js", "graph.js", "order.js", "layout.js", "shapes.js", "pen.js",
    "chart.js", "gestures.js",
)  # fmt: skip
"""What draws a chart, in the order in which they need each other."""
SCRIPTS = (
    *CHART_SCRIPTS,
    "replay.js",
    "plan.js",
    "details.js",
    "lenses.js",
    "player.js",
    "path.js",
    "coverage.js",
    "summary.js",
    "changes.js",
    "legend.js",
    "page.js",
)
"""The scripts of the review page, in this order."""
PLACE = re.compile(r"\{\{(policy|title|style|script|data|body)\}\}")
ESCAPED = str.maketrans({"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"})
"""What could end a script element, begin a comment in it, or a line of JavaScript."""


def document(data: Json, *, title: str) -> bytes:
    """The page.

    Args:
        data: What it shows.
        title: The title of the window.
    """
    return assembled(asset("page.html"), data, title=title, style=asset("page.css"), script=_script())


def assembled(template: str, data: Json, *, title: str, style: str, script: str, body: str = "") -> bytes:
    """A page of a template of the package's own, whose places `{{policy}}` and the like are filled.

    Args:
        template: The page's frame.
        data: What the script reads.
        title: The title of the window.
        style: The only style sheet.
        script: The only script.
        body: Markup that was made from escaped texts.
    """
    policy = (
        "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none'; "
        f"connect-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "require-trusted-types-for 'script'; trusted-types 'none'"
    )
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=True, allow_nan=False).translate(ESCAPED)
    parts = {
        "policy": escape(policy),
        "title": escape(clean(title)),
        "style": style,
        "script": script,
        "data": text,
        "body": body,
    }
    return PLACE.sub(lambda found: parts[found[1]], template).encode("utf-8", "replace")


@cache
def asset(name: str, folder: Path = ASSETS) -> str:
    """A file of a page's parts."""
    return (folder / name).read_text(encoding="utf-8")


def bundle(names: Iterable[str], more: Iterable[str] = ()) -> str:
    """Scripts as one, whose names stay its own: files of `assets`, and texts behind them."""
    return '(() => {\n"use strict";\n' + "\n".join([*map(asset, names), *more]) + "})();\n"


@cache
def _script() -> str:
    return bundle(SCRIPTS)


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()

# SPDX-License-Identifier: Apache-2.0
"""Markdown (CommonMark, with tables), made HTML by markdown-it-py.

Rule: it is read as the page that it makes, so what HTML in it hides, across paragraphs too, is no text.
"""

from __future__ import annotations

import re

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.readers.html import put_into
from rai_missions.embodiment.readers.plain import decoded

__all__ = ("read_markdown",)

DEEPEST = 40
"""Quotations, lists and their items inside each other; what lies deeper is passed over by markdown-it-py."""
FRONT_MATTER = re.compile(r"---[ \t]*\n.*?^(?:---|\.\.\.)[ \t]*(?:\n|\Z)", re.DOTALL | re.MULTILINE)
"""The block of settings that some programs keep at the top."""


def read_markdown(_name: str, data: bytes) -> TextDocument:
    """A Markdown file.

    Raises:
        ValueError: It is not UTF-8, too long, empty, nested too deep, or HTML in it never closes what hides the rest.
    """
    from markdown_it import MarkdownIt

    text = decoded(data).replace("\r\n", "\n")
    front = FRONT_MATTER.match(text)
    shown = text[front.end() :] if front else text
    reader = MarkdownIt("commonmark", {"maxNesting": DEEPEST}).enable("table")
    pieces, lines, line = list[str](), list[int](), 1
    ahead = text.count("\n") - shown.count("\n") + 1
    for token in reader.parse(shown):
        line = ahead + token.map[0] if token.map else line
        if token.type in ("blockquote_open", "list_item_open") and token.level + 1 >= DEEPEST:
            raise ValueError(f"is nested more than {DEEPEST} deep in line {line}; write it with fewer levels")
        pieces.append(reader.renderer.render([token], reader.options, {}).removesuffix("\n"))
        lines += range(line, line + pieces[-1].count("\n") + 1)
    outline = Outline()
    put_into(outline, "\n".join(pieces), lines)
    return outline.document()

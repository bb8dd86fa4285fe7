# SPDX-License-Identifier: Apache-2.0
"""Markdown (CommonMark, with tables), read by markdown-it-py.

Rule: what is HTML in it is read as HTML: a comment or a script in it is no text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.readers.html import text_of_html
from rai_missions.embodiment.readers.plain import decoded

if TYPE_CHECKING:
    from markdown_it.token import Token

__all__ = ("read_markdown",)

DEEPEST = 40
"""Blocks inside each other; what lies deeper is one text."""


def read_markdown(_name: str, data: bytes) -> TextDocument:
    """A Markdown file.

    Raises:
        ValueError: It is not UTF-8, too long, empty, or HTML in it never closes what hides the rest.
    """
    from markdown_it import MarkdownIt

    outline = Outline()
    text = decoded(data)
    shown = _without_front_matter(text)
    ahead = text.count("\n") - shown.count("\n")
    tokens = MarkdownIt("commonmark", {"maxNesting": DEEPEST}).enable("table").parse(shown)
    cells = list[str]()
    for token, before in zip(tokens, [None, *tokens], strict=False):
        line = ahead + token.map[0] if token.map else ahead
        if token.type == "inline":
            words = _words(token.children or (), line)
            if before is not None and before.type == "heading_open":
                outline.heading(int(before.tag[1:]), words)
            elif before is not None and before.type in ("th_open", "td_open"):
                cells.append(words)
            else:
                outline.paragraph(words)
        elif token.type == "tr_close":
            outline.paragraph(" | ".join(cells))
            cells = []
        elif token.type in ("fence", "code_block"):
            outline.paragraph(token.content)
        elif token.type == "html_block":
            outline.paragraph(text_of_html(token.content, line=line))
    return outline.document()


def _words(tokens: Sequence[Token], line: int) -> str:
    """What a person reads of a line: the text of a link without its address, the description of a picture."""
    return text_of_html("".join(_pieces(tokens)), line=line) if _has_html(tokens) else "".join(_pieces(tokens))


def _has_html(tokens: Sequence[Token]) -> bool:
    return any(token.type == "html_inline" for token in tokens)


def _pieces(tokens: Sequence[Token]) -> Iterator[str]:
    escaped = _has_html(tokens)
    for token in tokens:
        if token.type in ("softbreak", "hardbreak"):
            yield " "
        elif token.type == "html_inline" or not escaped:
            yield token.content
        else:
            yield token.content.replace("&", "&amp;").replace("<", "&lt;")


def _without_front_matter(text: str) -> str:
    """Without the block of settings that some programs keep at the top."""
    if text.startswith("---\n") and (end := text.find("\n---\n", 3)) > 0:
        return text[end + 5 :]
    return text

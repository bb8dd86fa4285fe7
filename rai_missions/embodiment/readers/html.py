# SPDX-License-Identifier: Apache-2.0
"""HTML pages: headings, paragraphs, lists and tables, as a browser shows them.

Rule: scripts, styles, comments and what a page hides are no text, and no address in it is opened.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.readers.plain import decoded

__all__ = ("read_html", "text_of_html")

UNSEEN = frozenset({"script", "style", "template", "noscript", "iframe", "object", "svg", "math", "head", "select"})
VOID = frozenset(
    {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
)  # fmt: skip
INLINE = frozenset(
    {
        "a", "abbr", "b", "bdi", "bdo", "cite", "code", "data", "del", "dfn", "em", "font", "i", "img", "ins", "kbd",
        "label", "mark", "q", "s", "samp", "small", "span", "strong", "sub", "sup", "td", "th", "time", "tt", "u",
        "var", "wbr",
    }
)  # fmt: skip
CELLS, BETWEEN_CELLS = ("td", "th"), " | "
ENDS_ITSELF = frozenset({"dd", "dt", "li", "option", "p", "td", "th", "tr"})
"""Elements that the next one of their kind ends."""
HEADING = re.compile(r"h([1-6])")
HIDING = re.compile(
    r"display\s*:\s*none|visibility\s*:\s*hidden|font-size\s*:\s*0(?![.\d])|opacity\s*:\s*0(?![.\d])", re.IGNORECASE
)
DEEPEST = 500
"""Elements inside each other."""


class _Page(HTMLParser):
    """Receives the tags of a page."""

    def __init__(self, outline: Outline) -> None:
        super().__init__(convert_charrefs=True)
        self.outline, self.title = outline, ""
        self._text: list[str] = []
        self._open: list[tuple[str, bool]] = []
        """The elements that are open, and whether each, or one around it, is hidden."""

    @property
    def _is_unseen(self) -> bool:
        return bool(self._open) and self._open[-1][1]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in INLINE:
            self._end_block("")
        if tag in VOID:
            if tag == "img" and not self._is_unseen:
                self._text.append(f" {dict(attrs).get('alt') or ''} ")
            return
        if tag in ENDS_ITSELF and self._open and self._open[-1][0] == tag:
            self.handle_endtag(tag)
        if len(self._open) >= DEEPEST:
            raise ValueError(f"is nested more than {DEEPEST} deep")
        self._open.append((tag, tag in UNSEEN or self._is_unseen or any(_hides(*each) for each in attrs)))

    def handle_endtag(self, tag: str) -> None:
        if tag in CELLS:
            self._text.append(BETWEEN_CELLS)
        elif tag not in INLINE:
            self._end_block(tag)
        places = [place for place, (name, _) in enumerate(self._open) if name == tag]
        if places:
            del self._open[places[-1] :]

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1][0] == "title" and len(self.title) < DEEPEST:
            self.title += data
        elif not self._is_unseen:
            self._text.append(data)

    def close(self) -> None:
        super().close()
        self._open.clear()
        self._end_block("")

    def _end_block(self, ending: str) -> None:
        """A block ends: its text is a heading or a paragraph; the cells of a table's line are one paragraph."""
        if ending != "tr" and any(tag == "tr" for tag, _ in self._open):
            self._text.append(" ")
            return
        text, self._text = "".join(self._text).strip().removesuffix(BETWEEN_CELLS.strip()), []
        if found := HEADING.fullmatch(ending):
            self.outline.heading(int(found[1]), text)
        else:
            self.outline.paragraph(text)


def _hides(name: str, value: str | None) -> bool:
    """Whether an attribute keeps its element from being seen."""
    return (
        name == "hidden" or (name == "aria-hidden" and value == "true")
        or (name == "style" and HIDING.search(value or "") is not None)
    )  # fmt: skip


def read_html(_name: str, data: bytes) -> TextDocument:
    """An HTML page.

    Raises:
        ValueError: It is not UTF-8, too long, nested too deep, or shows no text.
    """
    page = _Page(Outline())
    page.feed(decoded(data))
    page.close()
    page.outline.title = " ".join(page.title.split())
    return page.outline.document()


def text_of_html(text: str) -> str:
    """What a person sees of a piece of HTML."""
    outline = Outline()
    page = _Page(outline)
    page.feed(text)
    page.close()
    try:
        return " ".join(section.text for section in outline.document().sections)
    except ValueError:
        return ""

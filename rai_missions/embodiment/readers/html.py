# SPDX-License-Identifier: Apache-2.0
"""HTML pages: headings, paragraphs, lists and tables, as a browser shows them.

Rule: scripts, styles, comments and what a page hides are no text, and no address in it is opened. What would hide the
rest of the page since it is never closed, a comment for instance, is refused with its line.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from html.parser import HTMLParser

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.readers.plain import decoded

__all__ = ("put_into", "read_html")

UNSEEN = frozenset(
    {
        "audio", "canvas", "datalist", "head", "iframe", "math", "noembed", "noframes", "noscript", "object", "rp",
        "script", "select", "style", "svg", "template", "video",
    }
)  # fmt: skip
"""Elements that are not rendered (HTML, section 15.3.1), or whose content is for programs that lack them."""
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
BLOCKS = frozenset(
    {
        "address", "article", "aside", "blockquote", "details", "div", "dl", "fieldset", "figure", "footer", "form",
        "h1", "h2", "h3", "h4", "h5", "h6", "header", "main", "nav", "ol", "p", "pre", "section", "table", "ul",
    }
)  # fmt: skip
ENDED = {
    **dict.fromkeys(BLOCKS, ("p",)),
    **dict.fromkeys(("td", "th"), ("td", "th")),
    **dict.fromkeys(("dd", "dt"), ("dd", "dt")),
    "li": ("li",),
    "option": ("option",),
    "tr": ("tr",),
}
"""Element → those whose end tag may be left out ahead of it (HTML, section 13.1.2.4)."""
AROUND = {
    "p": frozenset({"button", "caption", "object", "table", "td", "template", "th"}),
    "option": frozenset({"select"}),
    "li": frozenset({"ol", "ul"}),
    **dict.fromkeys(("dd", "dt"), frozenset({"dl"})),
    **dict.fromkeys(("td", "th", "tr"), frozenset({"table"})),
}
"""Element that is ended so → those around it beyond which none is."""
OPTIONAL = AROUND.keys() | {"body", "colgroup", "head", "html", "tbody", "tfoot", "thead"}
"""Elements whose end tag may be left out."""
RAW = frozenset({"script", "style", "textarea", "title"})
"""Elements that only their own end tag ends."""
OF_HEAD = frozenset({"base", "link", "meta", "noscript", "script", "style", "template", "title"})
"""What a head may hold; any other element ends it."""
UNFINISHED = re.compile(r"<[!?/a-zA-Z][^\s<>]{0,20}")
HEADING = re.compile(r"h([1-6])")
ZERO = r"(?:0+(?:\.0*)?|\.0+)(?![.\d])"
HIDING = re.compile(
    rf"display\s*:\s*none|visibility\s*:\s*(?:hidden|collapse)|(?:font-size|opacity)\s*:\s*{ZERO}"
    r"|(?<![\w-])color\s*:\s*transparent",
    re.IGNORECASE,
)
CSS_COMMENT, CSS_ESCAPE = re.compile(r"/\*.*?\*/", re.DOTALL), re.compile(r"\\([0-9a-fA-F]{1,6})\s?")
DEEPEST = 500
"""Elements inside each other."""
NO_CHARACTER = re.compile(r"&#[0-9]{1000,};?")
"""Numbers of characters that are too long to be read as a number."""


class _Page(HTMLParser):
    """Receives the tags of a page.

    Args:
        outline: What it is put into.
        lines: The line of the document that each of its own comes from; the same one where it is empty.
    """

    def __init__(self, outline: Outline, lines: Sequence[int] = ()) -> None:
        super().__init__(convert_charrefs=True)
        self._lines = lines
        self._outline, self.title = outline, ""
        self._text: list[str] = []
        self._open: list[tuple[str, bool, int]] = []
        """The elements that are open, whether each, or one around it, is hidden, and its line."""

    @property
    def _is_unseen(self) -> bool:
        return bool(self._open) and self._open[-1][1]

    @property
    def _line(self) -> int:
        line = self.getpos()[0]
        return self._lines[line - 1] if self._lines else line

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in INLINE:
            self._end_block("")
        self._end_before(tag)
        if tag not in OF_HEAD and self._open and self._open[-1][0] == "head":
            self._open.pop()
        given = dict(reversed(attrs))  # the first of two counts
        is_hidden = self._is_unseen or _is_hidden(tag, given)
        if tag in VOID:
            if tag == "img" and not is_hidden:
                self._text.append(f" {given.get('alt') or ''} ")
            return
        if len(self._open) >= DEEPEST:
            raise ValueError(f"is nested more than {DEEPEST} deep")
        self._open.append((tag, is_hidden, self._line))

    def _end_before(self, tag: str) -> None:
        """The next element ends the one whose end tag was left out."""
        ended = ENDED.get(tag, ())
        for name, *_ in reversed(self._open):
            if name in ended:
                self.handle_endtag(name)
                return
            if ended and name in AROUND[ended[0]]:
                return

    def handle_endtag(self, tag: str) -> None:
        if tag in CELLS:
            self._text.append(BETWEEN_CELLS)
        elif tag not in INLINE:
            self._end_block(tag)
        if place := next((at for at in range(len(self._open), 0, -1) if self._open[at - 1][0] == tag), 0):
            del self._open[place - 1 :]

    def handle_data(self, data: str) -> None:
        if [tag for tag, *_ in self._open if tag not in ("html", "head")] == ["title"] and len(self.title) < DEEPEST:
            self.title += data
        elif not self._is_unseen:
            self._text.append(data)

    def feed(self, data: str) -> None:
        super().feed(NO_CHARACTER.sub("\N{REPLACEMENT CHARACTER}", data))

    def close(self) -> None:
        for tag, is_hidden, line in self._open:
            if tag in RAW or (is_hidden and tag not in OPTIONAL):
                raise _never_closed(f"<{tag}>", line)
        if begun := UNFINISHED.match(self.rawdata):
            raise _never_closed(begun.group(), self._line)
        super().close()
        self._open.clear()
        self._end_block("")

    def _end_block(self, ending: str) -> None:
        """A block ends: its text is a heading or a paragraph; the cells of a table's line are one paragraph."""
        if ending != "tr" and any(tag == "tr" for tag, *_ in self._open):
            self._text.append(" ")
            return
        text, self._text = "".join(self._text).strip().removesuffix(BETWEEN_CELLS.strip()), []
        if found := HEADING.fullmatch(ending):
            self._outline.heading(int(found[1]), text)
        else:
            self._outline.paragraph(text)


def _never_closed(begun: str, line: int) -> ValueError:
    return ValueError(
        f"never closes the {begun} of line {line}, which hides what follows; close it, or write &lt; for <"
    )


def _is_hidden(tag: str, given: Mapping[str, str | None]) -> bool:
    """Whether an element with these attributes is not seen."""
    return (
        tag in UNSEEN
        or (tag == "dialog" and "open" not in given)
        or not given.keys().isdisjoint(("hidden", "popover"))
        or given.get("aria-hidden") == "true"
        or HIDING.search(_plain_css(given.get("style") or "")) is not None
    )


def _plain_css(style: str) -> str:
    """A style without comments and escapes."""
    return CSS_ESCAPE.sub(lambda found: chr(min(int(found[1], 16), sys.maxunicode)), CSS_COMMENT.sub("", style))


def read_html(_name: str, data: bytes) -> TextDocument:
    """An HTML page.

    Raises:
        ValueError: It is not UTF-8, too long, nested too deep, shows no text, or never closes what hides the rest.
    """
    outline = Outline()
    outline.title = " ".join(put_into(outline, decoded(data)).split())
    return outline.document()


def put_into(outline: Outline, page: str, lines: Sequence[int] = ()) -> str:
    """Put what a person sees of a page into an outline.

    Args:
        outline: What it is put into.
        page: The page, as HTML.
        lines: The line of the document that each line of the page comes from; the same one where it is empty.

    Returns:
        Its title.

    Raises:
        ValueError: It is nested too deep, or never closes what hides the rest.
    """
    read = _Page(outline, lines)
    read.feed(page)
    read.close()
    return read.title

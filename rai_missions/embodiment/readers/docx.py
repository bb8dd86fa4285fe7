# SPDX-License-Identifier: Apache-2.0
"""Word documents (ECMA-376, WordprocessingML): the text of the body under its headings.

Rule: two parts of the archive are unpacked, each up to a bound, whatever sizes the archive claims. Of what a document
holds twice one is read: the first of alternatives, the text where it was moved to, the format that it has now.
"""

from __future__ import annotations

import io
import re
import zipfile
import zlib
from collections.abc import Mapping

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.xml_events import read_xml

__all__ = ("read_docx",)

BODY, STYLES = "word/document.xml", "word/styles.xml"
LARGEST_PART = 40_000_000
"""Bytes of one part, unpacked."""
MOST_PARTS = 5_000
DEEPEST = 200
OUTLINE_LEVEL, HEADING_LEVEL = re.compile(r"[0-9]"), re.compile(r"[1-9]")
"""Level 9 of an outline is the text of the body."""
NAMESPACES = (
    "http://schemas.openxmlformats.org/wordprocessingml/2006/main", "http://purl.oclc.org/ooxml/wordprocessingml/main",
)  # fmt: skip
"""The namespaces of the transitional and of the strict form."""
ALTERNATIVES = "http://schemas.openxmlformats.org/markup-compatibility/2006"
"""Part 3 of ECMA-376: one of several contents for programs of different age."""
OFF = ("0", "false", "off")
SUPERSEDED = frozenset(
    {"del", "moveFrom", "pPrChange", "rPrChange", "sectPrChange", "tblPrChange", "tcPrChange", "trPrChange"}
)
"""Elements that hold what was there before a change."""
GONE = frozenset({"del", "hidden"})
"""What a line of a table has among its properties where it is not shown."""


class _Styles:
    """Finds which styles are headings, and which hide their text; a style has what the one it is based on has."""

    def __init__(self) -> None:
        self._levels: dict[str, int] = {}
        self._hiding: dict[str, bool] = {}
        self._bases: dict[str, str] = {}
        self._style = ""

    def level(self, style: str) -> int:
        """The level of a style's headings; 0 for a style of running text."""
        return next((self._levels[each] for each in self._line(style) if each in self._levels), 0)

    def hides(self, style: str) -> bool:
        """Whether text of a style is not shown."""
        return next((self._hiding[each] for each in self._line(style) if each in self._hiding), False)

    def _line(self, style: str) -> list[str]:
        """A style, the one that it is based on, and so on."""
        line = [style]
        while (base := self._bases.get(line[-1])) and base not in line:
            line.append(base)
        return line

    def begin(self, tag: str, attributes: Mapping[str, str], _line: int) -> None:
        name, value = _name(tag), _value(attributes, "val")
        if name == "style":
            self._style = _value(attributes, "styleId")
        elif name == "name" and (level := _heading_level(value)):
            self._levels.setdefault(self._style, level)
        elif name == "outlineLvl" and OUTLINE_LEVEL.fullmatch(value):
            self._levels.setdefault(self._style, (int(value) + 1) % 10)
        elif name == "vanish":
            self._hiding[self._style] = value not in OFF
        elif name == "basedOn":
            self._bases[self._style] = value

    def text(self, text: str) -> None:
        """Styles hold no text of a document."""

    def end(self, tag: str) -> None:
        """Nothing is kept until the end of an element."""


class _Body:
    """Receives the elements of the body; cells of one line of a table are one paragraph."""

    def __init__(self, outline: Outline, styles: _Styles) -> None:
        self._outline, self._styles = outline, styles
        self._pieces: list[str] = []
        self._level, self._rows = 0, 0
        self._is_text = self._is_hidden = self._hides = False
        self._around: list[tuple[list[str], int, int, bool]] = []
        """What was begun around each text box that is open."""
        self._path: list[str] = []
        """The names of the elements that are open."""
        self._left_out = 0
        """How deep the element lies that is not read."""
        self._chosen: list[int] = []
        """The depth of each element with alternatives that is open; negative once one of them was read."""

    def begin(self, tag: str, attributes: Mapping[str, str], _line: int) -> None:
        name = _name(tag)
        self._path.append(name)
        depth = len(self._path)
        if self._left_out:
            return
        is_box = name == "txbxContent"
        if self._path[-2:-1] == ["trPr"] and name in GONE and _value(attributes, "val") not in OFF:
            self._left_out, self._rows = depth - 2, self._rows - 1
        elif name in SUPERSEDED or self._is_other_alternative(tag) or (is_box and self._is_hidden):
            self._left_out = depth
        elif is_box:
            self._around.append((self._pieces, self._level, self._rows, self._hides))
            self._pieces, self._level, self._rows = [], 0, 0
        elif name == "p":
            self._level, self._hides = 0, False
        elif name == "pStyle":
            style = _value(attributes, "val")
            self._level, self._hides = self._styles.level(style), self._styles.hides(style)
        elif name == "tr":
            self._rows += 1
        elif name in ("r", "rStyle", "vanish"):
            self._is_hidden = self._is_run_hidden(name, _value(attributes, "val"))
        elif name == "t":
            self._is_text = True
        elif name in ("tab", "br", "cr"):
            self._pieces.append(" ")
        elif name == "noBreakHyphen" and not self._is_hidden:
            self._pieces.append("-")

    def _is_run_hidden(self, name: str, value: str) -> bool:
        """Whether a piece of text is hidden, after this element of it."""
        if name == "r":
            return self._hides
        if name == "rStyle":
            return self._is_hidden ^ self._styles.hides(value)  # where both styles hide it, it is shown: 17.7.3
        return value not in OFF

    def _is_other_alternative(self, tag: str) -> bool:
        """Whether it is one of several alternatives, and not the first."""
        if tag == f"{ALTERNATIVES} AlternateContent":
            self._chosen.append(len(self._path))
        if not self._chosen or len(self._path) != abs(self._chosen[-1]) + 1:
            return False
        is_other, self._chosen[-1] = self._chosen[-1] < 0, -abs(self._chosen[-1])
        return is_other

    def text(self, text: str) -> None:
        if self._is_text and not self._is_hidden and not self._left_out:
            self._pieces.append(text)

    def end(self, tag: str) -> None:
        depth = len(self._path)
        self._path.pop()
        if self._left_out:
            self._left_out = 0 if self._left_out == depth else self._left_out
            return
        if self._chosen and abs(self._chosen[-1]) == depth:
            self._chosen.pop()
        name = _name(tag)
        if name == "t":
            self._is_text = False
        elif name == "txbxContent":
            self._pieces, self._level, self._rows, self._hides = self._around.pop()
            self._is_hidden = False
        elif name == "tc":
            self._pieces.append(" | ")
        elif name == "tr":
            self._rows -= 1
            self._flush()
        elif name == "p" and self._rows:
            self._pieces.append(" ")
        elif name == "p":
            self._flush()

    def _flush(self) -> None:
        text, self._pieces = "".join(self._pieces).strip().removesuffix("|"), []
        if self._level and not self._rows:
            self._outline.heading(self._level, text)
        else:
            self._outline.paragraph(text)


def read_docx(_name: str, data: bytes) -> TextDocument:
    """A Word document.

    Raises:
        ValueError: It is no such archive, a part is too large or broken, or it holds no text.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if len(archive.infolist()) > MOST_PARTS:
                raise ValueError(f"is an archive of more than {MOST_PARTS} parts; save it again as .docx")
            body, styles = _part(archive, BODY), _part(archive, STYLES, needed=False)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, EOFError, OSError, RuntimeError) as error:
        raise ValueError(f"is no readable .docx ({error}); open it and save it again as .docx") from None
    found = _Styles()
    if styles:
        read_xml(styles, found, namespaces=True, deepest=DEEPEST)
    outline = Outline()
    read_xml(body, _Body(outline, found), namespaces=True, deepest=DEEPEST)
    return outline.document()


def _part(archive: zipfile.ZipFile, name: str, *, needed: bool = True) -> bytes:
    """A part of the archive, unpacked up to the bound."""
    if name not in archive.namelist():
        if needed:
            raise ValueError(f"has no {name}, so it is no .docx; open it and save it again as .docx")
        return b""
    with archive.open(name) as part:
        data = part.read(LARGEST_PART + 1)
    if len(data) > LARGEST_PART:
        raise ValueError(f"unpacks to more than {LARGEST_PART} bytes ({name}); split it")
    return data


def _name(tag: str) -> str:
    """The name of an element of WordprocessingML; empty for those of others."""
    namespace, _, name = tag.rpartition(" ")
    return name if namespace in NAMESPACES else ""


def _value(attributes: Mapping[str, str], name: str) -> str:
    return next((value for key, value in attributes.items() if key.rpartition(" ")[2] == name), "")


def _heading_level(style: str) -> int:
    """The level of a style by its built-in name, which every language of Word keeps: `heading 1`, `Title`."""
    word, _, number = style.lower().rpartition(" ")
    if word == "heading" and HEADING_LEVEL.fullmatch(number):
        return int(number)
    return 1 if style.lower() == "title" else 0

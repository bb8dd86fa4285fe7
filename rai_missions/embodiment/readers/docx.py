# SPDX-License-Identifier: Apache-2.0
"""Word documents (ECMA-376, WordprocessingML): the text of the body under its headings.

Rule: two parts of the archive are unpacked, each up to a bound, whatever sizes the archive claims.
"""

from __future__ import annotations

import io
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
NAMESPACES = (
    "http://schemas.openxmlformats.org/wordprocessingml/2006/main", "http://purl.oclc.org/ooxml/wordprocessingml/main",
)  # fmt: skip
"""Of the transitional and of the strict form."""


class _Styles:
    """Finds the level of each style that is a heading."""

    def __init__(self) -> None:
        self.levels: dict[str, int] = {}
        self._style = ""

    def begin(self, tag: str, attributes: Mapping[str, str], _line: int) -> None:
        name = _name(tag)
        if name == "style":
            self._style = _value(attributes, "styleId")
        elif name == "name" and (level := _heading_level(_value(attributes, "val"))):
            self.levels.setdefault(self._style, level)
        elif name == "outlineLvl" and (value := _value(attributes, "val")).isdecimal() and int(value) < 9:
            self.levels.setdefault(self._style, int(value) + 1)

    def text(self, text: str) -> None:
        """Styles hold no text of a document."""

    def end(self, tag: str) -> None:
        """Nothing is kept until the end of an element."""


class _Body:
    """Receives the elements of the body; cells of one line of a table are one paragraph."""

    def __init__(self, outline: Outline, levels: Mapping[str, int]) -> None:
        self._outline, self._levels = outline, levels
        self._pieces: list[str] = []
        self._level, self._rows = 0, 0
        self._is_text = self._is_hidden = False

    def begin(self, tag: str, attributes: Mapping[str, str], _line: int) -> None:
        name = _name(tag)
        if name == "p":
            self._level = 0
        elif name == "pStyle":
            self._level = self._levels.get(_value(attributes, "val"), 0)
        elif name == "tr":
            self._rows += 1
        elif name == "r":
            self._is_hidden = False
        elif name == "vanish":
            self._is_hidden = _value(attributes, "val") not in ("0", "false")
        elif name == "t":
            self._is_text = True
        elif name in ("tab", "br", "cr"):
            self._pieces.append(" ")

    def text(self, text: str) -> None:
        if self._is_text and not self._is_hidden:
            self._pieces.append(text)

    def end(self, tag: str) -> None:
        name = _name(tag)
        if name == "t":
            self._is_text = False
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
    read_xml(body, _Body(outline, found.levels), namespaces=True, deepest=DEEPEST)
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
    if word == "heading" and number.isdecimal():
        return min(int(number), 9)
    return 1 if style.lower() == "title" else 0

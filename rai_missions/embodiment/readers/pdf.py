# SPDX-License-Identifier: Apache-2.0
"""PDF files, read by pypdf: the text page by page, under the headings of the file's own outline.

Rule: nothing in it is executed and no file in it is unpacked; a page that is broken is reported with its number.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.errors import install_command, raised_text

if TYPE_CHECKING:
    from pypdf import PdfReader

__all__ = ("read_pdf",)

MOST_PAGES = 1_000
MOST_OUTLINE = 2_000
"""Entries of the outline that are looked at."""
DEEPEST_OUTLINE = 6


def read_pdf(_name: str, data: bytes) -> TextDocument:
    """A PDF file.

    Raises:
        ValueError: It is broken, encrypted, too long, or holds no text; or the package that reads it is missing.
    """
    if find_spec("pypdf") is None:
        raise ValueError(f"cannot be read without pypdf: {install_command('identity')}")
    from pypdf import PdfReader
    from pypdf.errors import PyPdfError

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)
    try:
        reader = PdfReader(io.BytesIO(data), strict=False)
        if reader.is_encrypted:
            raise ValueError("is encrypted; save a copy of it without a password")
        if (count := _page_count(reader)) > MOST_PAGES:
            raise ValueError(
                f"has {count} pages; at most {MOST_PAGES} are read: split it, or leave out what is not needed"
            )
        return _document(reader)
    except (PyPdfError, RecursionError, ArithmeticError, LookupError, TypeError, AttributeError, OSError) as error:
        raise ValueError(f"is a broken PDF ({raised_text(error)}); print it to a new PDF") from None


def _page_count(reader: PdfReader) -> int:
    """The pages that the file claims to have, or those that it has, whichever are more."""
    claimed: Any = reader.root_object["/Pages"].get_object().get("/Count", 0)
    return claimed if isinstance(claimed, int) and claimed > MOST_PAGES else len(reader.pages)


def _document(reader: PdfReader) -> TextDocument:
    outline, above = Outline(_title(reader)), _outline_by_page(reader)
    for number, page in enumerate(reader.pages, start=1):
        try:
            text = page.extract_text()
        except Exception as error:  # noqa: BLE001 - pypdf raises what the page's bytes make of its own code
            raise ValueError(f"has a broken page {number} ({type(error).__name__}); print it to a new PDF") from None
        for level, name in above.get(number - 1, ()):
            outline.heading(level, name)
        outline.heading(DEEPEST_OUTLINE, f"page {number}")
        for paragraph in _paragraphs(text):
            outline.paragraph(paragraph)
    return outline.document()


def _title(reader: PdfReader) -> str:
    title = reader.metadata.title if reader.metadata is not None else None
    return title or ""


def _outline_by_page(reader: PdfReader) -> Mapping[int, list[tuple[int, str]]]:
    """Page, from 0, → the headings that begin on it; none where the outline is broken: the text counts."""
    found: dict[int, list[tuple[int, str]]] = {}
    try:
        for level, entry in _flat(reader.outline):
            page = reader.get_destination_page_number(entry)
            found.setdefault(-1 if page is None else page, []).append((level, str(entry.title)))
    except Exception:  # noqa: BLE001 - an ornament of the file, in whatever way it is broken
        return {}
    return found


def _flat(outline: Any) -> Iterator[tuple[int, Any]]:
    left, stack = MOST_OUTLINE, [(1, each) for each in reversed(list(outline))]
    while stack and left:
        left -= 1
        level, entry = stack.pop()
        if not isinstance(entry, list):
            yield level, entry
        elif level < DEEPEST_OUTLINE - 1:
            stack += [(level + 1, each) for each in reversed(entry)]


def _paragraphs(text: str) -> Iterator[str]:
    """Lines put together again: a paragraph ends with an empty line, a word that was divided is made whole."""
    lines = list[str]()
    for line in (*text.splitlines(), ""):
        shown = line.strip()
        if not shown:
            yield " ".join(lines)
            lines = []
        elif lines and lines[-1].endswith("-") and shown[0].islower() and lines[-1][-2:-1].isalpha():
            lines[-1] = lines[-1][:-1] + shown
        else:
            lines.append(shown)

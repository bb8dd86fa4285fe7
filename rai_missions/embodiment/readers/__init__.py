# SPDX-License-Identifier: Apache-2.0
"""Documents in the formats that people write them in, each read by a module of its own.

Imports the modules of the root only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import PurePosixPath
from typing import NamedTuple

from rai_missions.embodiment.body_text import read_urdf_text
from rai_missions.embodiment.document import TextDocument
from rai_missions.embodiment.readers.docx import read_docx
from rai_missions.embodiment.readers.html import read_html
from rai_missions.embodiment.readers.markdown import read_markdown
from rai_missions.embodiment.readers.pdf import read_pdf
from rai_missions.embodiment.readers.plain import read_plain

__all__ = ("FORMATS", "DocumentFormat", "read_document")


class DocumentFormat(NamedTuple):
    """How files of one ending are read, and how large they may be."""

    read: Callable[[str, bytes], TextDocument]
    """Takes a file's name and bytes; raises `ValueError` with what is wrong and what would be right."""
    largest: int
    """Bytes of the largest file that is read."""
    is_text: bool = False
    """Whether its bytes are text, with marks in it that a reader leaves out."""
    is_linear: bool = False
    """Whether reading takes time and memory in proportion to the file, so that it needs no process of its own."""


FORMATS: Mapping[str, DocumentFormat] = {
    ".docx": DocumentFormat(read_docx, 30_000_000),
    ".htm": DocumentFormat(read_html, 3_000_000, is_text=True),
    ".html": DocumentFormat(read_html, 3_000_000, is_text=True),
    ".md": DocumentFormat(read_markdown, 1_000_000, is_text=True),
    ".pdf": DocumentFormat(read_pdf, 50_000_000),
    ".txt": DocumentFormat(read_plain, 2_000_000, is_text=True, is_linear=True),
    ".urdf": DocumentFormat(read_urdf_text, 5_000_000, is_text=True, is_linear=True),
}
"""Ending of a file's name → how it is read."""


def read_document(name: str, data: bytes) -> TextDocument:
    """A document, by the ending of its name.

    Raises:
        ValueError: What is wrong with it, and what would be right.
    """
    return FORMATS[PurePosixPath(name).suffix.lower()].read(name, data)

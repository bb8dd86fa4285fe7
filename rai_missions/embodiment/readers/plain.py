# SPDX-License-Identifier: Apache-2.0
"""Plain text: paragraphs between empty lines; a line that is underlined is a heading."""

from __future__ import annotations

import re

from rai_missions.embodiment.document import Outline, TextDocument

__all__ = ("decoded", "read_plain")

UNDERLINE = re.compile(r"(=|-|~)\1{2,}\s*")
LEVEL = {"=": 1, "-": 2, "~": 3}


def read_plain(_name: str, data: bytes) -> TextDocument:
    """A text file.

    Raises:
        ValueError: It is not UTF-8, too long, or empty.
    """
    outline, lines = Outline(), list[str]()
    for line in decoded(data).splitlines():
        if len(lines) == 1 and UNDERLINE.fullmatch(line):
            outline.heading(LEVEL[line[0]], lines.pop())
        elif line.strip():
            lines.append(line)
        else:
            outline.paragraph(" ".join(lines))
            lines = []
    outline.paragraph(" ".join(lines))
    return outline.document()


def decoded(data: bytes) -> str:
    """The text of a file, with or without a byte order mark.

    Raises:
        ValueError: It is not UTF-8.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not UTF-8 at byte {error.start}; save it as UTF-8") from None

# SPDX-License-Identifier: Apache-2.0
"""Files of a language: which there are, what one holds, the texts in it, and the word forms that all its readers share.

Rule: no sentence of any language is written in code; a language is a file in each folder of languages.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from rai_missions.errors import UsageError, suggestion

__all__ = ("LanguageTexts", "language_codes", "language_file", "spoken", "word_forms")

WORD_FORMS = Path(__file__).parent / "languages"
TWO_SIGNS = re.compile(r"(?<!\.)([.?!])\.(?!\.)")
"""The end of a value that is a sentence, and that of its template; three points are neither."""


class LanguageTexts:
    """The texts of one language.

    Args:
        data: The file's content, and the language's word forms.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data = data
        self.code: str = data["language"]

    def text(self, name: str, /, *values: object, **named: object) -> str:
        """A template, filled in; values are not read as templates, and one that is a sentence ends with its sign."""
        template: str = self.data["texts"][name]
        return TWO_SIGNS.sub(r"\1", template.format(*values, **named))

    def listed(self, items: Sequence[str], joint: str = "and") -> str:
        """`a, b and c`."""
        if len(items) < 2:
            return "".join(items)
        return f"{', '.join(items[:-1])} {self.text(joint)} {items[-1]}"


def spoken(name: str) -> str:
    """A name as it is spoken: `drive_over` is `drive over`, `red_cube_2` is `red cube 2`."""
    return name.replace("/", " ").replace("_", " ")


def language_codes(folder: Path) -> tuple[str, ...]:
    """The languages that there are, by their codes."""
    return tuple(sorted(path.stem for path in folder.glob("*.json")))


def language_file(folder: Path, code: str, what: str = "language") -> dict[str, Any]:
    """What a language's file holds.

    Args:
        folder: The folder of the files.
        code: Such as `en`.
        what: What the file holds, for the error: `words of the language`.

    Raises:
        UsageError: There is no file for it.
    """
    known = language_codes(folder)
    if code not in known:
        raise UsageError(f"no {what} '{code}'{suggestion(code, known)}")
    held: dict[str, Any] = json.loads((folder / f"{code}.json").read_text(encoding="utf-8"))
    return held


@cache
def word_forms(code: str) -> Mapping[str, Any]:
    """The word forms of a language: `contractions`, and what `numbers` reads.

    Raises:
        UsageError: There is no file for it.
    """
    return MappingProxyType(language_file(WORD_FORMS, code, "word forms of the language"))

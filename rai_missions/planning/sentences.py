# SPDX-License-Identifier: Apache-2.0
"""Why a goal is refused, in a sentence of the language in which it was asked for.

Rule: no sentence is in code; a language is a file in `languages/`, with the same names as `en.json`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

__all__ = ("ENGLISH", "refusal_sentence", "refusal_templates")

FOLDER = Path(__file__).parent / "languages"
ENGLISH = "en"


@cache
def refusal_templates(language: str) -> Mapping[str, str]:
    """Name → sentence with places for names and numbers; those of English where the language has no file."""
    path = FOLDER / f"{language}.json"
    known = path if path in FOLDER.iterdir() else FOLDER / f"{ENGLISH}.json"
    return MappingProxyType(json.loads(known.read_text(encoding="utf-8"))["refusals"])


def refusal_sentence(name: str, values: tuple[object, ...] = (), *, language: str = ENGLISH) -> str:
    """A sentence, filled in.

    Args:
        name: Of the sentence.
        values: For its places, in their order.
        language: Its code.
    """
    return refusal_templates(language)[name].format(*values)

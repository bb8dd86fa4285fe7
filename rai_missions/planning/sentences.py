# SPDX-License-Identifier: Apache-2.0
"""Why a goal is refused, in a sentence of the language in which it was asked for.

Rule: no sentence is in code; a language is a file in `languages/`, with the same names as `en.json`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from rai_missions.planning.text.language_file import language_codes, language_file

__all__ = ("ENGLISH", "refusal_sentence", "refusal_templates")

FOLDER = Path(__file__).parent / "languages"
ENGLISH = "en"


@cache
def refusal_templates(language: str) -> Mapping[str, str]:
    """Name → sentence with places for names and numbers; those of English where the language has no file."""
    code = language if language in language_codes(FOLDER) else ENGLISH
    return MappingProxyType(language_file(FOLDER, code)["refusals"])


def refusal_sentence(name: str, values: tuple[object, ...] = (), *, language: str = ENGLISH) -> str:
    """A sentence, filled in.

    Args:
        name: The name of the sentence.
        values: For its places, in their order.
        language: Its code.
    """
    return refusal_templates(language)[name].format(*values)

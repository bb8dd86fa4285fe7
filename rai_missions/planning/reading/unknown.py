# SPDX-License-Identifier: Apache-2.0
"""What is asked about an unknown word: which thing it names, where one may be named, else what it means."""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.symbols import Symbol
from rai_missions.planning.scene import Scene
from rai_missions.planning.text.language_file import spoken

__all__ = ("unknown_text",)

BEFORE = ("put", "grasp", "swap", "stack", "relation", "the")
"""Kinds of symbols after which a thing is named."""
AFTER = ("", ",", ".", "and", "with", "relation", "each_other", "stays")
"""Kinds of symbols that come after a thing."""


def unknown_text(found: Sequence[Symbol], at: int, scene: Scene, words: Vocabulary) -> str:
    """The question about the unknown word at a place of a request: `put Bob on the tray` asks which thing Bob is."""
    before, after = found[at - 1].kind if at else "", found[at + 1].kind if at + 1 < len(found) else ""
    seen = words.listed([f"'{spoken(each.name)}'" for each in scene.things])
    if seen and before in BEFORE and after in AFTER and found[at].text.isalpha():
        return words.text("which_thing", found[at].text, seen)
    return words.text("unknown_word", found[at].text)

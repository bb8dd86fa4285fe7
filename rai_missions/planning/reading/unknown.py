# SPDX-License-Identifier: Apache-2.0
"""What is asked about an unknown word: which thing it names, where one may be named, else what it means."""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.phrases import Unread
from rai_missions.planning.reading.symbols import Symbol, kind_at
from rai_missions.planning.scene import Scene
from rai_missions.planning.text.language_file import spoken

__all__ = ("unknown_word",)

BEFORE = ("put", "grasp", "swap", "stack", "relation", "the")
"""Kinds of symbols after which a thing is named."""
AFTER = ("", ",", ".", "and", "with", "relation", "each_other", "stays")
"""Kinds of symbols that come after a thing."""


def unknown_word(found: Sequence[Symbol], at: int, scene: Scene, words: Vocabulary) -> Unread:
    """The question about the unknown word at a place of a request: `put Bob on the tray` asks which thing Bob is."""
    before, after = kind_at(found, at - 1), kind_at(found, at + 1)
    seen = words.listed([f"'{spoken(each.name)}'" for each in scene.things])
    if seen and before in BEFORE and after in AFTER and found[at].text.isalpha():
        return words.unread("which_thing", found[at].text, seen, reason="unknown_word")
    return words.unread("unknown_word", found[at].text)

# SPDX-License-Identifier: Apache-2.0
"""Misspelled words: the one known word that a word is meant as."""

from __future__ import annotations

from collections.abc import Collection

from rai_missions.planning.text.normalise import is_near, is_slip

__all__ = ("NEAREST", "nearest")

NEAREST = 5
"""Letters of the shortest word in which any letter may be wrong."""


def nearest(word: str, known: Collection[str]) -> str:
    """The one known word that it is but for a letter; a short one only by letters exchanged or written twice.

    A short word that begins with another letter, or lacks one, may be another word: `rote` is no `orte`.
    """
    if word in known:
        return word
    if len(word) < NEAREST:
        near = [each for each in known if each[0] == word[0] and len(each) <= len(word) and is_slip(word, each)]
    else:
        sizes = range(max(NEAREST - 1, len(word) - 1), len(word) + 2)
        near = [each for each in known if len(each) in sizes and is_near(word, each)]
        near = [each for each in near if each[0] == word[0]] or near
    return near[0] if len(near) == 1 else word

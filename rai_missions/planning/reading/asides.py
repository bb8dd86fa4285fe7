# SPDX-License-Identifier: Apache-2.0
"""Words that no list has and that ask for nothing: who is addressed, and what a thing is like.

Rule: an aside is ahead of the wishes, and names no thing and no place; what a thing is like chooses none of several.
"""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.planning.reading.lexicon import Vocabulary, lexicon, lexicons
from rai_missions.planning.reading.symbols import Symbol, past

__all__ = ("without_asides",)

MOST_WORDS = 3
"""Words of an aside."""
SIGNS = (",", ".", ":")
VERBS = frozenset({"put", "stack", "sort", "group", "apart", "swap", "grasp", "fill", "empty", "unstack"})
"""Kinds of symbols that begin a wish after a comma; a noun there may continue a list."""


def without_asides(found: Sequence[Symbol], words: Vocabulary) -> list[Symbol]:
    """The symbols without an aside ahead of the wishes, and with epithets: `Gertrude, put the bruised apple …`."""
    end = past(found, 0, ("unknown",))
    if 0 < end <= MOST_WORDS and end + 1 < len(found) and all(_is_plain(each, words) for each in found[:end]):
        sign, after = found[end].kind, found[end + 1].kind
        is_sentence = sign in (".", ":") and after not in ("relation", "unknown") and _is_whole(found[end + 1 :])
        if is_sentence or (sign == "," and after in VERBS):
            found = found[end + 1 :]
    return [
        symbol._replace(kind="epithet") if _is_epithet(found, at) and _is_plain(symbol, words) else symbol
        for at, symbol in enumerate(found)
    ]


def _is_plain(symbol: Symbol, words: Vocabulary) -> bool:
    """Whether no language knows a word, and it does not report how something is to be done: `backwards`."""
    is_how = symbol.text.endswith(tuple(words.data["adverb_endings"]))
    return symbol.text.isalpha() and not is_how and not any(lexicon(code).knows(symbol.text) for code in lexicons())


def _is_whole(found: Sequence[Symbol]) -> bool:
    """Whether what follows has a verb or a relation of its own: `plate: apple, carrot` has none."""
    sentence = found[: past(found, 0, {each.kind for each in found} - {"."})]
    return any(each.kind in VERBS | {"relation", "each_other"} for each in sentence)


def _is_epithet(found: Sequence[Symbol], at: int) -> bool:
    """Whether an unknown word is between an article and a noun or its colour."""
    if found[at].kind != "unknown" or not at or (found[at - 1].kind != "the" and found[at - 1].value != "one"):
        return False
    after = [each.kind for each in found[at + 1 : at + 3]]
    return after[:1] == ["noun"] or after == ["colour", "noun"]

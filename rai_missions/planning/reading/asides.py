# SPDX-License-Identifier: Apache-2.0
"""Words that ask for nothing: who is addressed, what a thing is like, and what a wish is about.

Rule: an aside is ahead of the wishes, and names no thing and no place; what a thing is like chooses none of several.
"""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.planning.reading.lexicon import Vocabulary, lexicon, lexicons
from rai_missions.planning.reading.symbols import SUBJECTS, Symbol, past, up_to

__all__ = ("without_asides",)

MOST_WORDS = 3
"""Words of an aside."""
SIGNS = (",", ".", ":")
TOPIC = ("the", "a", "all", "number", "colour", "noun")
"""Kinds of symbols of which what a remark is about consists."""
WISHING = (
    "put",
    "grasp",
    "stack",
    "swap",
    "group",
    "apart",
    "sort",
    "fill",
    "empty",
    "keep",
    "stays",
    "holds",
    "asked",
    "toss",
    "forbidden",
)
"""Kinds of symbols that ask for something."""
VERBS = frozenset({"put", "stack", "sort", "group", "apart", "swap", "grasp", "fill", "empty", "unstack"})
"""Kinds of symbols that begin a wish after a comma; a noun there may continue a list."""


def without_asides(found: Sequence[Symbol], words: Vocabulary) -> list[Symbol]:
    """The symbols without an aside ahead of the wishes, and with epithets: `Gertrude, put the bruised apple …`."""
    found = _with_topic(found, words)
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


def _with_topic(found: Sequence[Symbol], words: Vocabulary) -> Sequence[Symbol]:
    """What a remark ahead of a wish is about in place of the wish's pronoun: `the tomato is soft, bin it`."""
    end = up_to(found, 0, SIGNS)
    before, wish = found[:end], found[end + 1 :]
    if len(before) > 1 and (before[-1].kind, before[-1].value) == ("level", "middle"):
        return _around([each for each in before[:-1] if each.kind != "put"], wish) or found
    # where the wish puts something is not what it is about: `into the bin with it`, `bin it`
    at = next((at for at, each in enumerate(wish) if each.kind in SUBJECTS and not each.is_container), len(wish))
    begun = up_to(before, 0, TOPIC)
    until = past(before, begun, (*TOPIC, "and"))
    ahead = begun - (0 < begun < end and before[begun - 1].kind == "pronoun")  # `that tomato`
    topic, others = before[begun:until], [*before[:ahead], *before[until:]]
    is_about = (
        before[until].kind in ("is", "owner", "unknown")
        if until < end
        else before[:1] != [] and before[0].text in words.data["people"]
    )
    is_wish = any(each.kind in WISHING or each.text in words.turning | words.cutting for each in others)
    is_remark = is_about and not is_wish and not any(each.kind in SUBJECTS for each in others)
    if not is_remark or at == len(wish) or wish[at].kind != "pronoun" or not _may_be(wish[at], topic, words):
        return found
    return [*wish[:at], *topic, *wish[at + 1 :]]


def _around(middle: Sequence[Symbol], wish: Sequence[Symbol]) -> list[Symbol]:
    """What is around a thing in the middle: `green in the middle, red on its left`; empty where it is not named so."""
    is_named = all(each.kind in TOPIC for each in middle) and any(each.kind in ("noun", "colour") for each in middle)
    of = [wish[at - 1].value in ("left_of", "right_of") and wish[at].kind == "pronoun" for at in range(len(wish))]
    if not is_named or not any(of):
        return []
    around = [[*middle] if is_it else [each] for each, is_it in zip(wish, of, strict=True)]
    return [symbol for part in around for symbol in part]


def _may_be(pronoun: Symbol, topic: Sequence[Symbol], words: Vocabulary) -> bool:
    """Whether a pronoun may be about so many things; German has one for both."""
    named = [each for each in topic if each.kind in ("noun", "colour")]
    nouns = [each.value.is_many for each in topic if each.kind == "noun"]
    is_many = any(each.kind == "and" for each in topic) or any(nouns) or None in nouns
    return bool(named) and (pronoun.text in words.data["one_or_many"] or is_many == (pronoun.value == "many"))


def _is_plain(symbol: Symbol, words: Vocabulary) -> bool:
    """Whether no language knows a word, and it does not report how something is to be done: `backwards`."""
    is_how = symbol.text.endswith(tuple(words.data["adverb_endings"]))
    return symbol.text.isalpha() and not is_how and not any(lexicon(code).knows(symbol.text) for code in lexicons())


def _is_whole(found: Sequence[Symbol]) -> bool:
    """Whether what follows has a verb or a relation of its own: `plate: apple, carrot` has none."""
    sentence = found[: up_to(found, 0, (".",))]
    return any(each.kind in VERBS | {"relation", "each_other"} for each in sentence)


def _is_epithet(found: Sequence[Symbol], at: int) -> bool:
    """Whether an unknown word is between an article and a noun or its colour."""
    if found[at].kind != "unknown" or not at or (found[at - 1].kind != "the" and found[at - 1].value != "one"):
        return False
    after = [each.kind for each in found[at + 1 : at + 3]]
    return after[:1] == ["noun"] or after == ["colour", "noun"]

# SPDX-License-Identifier: Apache-2.0
"""Each language's file has all that the grammar reads, and each phrase one sense."""

from __future__ import annotations

import string
from collections import Counter
from itertools import chain

import pytest

from rai_missions.errors import UsageError
from rai_missions.planning.reading.lexicon import lexicon, lexicons
from rai_missions.planning.text.normalise import each_way

ENGLISH = lexicon("en")


@pytest.mark.parametrize("code", lexicons())
def test_each_language_has_the_same_sections_and_sentences(code: str) -> None:
    data = lexicon(code).data
    assert set(data["types"]) == set(ENGLISH.data["types"])
    assert set(data["colours"]) <= set(ENGLISH.data["colours"])
    assert set(data["texts"]) == set(ENGLISH.data["texts"])
    for name, text in data["texts"].items():
        fields = {field for _, field, _, _ in string.Formatter().parse(text) if field is not None}
        assert fields == {
            field for _, field, _, _ in string.Formatter().parse(ENGLISH.data["texts"][name]) if field is not None
        }
    for kind, values in data["words"].items():
        assert set(values) - {"many"} <= set(ENGLISH.data["words"][kind]), kind


@pytest.mark.parametrize("code", lexicons())
def test_each_phrase_has_one_sense(code: str) -> None:
    data = lexicon(code).data
    tables = [*data["types"].values(), *data["groups"].values(), data["colours"], *data["words"].values()]
    lists = [phrases for table in tables for name, phrases in table.items() if name != "types"]
    counts = Counter(" ".join(words) for phrase in chain.from_iterable(lists) for words in each_way(phrase))
    assert [phrase for phrase, count in counts.items() if count > 1] == []


@pytest.mark.parametrize(
    ("word", "mended"),
    [("teh", "the"), ("gren", "green"), ("cueb", "cube"), ("swpa", "swap"), ("carot", "carrot"), ("reed", "red"),
     ("tablet", "tablet"), ("tube", "tube"), ("parrot", "parrot"), ("cup", "cup"), ("bed", "bed"), ("plase", "please")],
)  # fmt: skip
def test_a_slip_of_the_keyboard_is_mended_and_another_word_is_not(word: str, mended: str) -> None:
    assert ENGLISH.mended(word) == mended


def test_an_unknown_language_is_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match="no words of the language 'dee'; did you mean 'de'"):
        lexicon("dee")

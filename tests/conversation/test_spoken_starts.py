# SPDX-License-Identifier: Apache-2.0
"""What a start is called when it is read back: the profile's text, with each value as people speak it."""

from __future__ import annotations

import pytest

from rai_missions.conversation.answers.spoken_starts import SpokenStarts
from rai_missions.conversation.language.language import language
from rai_missions.conversation.view import KeyView


def called(text: str, code: str, name: str) -> str:
    starts = SpokenStarts({text: {}}, {}, language(code))
    return starts.words({name: 30}, {name: KeyView(name, "integer")})


@pytest.mark.parametrize("code", ["en", "de"])
def test_a_unit_that_the_text_writes_is_spoken_once(code: str) -> None:
    """Every word of a language for each of its units, behind a value of a key that ends with that unit."""
    words = language(code)
    for ending, unit in words.data["units"].items():
        name = f"amount_{ending}"
        assert called(f"take {{{name}}} there", code, name) == f"take 30 {unit} there"
        for word, factor in words.factors(unit).items():
            if factor == 1:
                assert called(f"take {{{name}}} {word}, there", code, name) == f"take 30 {word}, there"
                assert called(f"take {{{name}}} {word}", code, name) == f"take 30 {word}"


def test_a_word_that_only_begins_as_a_unit_does_is_another_word() -> None:
    assert called("take {height_m} more", "en", "height_m") == "take 30 m more"
    assert called("wait {wait_s} minutes", "en", "wait_s") == "wait 30 s minutes", "another unit hides none"

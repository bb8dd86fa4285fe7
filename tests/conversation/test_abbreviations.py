# SPDX-License-Identifier: Apache-2.0
"""The point of an abbreviation ends no sentence, but for a word to stop behind it."""

from __future__ import annotations

import pytest

from rai_missions.conversation import StatusView
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import STOP
from rai_missions.conversation.language.language import language, languages

TITLES = [(code, title) for code in languages() for title in language(code).data["titles"]]
NUMBERING = [(code, *each) for code in languages() for each in language(code).data["numbering"].items()]


@pytest.mark.parametrize(("code", "title"), TITLES)
def test_a_sentence_continues_behind_a_title(code: str, title: str) -> None:
    normaliser = language(code).normaliser
    text = f"Xylophone {title.title()}. Smith. Xylophone"
    assert [normaliser.words(each) for each in normaliser.parts(text)] == [["xylophone", title, "smith"], ["xylophone"]]


@pytest.mark.parametrize(("code", "title"), TITLES)
def test_a_word_to_stop_behind_a_title_stops(code: str, title: str) -> None:
    stop = language(code).data["stops"][0].title()
    assert Grammar(language(code), None, {}).senses(f"Xylophone {title.title()}. {stop}!", StatusView()) == (STOP,)


@pytest.mark.parametrize(("code", "written", "meant"), NUMBERING)
def test_a_number_behind_a_short_word_is_named_by_the_whole_one(code: str, written: str, meant: str) -> None:
    normaliser = language(code).normaliser
    assert normaliser.words(f"Xylophone {written.title()}. 3") == ["xylophone", meant, "3"]
    assert len(normaliser.parts(f"{written.title()}. Xylophone")) == 2


@pytest.mark.parametrize(
    ("text", "words"), [("valve V-3", "valve v 3"), ("-3", "-3"), ("3-5", "3 5"), ("to -3.5", "to -3.5")]
)
def test_a_sign_ahead_of_a_number_is_its_own_where_no_letter_and_no_number_is_ahead(text: str, words: str) -> None:
    assert language("en").normaliser.words(text) == words.split()

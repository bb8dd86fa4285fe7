# SPDX-License-Identifier: Apache-2.0
"""An excerpt is a piece of its passage, word for word, around the sentence that answers."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.embodiment.excerpt import excerpt

PASSAGE = "I fit through every door. My wheels turn.\nI cannot carry anything. I run on a battery."


@given(st.text(), st.text(), st.integers(1, 300))
def test_an_excerpt_is_of_its_passage_and_bounded(text: str, question: str, longest: int) -> None:
    shown = excerpt(text, question, longest).text
    inner = shown.removeprefix("… ").removesuffix(" …")
    assert "".join(inner.split()) in "".join(text.split()) and len(inner) <= longest + 4


def test_it_has_the_sentence_with_the_most_terms() -> None:
    assert excerpt(PASSAGE, "How much can you carry?", 50) == ("… I cannot carry anything. I run on a battery.", 2)
    assert excerpt(PASSAGE, "Who carries anyone?", 24).text == "… I cannot carry anything. …"
    assert excerpt(PASSAGE, "Do you fit a door?", 45) == ("I fit through every door. My wheels turn. …", 4)


def test_a_measure_is_found_by_the_words_of_documents() -> None:
    assert excerpt("It has a lamp. Its mass is 3 kg.", "How heavy is it?", 20) == ("… Its mass is 3 kg.", 2)
    assert excerpt("Er hat Lampen. Er wiegt 3 kg.", "Wie schwer ist er?", 20) == ("… Er wiegt 3 kg.", 2)

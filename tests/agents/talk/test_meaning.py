# SPDX-License-Identifier: Apache-2.0
"""The likeness of sentences by meaning: by words until the examples have their vectors, then by these."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np

from rai_missions.agents.talk.meaning import MeaningLikeness, likeness_in
from rai_missions.conversation.likeness import WordLikeness

EXAMPLES = ("head for home", "seek the thing")


class FirstLetters:
    """Vectors by the first letter of a text, which are made once they may be."""

    name = "first letters"

    def __init__(self) -> None:
        self.may, self.made = threading.Event(), threading.Event()

    def vectors(self, texts: Sequence[str]) -> Any:
        assert self.may.wait(10)
        self.made.set()
        return np.array([[float(text[0] == letter) for letter in "hs"] for text in texts], np.float32)


def test_words_count_until_the_examples_have_their_vectors_and_no_one_waits_for_these() -> None:
    embedder = FirstLetters()
    likeness = MeaningLikeness(embedder)
    assert likeness.scores("seek home", EXAMPLES) == WordLikeness().scores("seek home", EXAMPLES)
    embedder.may.set()
    assert embedder.made.wait(10)
    likeness.close(10.0)
    home, thing = likeness.scores("hasten", EXAMPLES)
    assert home > 0.5 > thing == 0


def test_a_language_that_the_encoder_does_not_know_is_compared_by_words() -> None:
    assert isinstance(likeness_in("de"), WordLikeness)

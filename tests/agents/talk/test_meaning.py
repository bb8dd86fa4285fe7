# SPDX-License-Identifier: Apache-2.0
"""The likeness of sentences by meaning: by words until the examples have their vectors, then by these."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np

from rai_missions.agents.talk.meaning import MeaningLikeness, likeness_in
from rai_missions.conversation.grammar.likeness import WordLikeness

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


ENDS = """
import atexit, threading
is_alive = lambda: any(each.name == "meaning" for each in threading.enumerate())
atexit.register(lambda: print("alive" if is_alive() else "ended", embedder.texts))  # last of all

from rai_missions.agents.talk.meaning import MeaningLikeness

class Slow:
    name, texts, has_begun = "slow", 0, threading.Event()

    def vectors(self, texts):
        for self.texts, _ in enumerate(texts, self.texts + 1):
            self.has_begun.set()
            sum(range(20_000))
        return [[1.0]] * len(texts)

embedder = Slow()
likeness = MeaningLikeness(embedder)
likeness.scores("go", [str(each) for each in range(5_000)])
embedder.has_begun.wait(10)
"""


def test_the_end_of_the_program_leaves_no_vector_half_made_and_waits_for_no_other() -> None:
    done = subprocess.run([sys.executable, "-c", ENDS], capture_output=True, text=True, timeout=30, check=True)
    how, texts = done.stdout.split()
    assert how == "ended" and int(texts) < 5_000

# SPDX-License-Identifier: Apache-2.0
"""The network of phrases: by its definition, and with the weights of the package on real speech."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.voice.fusion import LEAST_ODDS
from rai_missions.voice.listener import PHRASES
from rai_missions.voice.recognisers.phrase_network import MOST_STEPS, USUAL_STEPS, PhraseNetwork, trained_network
from rai_missions.voice.recognisers.whisper import open_recogniser
from tests.voice.conftest import needs_voice

SPOKEN = ("continue", "cancel the mission", "resume the mission", "no")
OTHER_WORDS = ("Where is my cup?", "The panel.", "Seven.")


def by_definition(layers: dict[str, Any], states: list[list[float]]) -> list[float]:
    """What the network answers, number by number."""

    def layer(rows: list[list[float]], kernel: Any, bias: Any, size: int) -> list[list[float]]:
        side = len(kernel) // 2
        found = []
        for at in range(len(rows)):
            row = [float(each) for each in bias]
            for offset in range(-side, side + 1):
                if 0 <= at + offset < len(rows):
                    for one, value in enumerate(rows[at + offset]):
                        for other in range(size):
                            row[other] += value * float(kernel[offset + side][one][other])
            found.append([max(0.0, each) for each in row])
        return found

    size = len(layers["reduce_bias"])
    features = layer(states, layers["reduce"][None], layers["reduce_bias"], size)
    features = layer(features, layers["near"], layers["near_bias"], size)
    far = layer(features, layers["far"], layers["far_bias"], size)
    columns = list(
        zip(*[[a + b for a, b in zip(x, y, strict=True)] for x, y in zip(features, far, strict=True)], strict=True)
    )
    pooled = [max(each) for each in columns] + [sum(each) / USUAL_STEPS for each in columns]
    answers = [
        float(bias) + sum(value * float(layers["answer"][place][at]) for place, value in enumerate(pooled))
        for at, bias in enumerate(layers["answer_bias"])
    ]
    return [each - answers[-1] for each in answers[:-1]]


@settings(deadline=None, max_examples=30)
@given(st.integers(1, 7), st.sampled_from([1, 3, 5]), st.integers(0, 10_000))
def test_the_odds_are_those_of_the_definition(steps: int, width: int, seed: int) -> None:
    random, size = np.random.default_rng(seed), 3
    shapes = {
        "reduce": (4, size), "near": (width, size, size), "far": (width, size, size), "answer": (2 * size, 3),
        "reduce_bias": (size,), "near_bias": (size,), "far_bias": (size,), "answer_bias": (3,),
    }  # fmt: skip
    layers = {name: random.normal(size=shape) for name, shape in shapes.items()}
    states = random.normal(size=(steps, 4))
    found = PhraseNetwork(["stop", "yes"], layers).odds(states, ("yes", "stop", "open"))
    assert list(found) == ["stop", "yes"], "of other phrases it knows nothing"
    expected = by_definition(layers, states.tolist())
    assert all(math.isclose(*each, abs_tol=1e-9) for each in zip(found.values(), expected, strict=True))


def test_a_longer_turn_and_phrases_of_others_have_no_odds() -> None:
    network = trained_network()
    states = np.zeros((MOST_STEPS, 384), np.float32)
    assert set(network.odds(states, PHRASES)) == set(PHRASES), "it was trained for those that are usual"
    assert network.odds(np.zeros((MOST_STEPS + 1, 384), np.float32), PHRASES) == {}
    assert network.odds(states, ("dig a hole",)) == {}


CPU_OF_ODDS = """
import time
from rai_missions.voice.recognisers.whisper import open_recogniser
open_recogniser()
import numpy as np
from rai_missions.voice.recognisers.phrase_network import trained_network
states = np.random.default_rng(1).normal(size=(60, 384)).astype(np.float32)
trained_network().odds(states, ())
before = time.process_time()
for _ in range(5):
    trained_network().odds(states, ())
    time.sleep(0.1)  # in which threads of OpenBLAS would spin
print((time.process_time() - before) / 5 * 1000)
"""


@needs_voice
@pytest.mark.xdist_group("voice")
def test_threads_of_a_recogniser_that_have_nothing_to_do_take_no_cpu_time() -> None:
    words = {name: text for name, text in os.environ.items() if not name.startswith("OPENBLAS")}
    found = subprocess.run([sys.executable, "-c", CPU_OF_ODDS], env=words, capture_output=True, text=True, check=True)
    assert float(found.stdout) < 15, "milliseconds; OpenBLAS spins for about 80 by itself on two cores"


@pytest.mark.long
@needs_voice
@pytest.mark.xdist_group("voice")
def test_phrases_in_noise_have_odds_and_other_words_have_none() -> None:
    from benchmarks.bench_voice import mixed, speech
    from benchmarks.train_phrases import turns
    from rai_missions.voice.ear import SoundEar

    whisper, ear, random = open_recogniser(threads=1), SoundEar(), np.random.default_rng(1)

    def recognised(text: str) -> str:
        (turn,) = turns(ear, mixed(speech(text, "rms"), 15, "pink", random))
        odds = whisper.transcribe(turn, PHRASES).odds
        best = max(odds, key=lambda each: odds[each], default="")
        return best if odds.get(best, 0.0) >= LEAST_ODDS else ""

    assert [recognised(f"{phrase.capitalize()}.") for phrase in SPOKEN] == list(SPOKEN)
    assert [recognised(text) for text in OTHER_WORDS] == [""] * len(OTHER_WORDS)

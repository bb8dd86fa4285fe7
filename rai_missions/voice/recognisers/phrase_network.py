# SPDX-License-Identifier: Apache-2.0
"""A small network that recognises the usual phrases in what Whisper's encoder makes of a short turn.

Whisper's own decoder is made for sentences. In noise it reads "continue" as "thanks for me", though the two still
differ in what its encoder gave. The network was trained for that alone: twelve phrases and other words, by voices of
Kokoro and Festival in noise (`benchmarks/train_phrases.py`; see decision 0183). It costs a millisecond.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

__all__ = ("MOST_STEPS", "PhraseNetwork", "trained_network")

WEIGHTS = "phrase_network.npz"
MOST_STEPS, STEPS_AFTER = 100, 4
"""Steps of 20 ms: a longer turn is none of the phrases; how many after the sound belong to it."""
USUAL_STEPS = 50
"""The unit of the sums over time, about the length of a phrase."""


class PhraseNetwork:
    """Two convolutions over time, the second added to the first, their maxima and sums, and a layer for the answer.

    Args:
        phrases: What it distinguishes, in lower case without punctuation; "none of them" comes last and is not named.
        layers: Name → weights: `reduce` and `reduce_bias` (states to features), `near` and `far` (9 × features ×
            features) with their biases, `answer` (2 · features × answers) and `answer_bias`.
    """

    def __init__(self, phrases: Sequence[str], layers: dict[str, Any]) -> None:
        self._phrases = tuple(phrases)
        self._layers = layers

    def odds(self, states: Any, phrases: Sequence[str]) -> dict[str, float]:
        """The log odds of each phrase that the network was trained for against no phrase at all, in nats.

        Args:
            states: Steps × size, Whisper tiny's encoding of a turn; see `STEPS_AFTER`.
            phrases: Those that are expected; of others there is nothing.
        """
        import numpy as np

        if len(states) > MOST_STEPS:
            return {}
        part = self._layers
        features = np.maximum(states @ part["reduce"] + part["reduce_bias"], 0.0)
        features = np.maximum(_convolved(features, part["near"]) + part["near_bias"], 0.0)
        features = features + np.maximum(_convolved(features, part["far"]) + part["far_bias"], 0.0)
        pooled = np.concatenate([features.max(0), features.sum(0) / USUAL_STEPS])
        answers = pooled @ part["answer"] + part["answer_bias"]
        odds = zip(self._phrases, (answers[:-1] - answers[-1]).tolist(), strict=True)
        return {phrase: value for phrase, value in odds if phrase in phrases}


@cache
def trained_network() -> PhraseNetwork:
    """The one that this package has, for the states of `tiny.en`."""
    import numpy as np

    file = resources.files(__package__) / WEIGHTS
    with file.open("rb") as content, np.load(content, allow_pickle=False) as found:
        layers = {name: found[name].astype(np.float32) for name in found.files if name != "phrases"}
        return PhraseNetwork(found["phrases"].tolist(), layers)


def _convolved(features: Any, kernel: Any) -> Any:
    """A sequence after a kernel of an odd width; it is as long as before, with nothing around it."""
    import numpy as np

    side = len(kernel) // 2
    padded = np.pad(features, ((side, side), (0, 0)))
    return sum(padded[at : at + len(features)] @ weights for at, weights in enumerate(kernel))

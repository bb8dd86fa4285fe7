# SPDX-License-Identifier: Apache-2.0
"""PocketSphinx with a grammar of the phrases that are expected: the second recogniser.

Rule: never alone. It has no rejection: whatever it is given becomes one of the phrases.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from rai_missions.voice.absent import absent
from rai_missions.voice.kind import Reading

__all__ = ("PocketSphinx", "grammar")

WORD = re.compile(r"[a-z']+")
BEST, NEXT_BEST = 2.0, 1.0
"""Nats of evidence. It has no likelihoods that help: their differences do not separate right from wrong guesses."""
SETTINGS = {"lm": None, "loglevel": "FATAL", "samprate": 16_000, "bestpath": False, "topn": 8}
"""Without the second search over the lattice, which prefers a part of a phrase; eight Gaussians a frame instead of
four, for noise."""


def grammar(phrases: Sequence[str]) -> str:
    """A grammar (JSpeech Grammar Format) of these phrases."""
    return f"#JSGF V1.0; grammar phrases; public <phrase> = {' | '.join(phrases)};"


class PocketSphinx:
    """Guesses which phrase a sound is, and which it would be otherwise, with the model of its wheel.

    Raises:
        UsageError: It is not installed.
    """

    def __init__(self) -> None:
        try:
            from pocketsphinx import Decoder
        except ImportError:
            raise absent("the recogniser 'pocketsphinx'", "pocketsphinx") from None
        self._make = Decoder
        self._phrases: tuple[str, ...] = ()
        self._known: tuple[str, ...] = ()
        self._decoder: Any = None

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """See `Recogniser`."""
        if tuple(phrases) != self._phrases:
            self._phrases, self._decoder = tuple(phrases), self._make(**SETTINGS)
            self._known = tuple(each for each in phrases if self._is_known(each))
            for without in ("", *self._known):
                if left := [each for each in self._known if each != without]:
                    self._decoder.add_jsgf_string(f"without {without}", grammar(left))
        if not self._known or not samples:
            return Reading("")
        best = self._guess(samples, "")
        if not best:
            return Reading("")
        next_best = self._guess(samples, best) if len(self._known) > 1 else ""
        return Reading(best, {best: BEST} | ({next_best: NEXT_BEST} if next_best else {}))

    def _is_known(self, phrase: str) -> bool:
        """Whether its words are all in the dictionary."""
        return " ".join(WORD.findall(phrase)) == phrase and all(
            self._decoder.lookup_word(word) is not None for word in phrase.split()
        )

    def _guess(self, samples: bytes, without: str) -> str:
        self._decoder.activate_search(f"without {without}")
        self._decoder.start_utt()
        self._decoder.process_raw(samples, full_utt=True)
        self._decoder.end_utt()
        found = self._decoder.hyp()
        return found.hypstr if found is not None and found.hypstr in self._known else ""

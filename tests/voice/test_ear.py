# SPDX-License-Identifier: Apache-2.0
"""What an ear makes of frames: speech in noise, also where the noise breaks off."""

from __future__ import annotations

import pytest

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from tests.voice.conftest import needs_voice, spoken

pytestmark = [needs_voice, pytest.mark.xdist_group("voice")]

SPEAKERS = ("slt", "rms", "awb", "kal")
NOISE_DB = 10.0
"""How far the noise is below the loud parts of the words."""


SILENT_FRAMES = 12


def in_noise(words: list[str], seed: int) -> list[bytes]:
    """Words, each with 1.5 s of noise before it and digital silence behind it."""
    import numpy as np

    random, found = np.random.default_rng(seed), list[bytes]()
    for number, word in enumerate(words):
        sound = np.frombuffer(spoken(word, SPEAKERS[number % 4]), "<i2").astype(float)
        loud = np.sqrt(np.mean(sound[np.abs(sound) > 100] ** 2))
        whole = np.concatenate([np.zeros(3 * RATE_HZ // 2), sound, np.zeros(RATE_HZ // 2)])
        whole += random.normal(size=len(whole)) * loud * 10 ** (-NOISE_DB / 20)
        found.append(bytes(whole.clip(-32768, 32767).astype("<i2").tobytes()) + bytes(SILENT_FRAMES * FRAME_BYTES))
    return found


@pytest.mark.long
def test_short_words_are_speech_however_often_the_sound_breaks_off() -> None:
    from rai_missions.voice.ear import SoundEar

    ear, words, missed = SoundEar(echo=False), [f"{word}." for word in ("Stop", "No", "Pause") for _ in range(8)], []
    for word, sound in zip(words, in_noise(words, 6001), strict=True):
        frames = [sound[at : at + FRAME_BYTES] for at in range(0, len(sound) - FRAME_BYTES + 1, FRAME_BYTES)]
        speech = [ear.take(each, bytes(FRAME_BYTES)).speech for each in frames]
        missed += [word] if sum(each >= 0.5 for each in speech) < 2 else []
    assert missed == []


def test_noise_alone_is_no_speech_whenever_the_look_begins_again() -> None:
    import numpy as np

    from rai_missions.voice.ear import SoundEar

    ear, random = SoundEar(echo=False), np.random.default_rng(6002)
    frames = [(random.normal(size=FRAME_BYTES // 2) * 400).astype("<i2").tobytes() for _ in range(400)]
    assert max(ear.take(each, bytes(FRAME_BYTES)).speech for each in frames) < 0.5


def test_a_wake_word_is_known_and_what_is_near_to_it_is_none() -> None:
    from rai_missions.voice.ear import WakeWord
    from rai_missions.voice.listener import WAKE_CUTOFF

    def most(name: str, text: str, speaker: str) -> float:
        word, sound = WakeWord(name), bytes(RATE_HZ) + spoken(text, speaker) + bytes(RATE_HZ)
        return max(word.take(sound[at : at + FRAME_BYTES]) for at in range(0, len(sound), FRAME_BYTES))

    assert min(most("okay_nabu", "Okay nah boo.", each) for each in ("slt", "rms", "awb")) >= WAKE_CUTOFF
    assert most("hey_jarvis", "Hey jarvis.", "rms") >= WAKE_CUTOFF
    near = "A def statement executed inside a function definition defines a local function that can be returned or"
    assert 0.3 < most("hey_jarvis", f"objects. {near} passed around. Free", "rms") < WAKE_CUTOFF

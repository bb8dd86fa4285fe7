# SPDX-License-Identifier: Apache-2.0
"""What an ear makes of frames: speech in noise, also where the noise breaks off."""

from __future__ import annotations

import pytest

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, RATE_HZ
from rai_missions.voice.crowd import Crowd
from rai_missions.voice.turns import TurnDetector, TurnEvent, TurnFrame
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


PASSAGE = (
    "The robot drives to the kitchen and looks for a cup on the table next to the window while a person waits in the"
    " garden with a bag of seeds and two green plants that were bought at the market in the old town last week"
)


def in_crowd(word: str, voices: int) -> list[bytes]:
    """A word by rms after 6 s, 10 dB louder than so many voices that speak all the time, in frames."""
    import numpy as np

    passages = [np.frombuffer(spoken(PASSAGE, each), "<i2").astype(float)[: 10 * RATE_HZ] for each in SPEAKERS]
    shifted = [np.roll(passages[each % 4], each * len(passages[each % 4]) // 7) for each in range(voices)]
    length = min(len(each) for each in shifted)
    crowd = np.sum([each[:length] / np.std(each) for each in shifted], axis=0)
    sound = np.frombuffer(spoken(word, "rms"), "<i2").astype(float)
    loud = np.sqrt(np.mean(sound[np.abs(sound) > 100] ** 2))
    whole = crowd / np.std(crowd) * loud * 10 ** (-NOISE_DB / 20)
    whole[6 * RATE_HZ : 6 * RATE_HZ + len(sound)] += sound
    data = bytes(whole.clip(-32768, 32767).astype("<i2").tobytes())
    return [data[at : at + FRAME_BYTES] for at in range(0, len(data) - FRAME_BYTES + 1, FRAME_BYTES)]


@pytest.mark.long
def test_a_person_in_a_crowd_has_a_turn_of_their_own_that_ends_while_the_crowd_speaks_on() -> None:
    from rai_missions.voice.ear import SoundEar

    ear, detector, events = SoundEar(echo=False), TurnDetector(), list[TurnEvent]()
    for number, frame in enumerate(in_crowd("Cancel the mission.", 8)):
        speech = ear.take(frame, bytes(FRAME_BYTES)).speech
        events += detector.take(TurnFrame(number * FRAME_S, speech, b"", b""))
    turns = {each.number: each.at for each in events if each.kind == "began" and each.at > 5.5}
    (end,) = [each for each in events if each.kind == "ended" and each.number in turns]
    assert turns[end.number] == pytest.approx(6.1, abs=0.25)
    assert end.spoken_until == pytest.approx(6.9, abs=0.35)


@pytest.mark.parametrize("speaker", SPEAKERS)
def test_one_person_who_speaks_without_a_pause_is_no_crowd(speaker: str) -> None:
    import numpy as np

    from rai_missions.voice.ear import level_db

    sound = np.frombuffer(spoken(PASSAGE, speaker), "<i2").astype(float)
    for noise in (0.0, np.sqrt(np.mean(sound[np.abs(sound) > 100] ** 2)) * 10 ** (-NOISE_DB / 20)):
        data = (sound + np.random.default_rng(6003).normal(size=len(sound)) * noise).clip(-32768, 32767).astype("<i2")
        crowd, samples = Crowd(), FRAME_BYTES // 2
        levels = [level_db(data[at : at + samples].tobytes()) for at in range(0, len(data) - samples + 1, samples)]
        assert len(levels) > 200 and {crowd.take(0.9, each) for each in levels} == {0.9}

# SPDX-License-Identifier: Apache-2.0
"""flite's library makes the sound that its program makes, piece by piece."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.errors import UsageError
from rai_missions.voice.voices.flite import STREAMED, Flite, open_voice
from rai_missions.voice.voices.flite_library import FliteLibrary
from tests.voice.conftest import needs_voice

WORDS = st.lists(
    st.sampled_from(["stop", "the", "mission", "0.983", "'going':", "way,", "Why?", "été", "Ready."]),
    min_size=1,
    max_size=9,
).map(" ".join)
LONG = "The robot drives to the kitchen and looks for a cup: it is red, and it is on the table or next to the chair."
pytestmark = [needs_voice, pytest.mark.xdist_group("voice")]


@pytest.fixture(scope="module", params=STREAMED)
def speaker(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def library(speaker: str) -> FliteLibrary:
    voice = open_voice(speaker)
    assert isinstance(voice, FliteLibrary), "the library loads"
    return voice


@given(text=WORDS)
def test_the_library_makes_as_much_sound_as_the_program(text: str, speaker: str, library: FliteLibrary) -> None:
    assert sum(map(len, library.speak(text))) == len(b"".join(Flite(speaker).speak(text)))


def test_it_is_the_sound_of_the_program_but_for_the_noise_in_it(speaker: str, library: FliteLibrary) -> None:
    import numpy as np

    ours, other = (np.frombuffer(b"".join(voice.speak(LONG)), "<i2") for voice in (library, Flite(speaker)))
    assert np.corrcoef(ours.astype(float), other.astype(float))[0, 1] > 0.9, "the noise of each speech is drawn again"


def test_the_first_piece_of_a_long_sentence_is_a_quarter_of_a_second(library: FliteLibrary) -> None:
    first, *others = (len(piece) / (2 * RATE_HZ) for piece in library.speak(LONG))
    assert 0.25 <= first < 0.3
    assert sum(others) > 4.0
    assert max(others) < 1.1


def test_a_sentence_that_is_given_up_leaves_the_next_one_whole(library: FliteLibrary) -> None:
    whole = sum(map(len, library.speak("I do not know.")))
    for count in range(3):
        pieces = library.speak(LONG)
        assert len(list(itertools.islice(pieces, count))) == count
        pieces.close()  # type: ignore[attr-defined]
        assert sum(map(len, library.speak("I do not know."))) == whole


def spoken(voice: FliteLibrary) -> list[int]:
    return list(map(len, voice.speak("Ready.")))


def test_a_speaker_that_was_opened_again_speaks_for_each_and_for_both_at_once(speaker: str) -> None:
    """flite has one voice of a speaker in a process, and frees what it was given before."""
    voices = [FliteLibrary(speaker) for _ in range(100)]
    alone = spoken(voices[-1])
    assert list(map(spoken, voices[::10])) == [alone] * 10
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(spoken, voices[:8])) == [alone] * 8


def test_a_speaker_of_another_rate_is_asked_by_the_program() -> None:
    assert isinstance(open_voice("kal"), Flite)


def test_sound_of_another_rate_is_refused() -> None:
    with pytest.raises(UsageError, match="not of 16 kHz on one channel"):
        list(FliteLibrary("kal").speak("Ready."))

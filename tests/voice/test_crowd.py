# SPDX-License-Identifier: Apache-2.0
"""A room full of people: laws over any levels."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.voice.crowd import CROWD_FRAMES, FALLEN_FRAMES, LOUDER_DB, SPEECH, Crowd

levels = st.floats(20.0, 90.0)
frames = st.lists(st.tuples(st.floats(0.0, 1.0), levels), max_size=200)
steady = st.integers(0, 10**6).map(lambda seed: [(seed * (each + 7919) % 4001) / 1000 for each in range(300)])
"""Levels within 4 dB."""


@given(frames)
def test_no_speech_is_made_and_none_is_taken_where_speech_has_not_lasted(given_: list[tuple[float, float]]) -> None:
    crowd, lasting, missing = Crowd(), 0, 0
    for speech, level in given_:
        found = crowd.take(speech, level)
        missing = 0 if speech >= SPEECH else missing + 1
        lasting = lasting + 1 if missing < FALLEN_FRAMES else 0
        assert found == speech or (found == 0.0 and lasting >= CROWD_FRAMES)


@given(frames, levels, steady, st.integers(3, 40))
def test_a_crowd_is_no_person_after_a_while_and_who_is_louder_is_one(
    before: list[tuple[float, float]], level: float, noise: list[float], gap: int
) -> None:
    crowd = Crowd()
    for each in before:
        crowd.take(*each)
    found = [
        crowd.take(0.1 if number % gap == gap - 1 else 0.9, level + more) for number, more in enumerate(noise[:130])
    ]
    assert not any(found[-20:])
    assert [crowd.take(0.9, level + more + LOUDER_DB + 4.5) for more in noise[130:160]] == [0.9] * 30
    assert not any([crowd.take(0.9, level + more) for more in noise[160:190]][-20:])


@given(st.lists(st.booleans(), min_size=100, max_size=200), levels)
def test_one_person_whose_sounds_are_far_apart_is_no_crowd(loud: list[bool], level: float) -> None:
    crowd = Crowd()
    sounds = [each or number % 4 == 0 for number, each in enumerate(loud)]
    sounds = [each and number % 5 > 0 for number, each in enumerate(sounds)]
    assert [crowd.take(0.9, level + 20.0 * each) for each in sounds] == [0.9] * len(sounds)


@given(levels, steady, st.integers(6, 30))
def test_after_a_crowd_any_person_is_one_again(level: float, noise: list[float], quiet: int) -> None:
    crowd = Crowd()
    for more in noise[:CROWD_FRAMES]:
        crowd.take(0.9, level + more)
    for _ in range(quiet):
        crowd.take(0.1, level - 20.0)
    assert [crowd.take(0.9, level + more) for more in noise[: CROWD_FRAMES - 1]] == [0.9] * (CROWD_FRAMES - 1)

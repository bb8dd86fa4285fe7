# SPDX-License-Identifier: Apache-2.0
"""What is louder than our echo can be, over any room: never the echo itself, always a person who is that loud."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import partial

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ, SILENCE, SoundFrame
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.voice.double_talk import HELD_FRAMES, KNOWN_FRAMES, DoubleTalk
from rai_missions.voice.echo_filter import EchoFilter
from tests.voice.conftest import needs_voice, spoken

np = pytest.importorskip("numpy")

FRAME = FRAME_BYTES // 2
REPORT_FRAMES, PERSON_AT, PERSON_FRAMES = 100, 50, 10
ROOMS, USUAL_ROOMS, QUIET_ROOMS = (
    st.tuples(st.integers(0, 9999), st.floats(-50.0, most), st.floats(0.0, 450.0), st.integers(0, 20))
    for most in (0.0, -6.0, -20.0)
)
"""Seed, level of the echo in dB, its delay in ms, how many reflections."""


def syllables(random: np.random.Generator, frames: int) -> bytes:
    """Sound that changes its level and its spectrum a few times a second, as speech does."""
    found = []
    while sum(map(len, found)) < frames * FRAME:
        count = int(random.integers(3, 10)) * FRAME
        frequencies = np.fft.rfftfreq(count, 1 / RATE_HZ)
        centre, width = random.uniform(200, 4000), random.uniform(200, 2000)
        spectrum = np.fft.rfft(random.normal(size=count)) * np.exp(-(((frequencies - centre) / width) ** 2))
        sound = np.fft.irfft(spectrum, count)
        found.append(sound / np.sqrt(np.mean(sound**2)) * random.choice([30, 1000, 3000]))
    return bytes(np.concatenate(found)[: frames * FRAME].clip(-32768, 32767).astype("<i2").tobytes())


def frames_of(
    room: tuple[int, float, float, int], person: bytes = b"", *, report: bytes | None = None
) -> list[SoundFrame]:
    """A report in a room, with a person in it."""
    seed, echo_db, delay_ms, reflections = room
    random, tail = np.random.default_rng(seed), np.zeros(800)
    ours = syllables(random, REPORT_FRAMES) if report is None else report
    places = random.integers(1, 800, reflections)
    tail[places] = random.normal(size=reflections) * np.exp(-places / 400) * 0.3
    sound = RoomSound(
        person.ljust(len(ours), b"\0"), echo_db=echo_db, delay_ms=delay_ms, tail=tuple(tail[: 800 * bool(reflections)])
    )
    found, pieces = list[SoundFrame](), iter(range(0, len(ours), FRAME_BYTES))
    sound.play(lambda at: ours[start : start + FRAME_BYTES] if (start := next(pieces, None)) is not None else b"")
    sound.listen(found.append)
    sound.start()
    while not sound.over:
        sound.step()
    return found


def found_in(frames: list[SoundFrame]) -> list[int]:
    double_talk, echo_filter = DoubleTalk(), EchoFilter()
    return [
        number
        for number, each in enumerate(frames)
        if double_talk.take(each.recorded, echo_filter.take(each.recorded, each.played), each.played)
    ]


@settings(max_examples=25)
@given(ROOMS)
def test_our_own_echo_is_no_person_in_any_room(room: tuple[int, float, float, int]) -> None:
    assert found_in(frames_of(room)) == []


@pytest.mark.long
@settings(max_examples=25)
@given(USUAL_ROOMS, st.integers(2, 20))
def test_the_echo_of_a_low_tone_is_no_person_whenever_it_returns(
    room: tuple[int, float, float, int], eighths: int
) -> None:
    random, at = np.random.default_rng(room[0]), np.arange(20 * FRAME) / RATE_HZ
    tone = 9000 * np.sin(2 * np.pi * 125.0 * at) * np.minimum(1, at * 1000 / eighths)
    noise = random.normal(size=40 * FRAME) * 3000
    report = np.concatenate([noise, np.zeros(30 * FRAME), tone, np.zeros(20 * FRAME)])
    assert found_in(frames_of(room, report=bytes(report.clip(-32768, 32767).astype("<i2").tobytes()))) == []


@settings(max_examples=25)
@given(QUIET_ROOMS)
def test_a_person_far_louder_than_the_echo_is_known_at_once(room: tuple[int, float, float, int]) -> None:
    speech = np.random.default_rng(room[0]).normal(size=PERSON_FRAMES * FRAME) * 8000
    person = bytes(PERSON_AT * FRAME_BYTES) + bytes(speech.clip(-32768, 32767).astype("<i2").tobytes())
    found = found_in(frames_of(room, person))
    assert found[:1] == [PERSON_AT]
    assert set(found) >= set(range(PERSON_AT, PERSON_AT + PERSON_FRAMES))
    assert max(found) <= PERSON_AT + PERSON_FRAMES + HELD_FRAMES


def level(sound: bytes) -> float:
    return float(np.sqrt(np.mean(np.frombuffer(sound, "<i2").astype(float) ** 2)))


@pytest.mark.parametrize("room", [(1, -6.0, 0.0, 0), (2, -6.0, 60.0, 20), (3, -12.0, 400.0, 20)])
def test_a_filter_learns_the_room_and_takes_nothing_where_nothing_is_played(
    room: tuple[int, float, float, int],
) -> None:
    echo_filter, frames = EchoFilter(), frames_of(room)
    left = [echo_filter.take(each.recorded, each.played) for each in frames * 2][-len(frames) :]
    whole = [level(b"".join(each)) for each in ([frame.recorded for frame in frames], left)]
    assert whole[1] < 0.5 * whole[0]
    for _ in range(20):
        echo_filter.take(SILENCE, SILENCE)
    assert echo_filter.take(frames[0].recorded, SILENCE) == frames[0].recorded


def test_a_person_as_loud_as_the_echo_is_known_once_the_room_is_learned() -> None:
    room = (3, -6.0, 60.0, 20)
    ours = np.frombuffer(syllables(np.random.default_rng(3), REPORT_FRAMES), "<i2")
    speech = ours[20 * FRAME : (20 + PERSON_FRAMES) * FRAME] // 2
    person = bytes(PERSON_AT * FRAME_BYTES) + bytes(speech.astype("<i2").tobytes())
    learned = frames_of(room)
    found = [number - len(learned) for number in found_in(learned + frames_of(room, person))]
    assert found[0] in range(PERSON_AT, PERSON_AT + 3)
    assert found[-1] <= PERSON_AT + PERSON_FRAMES + HELD_FRAMES


def test_an_echo_that_is_predicted_and_does_not_come_is_no_person() -> None:
    frames = frames_of((3, -6.0, 60.0, 20))
    gone = [each._replace(recorded=SILENCE) for each in frames[:30]]
    assert found_in(frames * 2 + gone) == []


@pytest.mark.parametrize(
    "other", [(7, -6.0, 200.0, 0), (8, -20.0, 20.0, 20), (9, -12.0, 120.0, 20), (10, -3.0, 60.0, 20)]
)
def test_another_room_is_noticed_once_and_learned_again(other: tuple[int, float, float, int]) -> None:
    echo_filter, known = EchoFilter(), frames_of((3, -12.0, 60.0, 20))
    changed = list[int]()
    for number, each in enumerate(known * 2 + frames_of(other) * 2):
        echo_filter.take(each.recorded, each.played)
        if echo_filter.match.is_changed:
            changed.append(number - 2 * len(known))
            echo_filter.forget()
    assert len(changed) == 1
    assert 0 <= changed[0] < 25


@settings(max_examples=8)
@given(st.integers(0, 9999), st.floats(-20.0, 0.0), st.floats(0.0, 450.0))
@example(3, -12.0, 200.0)
@example(3, -6.0, 400.0)
def test_a_room_that_is_known_is_no_other_one_before_the_echo_of_a_report(
    seed: int, echo_db: float, delay_ms: float
) -> None:
    echo_filter, quiet = EchoFilter(), bytes((REPORT_FRAMES + 20) * FRAME_BYTES)
    reports = [frames_of((each, echo_db, delay_ms, 0), quiet) for each in (seed, seed + 1000)]
    for number, each in enumerate(itertools.chain(*reports)):
        echo_filter.take(each.recorded, each.played)
        assert not echo_filter.match.is_changed, number


@settings(max_examples=8)
@given(st.integers(0, 9999), st.floats(-20.0, 0.0), st.integers(5, 80), st.floats(300.0, 8000.0))
def test_a_person_changes_no_room(seed: int, echo_db: float, begin: int, loud: float) -> None:
    person = np.frombuffer(syllables(np.random.default_rng(seed + 1), 20), "<i2") * (loud / 3000.0)
    room, echo_filter = (seed, echo_db, 60.0, 20), EchoFilter()
    speech = bytes(begin * FRAME_BYTES) + bytes(person.clip(-32768, 32767).astype("<i2").tobytes())
    for number, each in enumerate(frames_of(room) * 2 + frames_of(room, speech)):
        echo_filter.take(each.recorded, each.played)
        assert not echo_filter.match.is_changed, number


def test_nothing_is_certain_before_enough_was_played() -> None:
    random = np.random.default_rng(1)
    loud = [(random.normal(size=FRAME) * 5000).astype("<i2").tobytes() for _ in range(100)]
    assert found_in([SoundFrame(0.0, each, SILENCE) for each in loud]) == []
    assert found_in([SoundFrame(0.0, each, each) for each in loud[: KNOWN_FRAMES // 2]]) == []


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.parametrize("echo_db", [None, -40.0, -20.0])
def test_a_person_is_recognised_within_the_first_report(echo_db: float | None) -> None:
    from rai_missions.voice.ear import SoundEar

    ours, stop = spoken("I am driving to the kitchen. Four of six waypoints are done.", "slt"), spoken("Stop.", "rms")
    at = 2 * RATE_HZ // FRAME * FRAME
    room = RoomSound(bytes(2 * at) + stop + bytes(RATE_HZ), echo_db=echo_db)
    pieces = iter(range(0, len(ours), FRAME_BYTES))
    room.play(lambda now: ours[start : start + FRAME_BYTES] if (start := next(pieces, None)) is not None else b"")
    frames, ear = list[SoundFrame](), SoundEar()
    room.listen(frames.append)
    room.start()
    while not room.over:
        room.step()
    speech = [number for number, each in enumerate(frames) if ear.take(each.recorded, each.played).speech >= 0.5]
    first, last = at // FRAME, (at + len(stop) // 2) // FRAME
    assert len([number for number in speech if first <= number <= last]) >= 3
    assert [number for number in speech if number < first] == []


@needs_voice
@pytest.mark.xdist_group("voice")
def test_our_own_voice_is_no_person_in_a_room_that_has_just_changed() -> None:
    from rai_missions.voice.ear import SoundEar

    report, ear, speech = "I am driving to the kitchen.", SoundEar(), list[float]()
    for echo_db, delay_ms, text in ((-6.0, 200.0, f"{report} Four of six waypoints are done."), (-12.0, 20.0, report)):
        ours = spoken(text, "rms")
        room = RoomSound(bytes(len(ours) + RATE_HZ), echo_db=echo_db, delay_ms=delay_ms)
        room.play(partial(played_of, iter(range(0, len(ours), FRAME_BYTES)), ours))
        frames = list[SoundFrame]()
        room.listen(frames.append)
        room.start()
        while not room.over:
            room.step()
        speech = [ear.take(each.recorded, each.played).speech for each in frames]
    assert max(speech) < 0.5


def played_of(starts: Iterator[int], ours: bytes, _at: float) -> bytes:
    start = next(starts, None)
    return b"" if start is None else ours[start : start + FRAME_BYTES]

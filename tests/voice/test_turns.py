# SPDX-License-Identifier: Apache-2.0
"""Turns of speech: laws over any sequence of probabilities, and the times that the guide names."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.sound.connector import FRAME_S
from rai_missions.voice.turns import TurnDetector, TurnEvent, TurnFrame

PROBABILITIES = st.lists(st.sampled_from([0.0, 0.2, 0.49, 0.5, 0.9, 1.0]), max_size=120)


def events(probabilities: list[float], *, end: bool = True) -> list[TurnEvent]:
    detector = TurnDetector()
    found = [
        event
        for count, speech in enumerate(probabilities)
        for event in detector.take(TurnFrame(count * FRAME_S, speech, bytes([count % 256]), b""))
    ]
    return found + (list(detector.end()) if end else [])


@given(PROBABILITIES)
def test_every_turn_that_begins_ends_once_with_an_offer_that_is_not_void(probabilities: list[float]) -> None:
    found = events(probabilities)
    numbers = [event.number for event in found if event.kind == "began"]
    assert numbers == list(range(1, len(numbers) + 1))
    assert [event.number for event in found if event.kind == "ended"] == numbers
    for number in numbers:
        kinds = [event.kind for event in found if event.number == number]
        assert kinds[0] == "began"
        assert kinds[-2:] == ["offered", "ended"] or kinds[-1] == "ended"
        offers = [event.offer for event in found if event.number == number and event.kind == "offered"]
        assert offers == list(range(1, len(offers) + 1)), "offers are counted"
        assert found[[each.kind == "ended" and each.number == number for each in found].index(True)].offer == offers[-1]
        assert kinds.count("void") == len(offers) - 1, "each offer but the last is void"


@given(PROBABILITIES)
def test_an_offer_is_settled_once_at_most_after_128_ms_in_which_no_one_speaks(probabilities: list[float]) -> None:
    found = events(probabilities)
    settled = [(event.number, event.offer, event.at) for event in found if event.kind == "settled"]
    assert len({each[:2] for each in settled}) == len(settled)
    for number, offer, at in settled:
        (offered,) = (each for each in found if each.kind == "offered" and (each.number, each.offer) == (number, offer))
        assert at >= offered.at
        assert at - offered.spoken_until >= 0.128 - 1e-6
        frames = range(round(offered.spoken_until / FRAME_S), round(at / FRAME_S))
        assert all(probabilities[frame] < 0.5 for frame in frames)


@given(st.lists(st.integers(1, 16), min_size=3, max_size=12))
def test_who_speaks_on_after_128_ms_of_quiet_is_present_again_by_the_second_frame(runs: list[int]) -> None:
    probabilities = [speech for number, count in enumerate(runs) for speech in [0.9 * (number % 2 == 0)] * count]
    found = events(probabilities, end=False)
    for place, event in enumerate(found):
        if event.kind == "void" and found[place - 1].kind == "settled":
            back = round(event.at / FRAME_S)
            if probabilities[back : back + 1] == [0.9]:
                assert found[place + 1].kind == "present"
                assert found[place + 1].at <= event.at + FRAME_S + 1e-6


@given(PROBABILITIES)
def test_no_sound_belongs_to_two_turns_and_none_of_speech_is_lost(probabilities: list[float]) -> None:
    found = events(probabilities)
    last = {event.number: event for event in found if event.kind == "offered"}
    sounds = [event.clear for event in last.values()]
    joined = b"".join(sounds)
    assert sorted(joined) == list(joined), "in order"
    assert len(set(joined)) == len(joined), "nothing twice"


@given(PROBABILITIES)
def test_the_same_frames_show_the_same(probabilities: list[float]) -> None:
    assert events(probabilities) == events(probabilities)


def test_a_turn_is_offered_after_32_ms_of_quiet_settled_after_128_and_ends_after_400() -> None:
    found = events([0.0] * 10 + [0.9] * 30 + [0.0] * 30, end=False)
    quiet_from = 40 * FRAME_S
    times = {event.kind: event.at - quiet_from for event in found}
    assert times["offered"] == pytest.approx(0.032, abs=1e-6)
    assert times["settled"] == pytest.approx(0.128, abs=1e-6)
    assert times["ended"] == pytest.approx(0.416, abs=1e-6), "the first frame that ends at 400 ms or later"
    assert times["present"] == pytest.approx(-28 * FRAME_S), "two frames of speech: 64 ms"
    assert found[-1].spoken_until == pytest.approx(quiet_from)


@given(PROBABILITIES)
def test_a_turn_is_offered_with_the_first_frame_of_quiet_whatever_its_length(probabilities: list[float]) -> None:
    quiet_s = [event.at - event.spoken_until for event in events(probabilities, end=False) if event.kind == "offered"]
    assert quiet_s == [pytest.approx(FRAME_S)] * len(quiet_s)


def test_a_pause_makes_an_offer_void_and_the_turn_is_offered_whole_again() -> None:
    found = events([0.9] * 10 + [0.0] * 8 + [0.9] * 5, end=True)
    kinds = [event.kind for event in found]
    assert kinds == ["began", "present", "offered", "settled", "void", "present", "offered", "ended"]
    assert found[-2].clear.startswith(found[2].clear)


def test_a_closed_word_ends_its_turn_sooner() -> None:
    detector, found = TurnDetector(), list[TurnEvent]()
    for count, speech in enumerate([0.9] * 10 + [0.0] * 20):
        taken = detector.take(TurnFrame(count * FRAME_S, speech, b"", b""))
        found += taken
        for event in taken:
            if event.kind == "offered":
                detector.end_sooner(event.number, event.offer)
    assert found[-1].kind == "ended"
    assert found[-1].at - 10 * FRAME_S == pytest.approx(0.288)


def test_what_was_shortened_and_then_continued_ends_as_any_other() -> None:
    detector, ended = TurnDetector(), list[TurnEvent]()
    for count, speech in enumerate([0.9] * 10 + [0.0] * 7 + [0.9] * 5 + [0.0] * 20):
        for event in detector.take(TurnFrame(count * FRAME_S, speech, b"", b"")):
            if (event.kind, event.offer) == ("offered", 1):
                detector.end_sooner(event.number, event.offer)
            ended += [event] if event.kind == "ended" else []
    assert [event.at for event in ended] == [pytest.approx((22 + 13) * FRAME_S)]


@given(PROBABILITIES, PROBABILITIES, st.floats(0.41, 3600.0))
def test_frames_that_are_missing_are_quiet_so_what_follows_a_gap_is_another_turn(
    before: list[float], after: list[float], gap_s: float
) -> None:
    detector, found, begins = TurnDetector(), list[TurnEvent](), len(before) * FRAME_S + gap_s
    for count, speech in enumerate(before):
        found += detector.take(TurnFrame(count * FRAME_S, speech, b"b", b""))
    for count, speech in enumerate(after):
        found += detector.take(TurnFrame(begins + count * FRAME_S, speech, b"a", b""))
    found += detector.end()
    sounds = [event.clear for event in found if event.kind == "offered"]
    assert not [each for each in sounds if {*each} == {*b"ab"}], "no turn has sound of both sides"
    alone = [*events(before), *events(after)]
    assert [each.kind for each in found] == [each.kind for each in alone]


@given(PROBABILITIES, PROBABILITIES)
def test_a_turn_that_begins_again_has_the_sound_from_then_on_and_its_offers_before_are_void(
    before: list[float], after: list[float]
) -> None:
    detector, found = TurnDetector(), list[TurnEvent]()
    for count, speech in enumerate(before):
        found += detector.take(TurnFrame(count * FRAME_S, speech, b"b", b""))
    was_open, last = detector.is_open, found[-1].number if found else 0
    found += detector.begin_again()
    for count, speech in enumerate(after, start=len(before)):
        found += detector.take(TurnFrame(count * FRAME_S, speech, b"a", b""))
    found += detector.end()
    again = [event for event in found if event.number == last] if was_open else []
    assert not again or [each.kind for each in again].count("began") == 2
    sounds = {event.offer: event.clear for event in again if event.kind == "offered"}
    assert {event.offer for event in again if event.kind == "void"} == {*sounds} - {max(sounds, default=0)}
    assert not again or sounds[max(sounds)] in (b"b" + b"a" * count for count in range(len(after) + 1))


def test_a_person_who_never_pauses_is_transcribed_after_14_s() -> None:
    found = events([0.9] * 1000, end=False)
    assert found[0].kind == "began"
    assert [event.kind for event in found].count("ended") == 2

# SPDX-License-Identifier: Apache-2.0
"""A clock that follows a simulation: as fast as that goes, never back, and not stopped by its end."""

from __future__ import annotations

import math
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.event import Event
from rai_missions.runtime.clock import PublishedClock
from rai_missions.runtime.mailbox import Mailbox

PATIENT = 1e6
"""Seconds of silence in which time is still: the wall plays no part in the test."""


@given(st.lists(st.floats(0, 1e9, allow_nan=False), max_size=30))
def test_time_never_goes_back_whatever_a_simulation_reports(results: list[float]) -> None:
    clock, before = PublishedClock(PATIENT), 0.0
    for each in results:
        clock.advance(each)
        assert before <= clock.now()
        before = clock.now()


@given(st.floats(0, 1e6), st.lists(st.floats(0.001, 59.0), min_size=1, max_size=20))
def test_it_goes_as_far_as_the_simulation_goes_from_wherever_that_was(start: float, steps: list[float]) -> None:
    clock, reported = PublishedClock(PATIENT), start
    clock.advance(reported)
    assert clock.now() == 0.0, "the run begins now, however long the simulation has run"
    for step in steps:
        reported += step
        clock.advance(reported)
    assert clock.now() == pytest.approx(reported - start, abs=1e-6)


def test_a_simulation_that_begins_again_or_leaps_takes_no_time_with_it() -> None:
    clock = PublishedClock(PATIENT)
    for reported in (100.0, 101.0, 0.05, 0.55, 5000.0, 5000.5):
        clock.advance(reported)
    assert clock.now() == pytest.approx(1.0 + 0.5 + 0.5)


def test_a_wait_ends_when_its_instant_is_reported_and_not_before() -> None:
    clock, mailbox, over = PublishedClock(PATIENT), Mailbox(), threading.Event()

    def wait() -> None:
        clock.wait(mailbox, 1.0, paced=False)
        over.set()

    clock.advance(7.0)
    waiting = threading.Thread(target=wait)
    waiting.start()
    clock.advance(7.9)
    assert not over.is_set()
    clock.advance(8.0)
    assert over.wait(30), "the instant has come"
    waiting.join()
    assert mailbox.take() is None


def test_a_wait_ends_when_something_comes() -> None:
    clock, mailbox = PublishedClock(PATIENT), Mailbox()
    waiting = threading.Thread(target=lambda: clock.wait(mailbox, math.inf, paced=False))
    waiting.start()
    mailbox.post(Event("e"))
    waiting.join(30)
    assert not waiting.is_alive()
    taken = mailbox.take()
    assert taken is not None and taken.name == "e"


@pytest.mark.parametrize("reported", [None, 12.0])
def test_a_simulation_that_falls_silent_or_was_never_there_stops_no_one(reported: float | None) -> None:
    clock = PublishedClock(silence_s=0.01)
    if reported is not None:
        clock.advance(reported)
    clock.wait(Mailbox(), 0.05, paced=False)
    assert 0.05 <= clock.now() < 30


def test_what_a_silence_was_filled_with_is_not_counted_twice() -> None:
    clock = PublishedClock(silence_s=0.0)
    clock.advance(3.0)
    clock.wait(Mailbox(), 0.02, paced=False)
    before = clock.now()
    clock.advance(3.01)
    assert before <= clock.now() < before + 10
    assert clock.now() < 30

# SPDX-License-Identifier: Apache-2.0
"""A reading's date: by its own stamp on its sender's clock, wherever that clock and the run's began."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.stamps import dated, stamp_of

HUGE = [10**400, -(10**400), float("inf"), float("nan")]


@pytest.mark.parametrize(
    ("message", "stamp"),
    [
        ({"header": {"stamp": {"sec": 3, "nanosec": 500_000_000}}}, 3.5),
        ({"header": {"stamp": {"sec": -4, "nanosec": 500_000_000}}}, -3.5),
        ({"header": {"stamp": 4}}, 4.0),
        ({"stamp": 4.0}, 4.0),
        ({"stamp": -4.0}, -4.0),
        ({"header": {"frame_id": "map"}, "stamp": 4.0}, 4.0),
        ({"header": {"stamp": {"sec": 0, "nanosec": 0}}}, None),
        ({"header": {"stamp": {"sec": 0, "nanosec": 0}}, "stamp": 4.0}, None),
        ({"stamp": 0}, None),
        ({"stamp": True}, None),
        ({"stamp": "now"}, None),
        ({"stamp": {"sec": "x"}}, None),
        ({"header": "none"}, None),
        *(({"stamp": stamp}, None) for huge in HUGE for stamp in (huge, {"sec": huge})),
        ({}, None),
    ],
)
def test_a_stamp_is_a_time_of_the_header_or_of_the_message(message: dict[str, Any], stamp: float | None) -> None:
    assert stamp_of(message) == stamp


nanoseconds = st.integers(-(2**31) * 10**9, 2**31 * 10**9)
anywhere = st.floats(-1e9, 1e9) | st.just(0.0)


@given(nanoseconds, anywhere, anywhere)
def test_an_age_counts_from_the_stamp_on_its_senders_clock(time: int, now: float, sender_now: float) -> None:
    stamp = stamp_of({"header": {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}}})
    at, age_s = dated(stamp, now=now, sender_now=sender_now)
    if time == 0:
        assert (at, age_s) == (now, None), "unstamped: the receipt counts"
        return
    exact = Fraction(sender_now) - Fraction(time, 10**9)
    assert age_s == pytest.approx(float(exact), abs=1e-6)
    assert at <= now, "nothing is from the future"
    assert now - at == pytest.approx(max(0.0, float(exact)), abs=1e-6)

# SPDX-License-Identifier: Apache-2.0
"""When a reading was so: its own stamp, read on its sender's clock, as an instant of the run's clock.

Rule: every connector dates what it receives here, so a stamp means the same whichever way it came.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.plain_data import is_numeric
from rai_missions.redaction import cut_repr

__all__ = ("ReadingDate", "dated", "stamp_of")


class ReadingDate(NamedTuple):
    """When a reading was so, by the clock of the run and by that of its sender."""

    at: float
    """Seconds on the run's clock from which its age counts: negative before the run began, never after the receipt."""
    age_s: float | None
    """Receipt minus stamp, seconds on the sender's clock; negative for a stamp in the future, None without a stamp."""


def stamp_of(message: Mapping[str, Any]) -> float | None:
    """Seconds in a message's `header.stamp` or `stamp`: a builtin_interfaces/msg/Time or a number; None without one.

    A stamp of zero means, as in ROS, that its sender has not filled it in; so does one that is no finite number.
    """
    header = message.get("header")
    stamp = header.get("stamp") if header is not None and isinstance(header, Mapping) else None
    stamp = message.get("stamp") if stamp is None else stamp
    if stamp is None:
        return None
    try:
        if isinstance(stamp, Mapping):
            seconds = (_whole(stamp.get("sec", 0)) * 10**9 + _whole(stamp.get("nanosec", 0))) / 1e9
        else:
            seconds = float(stamp) if is_numeric(stamp) else 0.0
    except (OverflowError, ValueError):
        return None
    return seconds if seconds and math.isfinite(seconds) else None


def dated(stamp: float | None, *, now: float, sender_now: float) -> ReadingDate:
    """Date a reading that is received now.

    Args:
        stamp: Its own, seconds on its sender's clock; None for a reading without one.
        now: The receipt, seconds on the run's clock.
        sender_now: The receipt on the clock that stamps are of: ROS time, the time of day, or the run's own.
    """
    if stamp is None:
        return ReadingDate(now, None)
    return ReadingDate(min(now, stamp + (now - sender_now)), sender_now - stamp)


def _whole(number: Any) -> int:
    if not is_numeric(number):
        raise ValueError(f"{cut_repr(number, 60)} is no number")
    return int(number)

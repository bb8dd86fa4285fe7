# SPDX-License-Identifier: Apache-2.0
"""What became of each source's readings: how far its clock is off, and what it sent that could not be used.

Rule: nothing is corrected here. A reading keeps its stamp; that a source's stamps are off is reported with its value.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

from rai_missions.keys import Key
from rai_missions.redaction import cut

__all__ = ("Readings", "SourceState", "named_sources", "offset_words", "refused")

RECENT = 20
"""Readings of a source by which its offset is known."""
LEAST = 3
OFF_S = 0.2
"""A source whose stamps are off by more, in either direction, is reported."""


class SourceState(NamedTuple):
    """What is known of the readings of one source."""

    received: int = 0
    """Readings until now, whether or not they could be used."""
    offset_s: float | None = None
    """Its smallest receipt minus stamp, seconds, where that is above 0.2 either way; negative: its stamps are ahead."""
    age_s: float | None = None
    """How old its last usable reading was at its receipt, seconds."""
    misread: str = ""
    """What could not be understood in its last reading, with the value; empty where it was understood."""
    name: str = ""
    """The topic or service that it is; empty where that is not known."""


class Readings:
    """The readings of one source, one after the other."""

    def __init__(self) -> None:
        self._differences: deque[float] = deque(maxlen=RECENT)
        self._received, self._is_off = 0, False
        self._age_s: float | None = None
        self._misread = ""

    def receive(self, age_s: float | None, *, kept: bool) -> bool:
        """A reading has come.

        Args:
            age_s: Receipt minus its own stamp, seconds; None for one without a stamp.
            kept: It was published before this process listened, and proves nothing of its sender's clock.

        Returns:
            Whether the source's stamps are off, for the first time.
        """
        self._received += 1
        if age_s is not None and math.isfinite(age_s) and not kept:
            self._differences.append(age_s)
        is_first = not self._is_off and self.offset_s is not None
        self._is_off = self._is_off or is_first
        return is_first

    def understood(self, age_s: float) -> None:
        """The last reading could be used; it was this old at its receipt."""
        self._age_s, self._misread = age_s, ""

    def misread(self, why: str) -> None:
        """The last reading could not be understood."""
        self._misread = why

    @property
    def offset_s(self) -> float | None:
        """As in `SourceState`."""
        if len(self._differences) < LEAST:
            return None
        smallest = min(self._differences)
        return smallest if abs(smallest) > OFF_S else None

    @property
    def state(self) -> SourceState:
        return SourceState(self._received, self.offset_s, self._age_s, self._misread)


def offset_words(offset_s: float) -> str:
    """`its stamps are 2.0 s behind`."""
    return f"its stamps are {abs(offset_s):.1f} s {'behind' if offset_s > 0 else 'ahead'}"


def named_sources(states: Mapping[str, SourceState]) -> str:
    """`battery (/rover/power), pose`: keys, each with its topic or service where that has another name."""
    names = {key: "" if state.name.rpartition("/")[2] == key else state.name for key, state in states.items()}
    return ", ".join(f"{key} ({source})" if source else key for key, source in names.items())


def refused(missed: Mapping[str, SourceState], keys: Mapping[str, Key], ready_s: float) -> str:
    """Why a start is refused, in a sentence for each kind of reason.

    Args:
        missed: What the start has waited for in vain, with what is known of its source.
        keys: The mission's.
        ready_s: How long it has waited.
    """
    silent = {name: state for name, state in missed.items() if not state.received}
    named = named_sources(silent)
    sentences = [f"the robot has not reported within {ready_s:g} s: {named}; is it running?"] if silent else []
    if any(name in keys for name in silent):
        sentences.append('A key that the start need not wait for is "optional".')
    for name, state in missed.items():
        off = f"; {offset_words(state.offset_s)}" if state.offset_s is not None else ""
        if state.misread:
            sentences.append(f"{name} was received and not understood: {cut(state.misread, 300)}{off}.")
        elif state.received:
            most = keys[name].max_age_s if name in keys else None
            old = (
                f"{state.age_s or 0.0:.1f} s old, and may be {most:g} s (max_age_s)" if most is not None else "not used"
            )
            sentences.append(f"{name} was received, but {old}{off}.")
    return " ".join(sentences)

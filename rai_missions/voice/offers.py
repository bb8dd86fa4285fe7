# SPDX-License-Identifier: Apache-2.0
"""Which offer of a turn a recogniser transcribes next; pure.

Rule: one at a time, in order, and none that is void before it begins: a person who pauses often holds up no one. One
whose recogniser ended is transcribed once more.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

__all__ = ("OfferQueue", "TurnOffer")


class TurnOffer(NamedTuple):
    """A turn that is to be transcribed."""

    number: int
    offer: int


class OfferQueue:
    """The offers that wait for one recogniser; not for several threads."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[TurnOffer, bytes]] = deque()
        self._taken: tuple[TurnOffer, bytes] | None = None
        self._last: TurnOffer | None = None
        """The offer that is not transcribed again: it has been already, or is void."""

    def add(self, offer: TurnOffer, sound: bytes) -> None:
        """An offer is to be transcribed."""
        self._waiting.append((offer, sound))

    def void(self, offer: TurnOffer) -> int:
        """An offer counts no more; how many that waited are left out."""
        if self._taken is not None and self._taken[0] == offer:
            self._last = offer
        before = len(self._waiting)
        self._waiting = deque(each for each in self._waiting if each[0] != offer)
        return before - len(self._waiting)

    def take(self) -> tuple[TurnOffer, bytes] | None:
        """What is to be transcribed now, with its sound; None where the recogniser is busy, or nothing waits."""
        if self._taken is not None or not self._waiting:
            return None
        self._taken = self._waiting.popleft()
        return self._taken

    def again(self) -> bool:
        """What was taken is lost with its recogniser; whether it waits again, as the first: once, unless it is void."""
        taken = self._taken
        if taken is None or taken[0] == self._last:
            return False
        self._taken, self._last = None, taken[0]
        self._waiting.appendleft(taken)
        return True

    def done(self) -> None:
        """What was taken is transcribed, or has failed."""
        self._taken = None

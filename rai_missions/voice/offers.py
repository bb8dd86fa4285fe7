# SPDX-License-Identifier: Apache-2.0
"""Which offer of a turn a recogniser transcribes next; pure.

Rule: one at a time, in order, and none that is void before it begins: a person who pauses often holds up no one.
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
        self._is_busy = False

    def add(self, offer: TurnOffer, sound: bytes) -> None:
        """An offer is to be transcribed."""
        self._waiting.append((offer, sound))

    def void(self, offer: TurnOffer) -> int:
        """An offer counts no more; how many that waited are left out."""
        before = len(self._waiting)
        self._waiting = deque(each for each in self._waiting if each[0] != offer)
        return before - len(self._waiting)

    def take(self) -> tuple[TurnOffer, bytes] | None:
        """What is to be transcribed now, with its sound; None where the recogniser is busy, or nothing waits."""
        if self._is_busy or not self._waiting:
            return None
        self._is_busy = True
        return self._waiting.popleft()

    def done(self) -> None:
        """What was taken is transcribed, or has failed."""
        self._is_busy = False

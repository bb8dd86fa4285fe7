# SPDX-License-Identifier: Apache-2.0
"""Whether the echo that a filter predicts is the one that returns: a room that was known may have changed.

Rule: a person's speech has nothing in common with what is predicted, so by itself it makes no prediction wrong. Nor
does a filter's own error, which is the whole prediction where the first echo of a report has not come yet.
"""

from __future__ import annotations

from typing import Any

from rai_missions.connectors.sound.connector import FRAME_SAMPLES
from rai_missions.connectors.sound.wav import numpy

__all__ = ("EchoMatch",)

MEMORY = 0.8
"""How much of what is compared is known from the frames before: five frames, 0.16 s."""
RIGHT, WRONG = 0.3, 0.6
"""By what share of itself a prediction may be off; from which share on it is wrong."""
LEAST_SURE = 30.0
"""One over the variance of that share, from which on it counts."""
LEAST_PREDICTED, LEAST_LEFT = 1e3, 2e3
"""Energy of a sample, of 32768 squared, that is predicted at least; that any frequency has at least of what is left."""
CHANGED_FRAMES = 5
"""Frames with a wrong prediction, one after the other, after which a known room is another one: 0.16 s."""
KNOWN_FRAMES = 26
"""Frames with a right prediction after which a room is known: 0.8 s of echo."""


class EchoMatch:
    """Compares each frame's prediction with what it leaves.

    What is left of a right prediction has nothing in common with it. Where the room is another one, the prediction
    itself is left, with the other sign. The share is a mean over all frequencies; those at which a person speaks or
    the room is noisy weigh less.
    """

    def __init__(self) -> None:
        self._np = np = numpy()
        self._common, self._predicted, self._left = (np.zeros(FRAME_SAMPLES + 1) for _ in range(3))
        self._doubt = 0.0
        self._known = self._wrong = 0
        self._share, self._is_sure = 0.0, False

    @property
    def is_wrong(self) -> bool:
        """Whether the prediction is wrong now, also because the room is not known yet; its own error is none."""
        return self._is_sure and abs(self._share) > WRONG and float(self._np.sum(self._predicted)) > self._doubt

    @property
    def is_changed(self) -> bool:
        """Whether a room that was known is another one now."""
        return self.is_known and self._wrong >= CHANGED_FRAMES

    @property
    def is_known(self) -> bool:
        """Whether the prediction was right for long enough."""
        return self._known >= KNOWN_FRAMES

    def take(self, echo: Any, rest: Any, doubt: Any) -> None:
        """The next frame.

        Args:
            echo: The spectrum of what was predicted.
            rest: That of what was recorded without it.
            doubt: The variance of the prediction, by the filter's own account.
        """
        np, new = self._np, 1.0 / FRAME_SAMPLES
        self._common = MEMORY * self._common + new * (rest * np.conj(echo)).real
        self._predicted = MEMORY * self._predicted + new * np.abs(echo) ** 2
        self._left = MEMORY * self._left + new * np.abs(rest) ** 2
        self._doubt = MEMORY * self._doubt + new * float(np.sum(doubt))
        weight = 1.0 / (self._left + LEAST_LEFT / (1.0 - MEMORY))
        size = float(np.sum(weight * self._predicted))
        self._share = float(np.sum(weight * self._common)) / max(size, 1e-9)
        level = (1.0 - MEMORY) * float(np.sum(self._predicted)) / FRAME_SAMPLES
        self._is_sure = level > LEAST_PREDICTED and size / (2 * (1.0 - MEMORY)) > LEAST_SURE
        self._known += self._is_sure and abs(self._share) < RIGHT
        self._wrong = self._wrong + 1 if self.is_wrong else 0

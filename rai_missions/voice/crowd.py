# SPDX-License-Identifier: Apache-2.0
"""A room full of people, and the one in it who is louder than they are; pure.

Rule: where no speech lasts, nothing is changed.
"""

from __future__ import annotations

from collections import deque

__all__ = ("CROWD_FRAMES", "FALLEN_FRAMES", "LOUDER_DB", "SPEECH", "Crowd")

SPEECH = 0.5
"""Probability of speech from which on a person may speak."""
CROWD_FRAMES, MOST_RANGE_DB = 94, 8.0
"""Speech that lasts for 3 s at one level is that of many: within so many dB, but for a tenth at either end. One person
has more than 10, also in loud noise."""
LOUDER_DB = 6.0
"""By how much a person must be louder than the crowd."""
HELD_FRAMES = 4
"""For how long they are taken to speak on: 0.13 s, for the quiet sounds of a word."""
FALLEN_DB, FALLEN_FRAMES = 8.0, 6
"""The crowd is gone that has been so much quieter, or no speech, for 0.2 s."""


class Crowd:
    """How loud a crowd is, frame by frame, and what of the speech is a person's who is louder."""

    def __init__(self) -> None:
        self._levels: deque[float] = deque(maxlen=CROWD_FRAMES)
        self._level: float | None = None
        """How loud the crowd is, in dB; None where there is none."""
        self._fallen = self._held = 0

    def take(self, speech: float, level: float) -> float:
        """How probable the speech of a person is who is no part of a crowd.

        Args:
            speech: How probable any speech is in the next frame.
            level: The frame's mean energy in dB, of any reference.
        """
        is_speech = speech >= SPEECH
        self._follow(level, is_speech=is_speech)
        if self._level is None:
            return speech
        self._held = HELD_FRAMES if level > self._level + LOUDER_DB else max(0, self._held - 1)
        return speech if self._held else 0.0

    def _follow(self, level: float, *, is_speech: bool) -> None:
        """A crowd begins, becomes louder or quieter, or is gone."""
        is_fallen = not is_speech or (self._level is not None and level < self._level - FALLEN_DB)
        self._fallen = self._fallen + 1 if is_fallen else 0
        if self._fallen >= FALLEN_FRAMES:
            self._level = None
            self._levels.clear()
            return
        self._levels.append(level)
        if len(self._levels) == CROWD_FRAMES and is_speech:
            low, middle, high = (sorted(self._levels)[tenth * CROWD_FRAMES // 10] for tenth in (1, 5, 9))
            if high - low < MOST_RANGE_DB:
                self._level = middle

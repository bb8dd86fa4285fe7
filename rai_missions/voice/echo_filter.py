# SPDX-License-Identifier: Apache-2.0
"""The linear part of the echo, learned frame by frame and subtracted.

Rule: it takes away nothing but what it predicts from what was played. So a person's speech stays whole.

Source: G. Enzner and P. Vary, "Frequency-domain adaptive Kalman filter for acoustic echo control in hands-free
telephones", Signal Processing 86, 2006; in partitions: F. Kuech, E. Mabande and G. Enzner, "State-space architecture of
the partitioned-block-based acoustic echo controller", ICASSP 2014.
"""

from __future__ import annotations

from typing import Any

from rai_missions.connectors.sound.connector import FRAME_SAMPLES
from rai_missions.connectors.sound.wav import numpy
from rai_missions.voice.echo_match import EchoMatch

__all__ = ("EchoFilter",)

PARTS = 16
"""The parts of the filter, a frame each: 0.5 s, the longest delay with its reflections."""
PERSISTENCE = 0.999
"""How much of the room stays the same from one frame to the next."""
NOISE_MEMORY = 0.9
"""How much of what the filter does not predict is known from the frames before."""
LEAST_NOISE_SHARE = 0.1
"""The least share of what is left that counts as not predicted by the filter."""
LEAST_POWER = 1e3
"""The least power of a frequency in a frame, of amplitudes to 32768: so that silence divides by no 0."""


class EchoFilter:
    """Predicts the echo from what was played, and learns the room from what is left.

    How far it learns from a frame depends on how sure it is of the room, and on how much else is recorded: it learns
    little while a person speaks.
    """

    def __init__(self) -> None:
        self._np = np = numpy()
        self._played, self._last = np.zeros((PARTS, FRAME_SAMPLES + 1), complex), np.zeros(FRAME_SAMPLES)
        self.forget()

    def forget(self) -> None:
        """The room is another one: it is learned from the next frame on."""
        np, size = self._np, FRAME_SAMPLES + 1
        self._filter = np.zeros((PARTS, size), complex)
        self._doubt = np.full((PARTS, size), 1.0 / PARTS)
        """The variance of the filter: a room that is not known returns at most what was played."""
        self._noise = np.zeros(size)
        self.match = EchoMatch()
        """Whether what is predicted is the echo that returns."""

    def take(self, recorded: bytes, played: bytes) -> bytes:
        """The next frame without the echo that is predicted."""
        np = self._np
        far = np.frombuffer(played, "<i2").astype(float)
        self._played = np.roll(self._played, 1, axis=0)
        self._played[0] = np.fft.rfft(np.concatenate([self._last, far]))
        self._last = far
        echo = np.fft.irfft((self._filter * self._played).sum(axis=0))[FRAME_SAMPLES:]
        rest = np.frombuffer(recorded, "<i2") - echo
        before = np.zeros(FRAME_SAMPLES)
        left = np.fft.rfft(np.concatenate([before, rest]))
        power = np.abs(self._played) ** 2
        doubt = 0.5 * (power * self._doubt).sum(axis=0)
        self._learn(left, power, doubt)
        self.match.take(np.fft.rfft(np.concatenate([before, echo])), left, doubt)
        return bytes(np.clip(np.rint(rest), -32768, 32767).astype("<i2").tobytes())

    def _learn(self, rest: Any, power: Any, doubt: Any) -> None:
        """Change the filter by what is left of a frame, and how sure it is; `doubt` is the variance of its echo."""
        np = self._np
        left = np.abs(rest) ** 2
        other = np.maximum(left - doubt, LEAST_NOISE_SHARE * left)
        self._noise = NOISE_MEMORY * self._noise + (1 - NOISE_MEMORY) * other
        step = self._doubt / (2 * (doubt + self._noise) + LEAST_POWER)
        change = np.fft.irfft(step * np.conj(self._played) * rest, axis=1)
        change[:, FRAME_SAMPLES:] = 0.0
        self._filter = PERSISTENCE * (self._filter + np.fft.rfft(change, axis=1))
        known = PERSISTENCE**2 * (1 - 0.5 * step * power) * self._doubt
        self._doubt = known + (1 - PERSISTENCE**2) * np.abs(self._filter) ** 2

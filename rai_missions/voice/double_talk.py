# SPDX-License-Identifier: Apache-2.0
"""Whether a person speaks while we do: by what is louder than our echo can be, as it was recorded or filtered.

Rule: it only finds what is certain. What it does not find, the echo canceller still may.
"""

from __future__ import annotations

from collections import deque
from typing import Any

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from rai_missions.connectors.sound.wav import numpy

__all__ = ("KNOWN_FRAMES", "DoubleTalk")

FRAME_SAMPLES = FRAME_BYTES // 2
EDGES_HZ = (0, 400, 1000, 2000, 4000)
"""Where the bands begin; the last one ends at 8 kHz."""
KNOWN_FRAMES, PLAYED_FRAMES, ECHO_FRAMES = 26, 8, 19
"""0.8 s of a report, after which the echo of its first 0.26 s has returned; 0.6 s, within which one is looked for. The
delay is below 0.5 s: one that is longer the canceller does not know either."""
MEMORY_FRAMES, HELD_FRAMES = 62, 8
"""For how long a bound holds, 2 s, and how long a person is taken to speak on, 0.26 s."""
MARGIN = 10**1.2
"""By how much a band must be above the bound, as energies: 12 dB."""
LEAST = 100.0**2
"""Energy of a sample, of 32768 squared, below which a band shows nothing, whether it is played or recorded."""


class DoubleTalk:
    """Compares frames with the echo that there can be, band by band.

    0.8 s of what was recorded have the whole echo of what was played in their first 0.26 s. So the echo's share is at
    most the one's energy over the other's, also while a person speaks; the least of two seconds is a bound.
    """

    def __init__(self) -> None:
        self._np = numpy()
        self._bands = [BandEnergies() for _ in range(3)]
        self._recorded, self._filtered, self._played = (
            deque([each.take(bytes(FRAME_BYTES))] * KNOWN_FRAMES, KNOWN_FRAMES) for each in self._bands
        )
        self._shares, self._filtered_shares = (deque[Any](maxlen=MEMORY_FRAMES) for _ in range(2))
        self._held = 0

    def take(self, recorded: bytes, filtered: bytes, played: bytes) -> bool:
        """Whether the next frame has a person's speech for certain, or follows one that has.

        Args:
            recorded: The frame.
            filtered: The same without the echo that a filter predicts.
            played: What was played meanwhile.
        """
        np = self._np
        for found, bands, sound in zip(
            (self._recorded, self._filtered, self._played), self._bands, (recorded, filtered, played), strict=True
        ):
            found.append(bands.take(sound))
        self._shares.append(self._most_share(self._recorded))
        self._filtered_shares.append(self._most_share(self._filtered))
        loudest = np.max(list(self._played)[-ECHO_FRAMES:], axis=0)
        echo, left = (np.min(each, axis=0) * loudest for each in (self._shares, self._filtered_shares))
        now, rest = self._recorded[-1], self._filtered[-1]
        is_louder = now > np.maximum(MARGIN * echo, LEAST)
        is_left = rest > np.maximum(np.maximum(MARGIN * left, echo), LEAST)
        is_certain = np.any(is_louder) or (np.any(is_left) and np.sum(rest) < np.sum(now))
        self._held = HELD_FRAMES + 1 if is_certain else max(0, self._held - 1)
        return self._held > 0

    def _most_share(self, found: deque[Any]) -> Any:
        """What share of what was played may be found again, for each band; infinity if too little was played."""
        np = self._np
        played = np.sum(list(self._played)[:PLAYED_FRAMES], axis=0)
        return np.where(played > LEAST * PLAYED_FRAMES, np.sum(found, axis=0) / played, np.inf)


class BandEnergies:
    """The energies of a stream's bands, over each frame and the one before it.

    They overlap, with the window of a sine, so that each sample counts as much. At the edge of a window that is not
    smooth a low vowel has the energies of all bands, at other edges in what is played than in its echo.
    """

    def __init__(self) -> None:
        self._np = np = numpy()
        count = 2 * FRAME_SAMPLES
        self._starts = [each * count // RATE_HZ for each in EDGES_HZ]
        self._window = np.sin(np.pi * (np.arange(count) + 0.5) / count)
        self._last = np.zeros(FRAME_SAMPLES)

    def take(self, samples: bytes) -> Any:
        """The mean energy of the samples in each band, of the next frame; never 0."""
        np = self._np
        now = np.frombuffer(samples, "<i2")
        spectrum = np.fft.rfft(self._window * np.concatenate([self._last, now]))
        self._last = now
        return 1.0 + np.add.reduceat(np.abs(spectrum) ** 2, self._starts) / FRAME_SAMPLES**2

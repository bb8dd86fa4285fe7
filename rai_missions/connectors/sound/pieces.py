# SPDX-License-Identifier: Apache-2.0
"""Sound that comes in pieces of any length, as over a network: frames at the pace of what is received.

Rule: its clock is that of the sound. A frame that no piece brought does not pass.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, RATE_HZ, FrameLoop, SoundFrame
from rai_missions.connectors.worker import Worker

__all__ = ("PieceSound",)

WAITING = 4
BETWEEN = bytes(2 * RATE_HZ)
"""A second of silence, which passes behind the sound of each source: a turn ends in it."""
MOST_SOURCES = 100
"""How many changes of the source are remembered."""


class PieceSound(FrameLoop):
    """A microphone whose sound is given to `take`.

    Args:
        now: Seconds on a clock that does not go back; the first frame begins then.
        waiting: Pieces that may wait; the newest are kept.
    """

    def __init__(self, *, now: Callable[[], float] = time.monotonic, waiting: int = WAITING) -> None:
        super().__init__()
        self._now, self._most = now, waiting
        self._lock = threading.Lock()
        self._worker: Worker | None = None
        self._held = bytearray()
        self._at = 0.0
        self._sources: deque[tuple[float, object]] = deque(maxlen=MOST_SOURCES)
        """From which instant on the sound is whose."""

    @property
    def running(self) -> bool:
        return self._worker is not None

    def start(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            if self._worker is not None:
                return
            self._held.clear()
            self._at = max(self._at, self._now())
            self._worker = Worker("sound in pieces", limit=self._most, keep="newest")

    def stop(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            worker, self._worker = self._worker, None
        if worker is not None:
            worker.close(2.0)

    def take(self, sound: bytes, source: object = None) -> None:
        """The next piece, 16 kHz, mono, 16 bits; returns at once.

        Args:
            sound: The piece.
            source: Whose it is, None: no one's. Behind what is someone's comes silence.
        """
        worker = self._worker
        if worker is not None:
            worker.post(lambda: self._pass(sound, source))

    def source_of(self, at: float) -> object:
        """Whose sound had passed last at an instant on the clock of the sound; None where that is not known."""
        with self._lock:
            return next((source for since, source in reversed(self._sources) if since < at), None)

    def _pass(self, sound: bytes, source: object) -> None:
        """On the worker's thread: as many frames as are whole."""
        before = self._sources[-1][1] if self._sources else None
        if source is not before:
            if before is not None:
                self._give_whole(BETWEEN)
            with self._lock:
                self._sources.append((self._at, source))
        self._give_whole(sound)

    def _give_whole(self, sound: bytes) -> None:
        self._held += sound
        while len(self._held) >= FRAME_BYTES and self._worker is not None:
            recorded = bytes(self._held[:FRAME_BYTES])
            del self._held[:FRAME_BYTES]
            played = self.played(self._at)
            self._passed(played)
            self.give(SoundFrame(self._at, recorded, played))
            self._at += FRAME_S

    def _passed(self, played: bytes) -> None:
        """A frame passes; here nothing that is played goes anywhere."""

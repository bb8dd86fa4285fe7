# SPDX-License-Identifier: Apache-2.0
"""Sound that comes in pieces of any length, as over a network: frames at the pace of what is received.

Rule: its clock is that of the sound. A frame that no piece brought does not pass.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, FrameLoop, SoundFrame
from rai_missions.connectors.worker import Worker

__all__ = ("PieceSound",)

WAITING = 4


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

    def take(self, sound: bytes) -> None:
        """The next piece, 16 kHz, mono, 16 bits; returns at once."""
        worker = self._worker
        if worker is not None:
            worker.post(lambda: self._pass(sound))

    def _pass(self, sound: bytes) -> None:
        """On the worker's thread: as many frames as are whole."""
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

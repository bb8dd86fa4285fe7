# SPDX-License-Identifier: Apache-2.0
"""Sound from a file and into a file, on a clock that is stepped, or at the pace of the wall."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SILENCE, FrameLoop, SoundFrame
from rai_missions.connectors.sound.wav import read_wav, write_wav
from rai_missions.connectors.worker import Worker

__all__ = ("FileSound",)

LONGEST_PLAYED_S = 3600.0


class FileSound(FrameLoop):
    """A microphone that is a recording, and a speaker that is one.

    It is what a simulated clock steps: `period_s`, `at`, `step`.

    Args:
        recorded: What the microphone picks up: 16 kHz samples, or a WAV file; silence after its end.
        played: A WAV file that is written with what was played, by `stop`.
        paced: Frames come at the pace of the wall, on a thread; otherwise each `step` is one.
    """

    period_s = FRAME_S

    def __init__(
        self, recorded: bytes | Path | str = b"", played: Path | str | None = None, *, paced: bool = False
    ) -> None:
        super().__init__()
        self._recorded = recorded if isinstance(recorded, bytes) else read_wav(recorded)
        self._written, self._paced = played, paced
        self._out = bytearray()
        self._count = 0
        self._running = False
        self._lock = threading.Lock()
        self._pace: Worker | None = None
        self._due = 0.0

    @property
    def running(self) -> bool:
        return self._running

    @property
    def at(self) -> float:
        """Seconds of sound that have passed."""
        return self._count * FRAME_S

    @property
    def over(self) -> bool:
        """Whether the recording has ended."""
        return self._count * FRAME_BYTES >= len(self._recorded)

    def start(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            if self._running:
                return
            self._running = True
            if self._paced:
                self._due = time.monotonic()
                self._pace = Worker("sound of a file")
                self._next()

    def stop(self) -> None:
        """See `SoundConnector`; what was played is written."""
        with self._lock:
            was_running, self._running = self._running, False
            pace, self._pace = self._pace, None
        if pace is not None:
            pace.close(2.0)
        if was_running and self._written is not None:
            write_wav(self._written, bytes(self._out))

    def step(self) -> None:
        """The next 32 ms pass; stopped, only time does."""
        at, start = self.at, self._count * FRAME_BYTES
        self._count += 1
        if not self._running:
            return
        played = self.played(at)
        if self._written is not None and len(self._out) < LONGEST_PLAYED_S / FRAME_S * FRAME_BYTES:
            self._out += played
        recorded = self.recorded_at(start, played)
        self.give(SoundFrame(at, recorded, played))

    def recorded_at(self, start: int, played: bytes) -> bytes:
        """What the microphone picks up.

        Args:
            start: Where the frame begins, in bytes from the start of the recording.
            played: What the speaker plays meanwhile.
        """
        return self._recorded[start : start + FRAME_BYTES].ljust(FRAME_BYTES, b"\0") if self._recorded else SILENCE

    def _next(self) -> None:
        pace = self._pace
        if pace is None:
            return
        self._due += FRAME_S
        pace.after(max(0.0, self._due - time.monotonic()), self._paced_step)

    def _paced_step(self) -> None:
        try:
            self.step()
        finally:
            self._next()  # whatever a listener raises, time passes

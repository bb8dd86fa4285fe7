# SPDX-License-Identifier: Apache-2.0
"""A simulated room: what the speaker plays returns to the microphone, later and quieter, with a person and noise."""

from __future__ import annotations

from pathlib import Path

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from rai_missions.connectors.sound.files import FileSound
from rai_missions.connectors.sound.wav import numpy

__all__ = ("RoomSound",)


class RoomSound(FileSound):
    """A recording of a person, in a room in which the robot's own voice echoes.

    Args:
        person: What a person speaks: 16 kHz samples, or a WAV file.
        echo_db: How much quieter than it was played the echo returns; None for no echo.
        delay_ms: After which time it returns.
        tail: The room's own answer, as amplitudes at 16 kHz after the direct echo; empty for none.
        noise: Amplitude of white noise, one standard deviation, of 32768.
        seed: The seed of the noise.
        paced: As for `FileSound`.
    """

    def __init__(
        self,
        person: bytes | Path | str = b"",
        *,
        echo_db: float | None = -12.0,
        delay_ms: float = 60.0,
        tail: tuple[float, ...] = (),
        noise: float = 10.0,
        seed: int = 0,
        paced: bool = False,
    ) -> None:
        super().__init__(person, paced=paced)
        np = numpy()
        self._np, self._noise, self._random = np, noise, np.random.default_rng(seed)
        delay = int(delay_ms * RATE_HZ / 1000)
        self._answer = np.zeros(delay + 1 + len(tail), np.float32)
        if echo_db is not None:
            self._answer[delay:] = np.array((1.0, *tail), np.float32) * 10 ** (echo_db / 20)
        self._past = np.zeros(len(self._answer) - 1, np.float32)

    def person_speaks(self, samples: bytes) -> None:
        """A person begins to speak with the next frame, instead of what the recording has there."""
        start = self._count * FRAME_BYTES
        self._recorded = self._recorded[:start].ljust(start, b"\0") + samples

    def recorded_at(self, start: int, played: bytes) -> bytes:
        """The person, the echo and the noise."""
        np = self._np
        sound = np.frombuffer(super().recorded_at(start, played), "<i2").astype(np.float32)
        far = np.concatenate([self._past, np.frombuffer(played, "<i2").astype(np.float32)])
        self._past = far[len(far) - len(self._past) :]
        sound = sound + np.convolve(far, self._answer, "valid")
        sound += self._random.normal(0.0, self._noise, len(sound)) if self._noise else 0.0
        return bytes(np.clip(np.rint(sound), -32768, 32767).astype("<i2").tobytes())

# SPDX-License-Identifier: Apache-2.0
"""A microphone and a speaker of this machine, by PortAudio: the only door to `sounddevice`.

Rule: the callback of the device copies a frame each way and returns; nothing is worked out on its thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

from rai_missions.connectors.sound.connector import FRAME_S, FRAME_SAMPLES, RATE_HZ, SILENCE, FrameLoop, SoundFrame
from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut, logger

__all__ = ("DeviceSound", "sound_devices")

log = logger(__name__)
WAITING = 100
"""Frames that may wait for those who listen, 3 s; then the oldest is dropped."""
REMEDY = "pip install '.[voice]'; on Debian also: apt-get install libportaudio2"


class DeviceSound(FrameLoop):
    """The sound devices of this machine.

    Args:
        microphone: Its name or number, as `rai-missions doctor --voice` lists them; the default one if left out.
        speaker: The same of the speaker.
        now: The clock that stamps frames; that of the wall by default.
    """

    def __init__(
        self, microphone: str | int | None = None, speaker: str | int | None = None, *,
        now: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        super().__init__()
        self._devices, self._now = (microphone, speaker), now
        self._stream: Any = None
        self._frames: Worker | None = None
        self._next = SILENCE

    @property
    def running(self) -> bool:
        return self._stream is not None

    def start(self) -> None:
        """See `SoundConnector`."""
        if self._stream is not None:
            return
        library = _library()
        self._frames = Worker("sound frames", limit=WAITING, keep="newest")
        self._next = SILENCE
        try:
            stream = library.RawStream(
                samplerate=RATE_HZ, blocksize=FRAME_SAMPLES, device=self._devices, channels=1, dtype="int16",
                latency="low", callback=self._exchange,
            )  # fmt: skip
            stream.start()
        except (library.PortAudioError, ValueError) as error:
            self._frames.close(0.0)
            given = " and ".join("the default" if each is None else repr(each) for each in self._devices)
            raise ConnectorError(
                f"no sound from {given} device at {RATE_HZ} Hz ({cut(error, 200)}); 'rai-missions doctor --voice' "
                "lists the devices"
            ) from None
        self._stream = stream

    def stop(self) -> None:
        """See `SoundConnector`."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.abort()
            stream.close()
        if self._frames is not None:
            self._frames.close(2.0)

    def _exchange(self, recorded: Any, out: Any, _count: int, _times: Any, status: Any) -> None:
        played, taken = self._next, bytes(recorded)
        out[:] = played
        frames, at = self._frames, self._now() - FRAME_S
        if status:
            log.debug("the sound device reports: %s", status)
        if frames is not None:
            frames.post(lambda: self._take(SoundFrame(at, taken, played)))

    def _take(self, frame: SoundFrame) -> None:
        self._next = self.played(frame.at + 2 * FRAME_S)
        self.give(frame)


def sound_devices() -> list[tuple[str, int, int]]:
    """The devices that there are: name, and how many channels go in and out.

    Raises:
        UsageError: The library is not installed.
        ConnectorError: It finds no sound system.
    """
    library = _library()
    try:
        return [
            (each["name"], each["max_input_channels"], each["max_output_channels"]) for each in library.query_devices()
        ]
    except library.PortAudioError as error:
        raise ConnectorError(f"PortAudio finds no sound system ({cut(error, 200)})") from None


def _library() -> ModuleType:
    try:
        import sounddevice
    except (ImportError, OSError) as error:
        raise UsageError(f"sound devices need sounddevice and PortAudio ({cut(error, 200)}); {REMEDY}") from None
    return sounddevice  # type: ignore[no-any-return]

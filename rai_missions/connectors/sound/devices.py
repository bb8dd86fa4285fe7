# SPDX-License-Identifier: Apache-2.0
"""A microphone and a speaker of this machine, by PortAudio: the only door to `sounddevice`.

Rule: the callback of the device copies a frame each way and returns; nothing is worked out on its thread. A sound
system calls it two or three times in a row: each frame of a source is played once, in order, however it calls.
PortAudio ends a stream that it cannot recover after an underrun: it is opened again.
"""

from __future__ import annotations

import atexit
import threading
import time
from array import array
from collections import deque
from types import ModuleType
from typing import Any, NamedTuple

from rai_missions.connectors.sound.connector import FRAME_S, FRAME_SAMPLES, RATE_HZ, SILENCE, FrameLoop, SoundFrame
from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError, UsageError, install_command
from rai_missions.redaction import cut, logger

__all__ = ("DeviceSound", "MicrophoneLevel", "microphone_level", "sound_devices")

log = logger(__name__)
WAITING = 100
"""Frames that may wait for those who listen, 3 s; then the oldest is dropped."""
AGAIN_S = 1.0
"""How long after a device could not be opened again it is tried once more."""
CLOSES_S = 5.0
"""How long a device may take to end."""
LOST_S = 2.0
"""After so long without a frame there is a fault."""
LOOKS_S = 5.0
"""How long a second of sound may take to come."""
DRAINS_S = 0.5
"""How long what waits to be played may take, where a device is stopped."""
AHEAD = 2
"""Frames of a source that wait to be played; where none waits, silence is played and the source continues after it."""
LATE_S, SHARE = 0.2, 0.05
"""A frame that comes so late has a gap before it; smaller lateness is the system's: a share of it counts."""
ON_DEBIAN = "on Debian also: apt-get install libportaudio2"


class DeviceSound(FrameLoop):
    """The sound devices of this machine.

    Args:
        microphone: Its name or number, as `rai-missions doctor --voice` lists them; the default one if left out.
        speaker: The same of the speaker.
    """

    def __init__(self, microphone: str | int | None = None, speaker: str | int | None = None) -> None:
        super().__init__()
        self._devices = microphone, speaker
        self._stream: Any = None
        self._is_wanted, self._lock = False, threading.Lock()
        self._frames: Worker | None = None
        self._ahead: deque[bytes] = deque()
        self._is_drained = threading.Event()
        """None of them waits, and silence has followed."""
        self._at, self._asked_at, self._came_at = 0.0, 0.0, 0.0
        self._why = self._known = ""
        """Why the device could not be opened again; the fault that was logged last."""

    @property
    def running(self) -> bool:
        return self._is_wanted

    @property
    def fault(self) -> str:
        """See `SoundConnector`; the device has ended, or its sound system hangs."""
        if not self._is_wanted or time.monotonic() - self._came_at < LOST_S:
            return ""
        return self._why or f"no sound has come from the device for more than {LOST_S:g} s"

    def start(self) -> None:
        """See `SoundConnector`."""
        if self._is_wanted:
            return
        self._frames = Worker("sound frames", limit=WAITING, keep="newest")
        self._ahead.clear()
        try:
            self._stream = self._opened(_library())
        except ConnectorError:
            self._frames.close(0.0)
            raise
        self._came_at, self._why, self._known, self._is_wanted = time.monotonic(), "", "", True
        self._frames.every(AGAIN_S, self._look)

    def _look(self) -> None:
        """Log a fault, and its end, once each."""
        before, self._known = self._known, self.fault
        if self._known and not before:
            log.warning("%s; it is tried again", self._known)
        elif before and not self._known:
            log.warning("sound comes from the device again")

    def stop(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            self._is_wanted = False
            stream, self._stream = self._stream, None
        if self._frames is not None:
            self._frames.post(lambda: self._finish(stream))
            if not self._frames.close(CLOSES_S):  # the sound system hangs, and would keep the program from its end
                log.warning("the sound device does not end within %g s, and is left", CLOSES_S)
                atexit.unregister(_library()._exit_handler)  # noqa: SLF001 - it waits for the same device, for ever

    def _finish(self, stream: Any) -> None:
        """Have what a source has given played to its end, on the worker's thread; then close the device."""
        self._is_drained.wait(DRAINS_S)
        if stream is not None:
            stream.stop(ignore_errors=True)
        _close(stream)

    def _opened(self, library: ModuleType) -> Any:
        try:
            stream = library.RawStream(
                samplerate=RATE_HZ,
                blocksize=FRAME_SAMPLES,
                device=self._devices,
                channels=1,
                dtype="int16",
                latency="low",
                callback=self._exchange,
                finished_callback=self._ended,
            )
            stream.start()
        except (library.PortAudioError, ValueError) as error:
            given = " and ".join("the default" if each is None else repr(each) for each in self._devices)
            raise ConnectorError(
                f"no sound from {given} device at {RATE_HZ} Hz ({cut(error, 200)}); 'rai-missions doctor --voice' "
                "lists the devices"
            ) from None
        return stream

    def _ended(self) -> None:
        """A stream has ended; on its own thread, which cannot close it."""
        frames = self._frames
        if self._is_wanted and frames is not None:
            frames.post(self._reopen)

    def _reopen(self) -> None:
        with self._lock:
            if not self._is_wanted:
                return
            stream, self._stream = self._stream, None
        _close(stream)
        try:
            stream = self._opened(_library())
        except ConnectorError as error:
            self._why = str(error)
        else:
            with self._lock:
                if self._is_wanted:
                    self._stream, stream = stream, None
            _close(stream)
            self._why = ""
            log.warning("the sound device ended, and was opened again")
            return
        if self._frames is not None:
            self._frames.after(AGAIN_S, self._reopen)

    def _exchange(self, recorded: Any, out: Any, _count: int, _times: Any, status: Any) -> None:
        played, taken = self._ahead.popleft() if self._ahead else b"", bytes(recorded)
        if not played:
            self._is_drained.set()
            played = SILENCE
        out[:] = played
        frames, at, self._came_at = self._frames, self._stamp(), time.monotonic()
        if status:
            log.debug("the sound device reports: %s", status)
        if frames is not None:
            frames.post(lambda: self._take(SoundFrame(at, taken, played)))

    def _take(self, frame: SoundFrame) -> None:
        while self._is_wanted and len(self._ahead) < AHEAD:
            self._asked_at = max(self._asked_at, frame.at + (len(self._ahead) + 1) * FRAME_S)
            self._is_drained.clear()
            self._ahead.append(self.played(self._asked_at))
        if self._is_wanted:
            self.give(frame)

    def _stamp(self) -> float:
        """When the frame began: a frame after the one before it, drawn to the wall's clock."""
        late = time.monotonic() - FRAME_S - (self._at + FRAME_S)
        self._at += FRAME_S + (late if late > LATE_S else max(SHARE * late, -FRAME_S / 2))
        return self._at


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


class MicrophoneLevel(NamedTuple):
    """What a microphone records."""

    samples: int
    loudest: int
    """The highest of them, of 32768."""
    clipped: int
    """How many of them are the loudest that there can be."""


def microphone_level(device: str | int | None = None) -> MicrophoneLevel:
    """Open a microphone and a speaker together, as a run does, for a second.

    Args:
        device: That is both; the default ones if left out.

    Raises:
        UsageError: The library is not installed.
        ConnectorError: They cannot be opened: there is none, another program has it, or its rate is another.
    """
    sound, found, done = DeviceSound(device, device), array("h"), threading.Event()

    def take(frame: SoundFrame) -> None:
        found.frombytes(frame.recorded)
        if len(found) >= RATE_HZ:
            done.set()

    sound.listen(take)
    sound.start()
    done.wait(LOOKS_S)
    sound.stop()
    return MicrophoneLevel(len(found), max(map(abs, found), default=0), sum(each in (-32768, 32767) for each in found))


def _close(stream: Any) -> None:
    if stream is not None:
        stream.abort(ignore_errors=True)
        stream.close(ignore_errors=True)


def _library() -> ModuleType:
    try:
        import sounddevice
    except (ImportError, OSError) as error:
        raise UsageError(
            f"sound devices need sounddevice and PortAudio ({cut(error, 200)}); {install_command('voice')}; {ON_DEBIAN}"
        ) from None
    return sounddevice  # type: ignore[no-any-return]

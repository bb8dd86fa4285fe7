# SPDX-License-Identifier: Apache-2.0
"""What a connector to sound does: at each instant it takes a frame to play and gives the frame that it recorded.

Rule: sound in this project is 16 kHz, mono, 16 bits, in frames of 32 ms; connectors convert at their door.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

from rai_missions.connectors.connector import Close
from rai_missions.errors import UsageError
from rai_missions.redaction import logger

__all__ = (
    "FRAME_BYTES", "FRAME_S", "FRAME_SAMPLES", "RATE_HZ", "SILENCE",
    "FrameLoop", "OnFrame", "SoundConnector", "SoundFrame", "SoundSource",
)  # fmt: skip

log = logger(__name__)

RATE_HZ, FRAME_SAMPLES = 16_000, 512
FRAME_BYTES = 2 * FRAME_SAMPLES
FRAME_S = FRAME_SAMPLES / RATE_HZ
SILENCE = bytes(FRAME_BYTES)


class SoundFrame(NamedTuple):
    """32 ms of sound: an event on the connector's clock."""

    at: float
    """Seconds on the clock at which the frame began."""
    recorded: bytes
    """What the microphone picked up."""
    played: bytes
    """What was given to the speaker at the same instant; echo of it is in later recordings."""


OnFrame = Callable[[SoundFrame], object]
SoundSource = Callable[[float], bytes]
"""Gives the frame to be played at an instant; empty for silence. It is called on the connector's thread, once a frame,
and must return at once."""


@runtime_checkable
class SoundConnector(Protocol):
    """A microphone and a speaker on one clock."""

    @property
    def running(self) -> bool: ...

    @property
    def fault(self) -> str:
        """Why no sound comes though it runs; empty where it does."""

    def start(self) -> None:
        """Begin; running already, nothing happens.

        Raises:
            ConnectorError: There is no such device, or it cannot be opened.
        """

    def stop(self) -> None:
        """End; no frame is taken or given any more. Stopped already, nothing happens."""

    def listen(self, on_frame: OnFrame) -> Close:
        """Have each frame given, on the connector's thread, in order; what ends it."""

    def play(self, source: SoundSource) -> Close:
        """Have a source played, as long as it is not closed.

        Raises:
            UsageError: Another source is being played.
        """


class FrameLoop:
    """Who listens and what is played: the part that all connectors to sound share."""

    def __init__(self) -> None:
        self._listeners: tuple[OnFrame, ...] = ()
        self._source: SoundSource | None = None

    @property
    def fault(self) -> str:
        """See `SoundConnector`."""
        return ""

    def listen(self, on_frame: OnFrame) -> Close:
        """See `SoundConnector`."""
        self._listeners = (*self._listeners, on_frame)

        def close() -> None:
            self._listeners = tuple(each for each in self._listeners if each is not on_frame)

        return close

    def play(self, source: SoundSource) -> Close:
        """See `SoundConnector`."""
        if self._source is not None:
            raise UsageError("something is played already; close it first: one speaker has one source")
        self._source = source

        def close() -> None:
            if self._source is source:
                self._source = None

        return close

    def played(self, at: float) -> bytes:
        """The frame to be played; silence where there is no source, or where it fails."""
        source = self._source
        if source is None:
            return SILENCE
        try:
            return bytes(memoryview(source(at)).cast("B")[:FRAME_BYTES]).ljust(FRAME_BYTES, b"\0")
        except Exception:
            log.exception("what is played failed; it is played no more")
            self._source = None
            return SILENCE

    def give(self, frame: SoundFrame) -> None:
        """Give a frame to all who listen; one that fails listens no more."""
        for on_frame in self._listeners:
            try:
                on_frame(frame)
            except Exception:
                log.exception("a listener to sound failed; it is given no more frames")
                self._listeners = tuple(each for each in self._listeners if each is not on_frame)

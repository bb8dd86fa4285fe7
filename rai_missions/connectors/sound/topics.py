# SPDX-License-Identifier: Apache-2.0
"""Sound on topics of talk: the microphone and the speaker are another program's, or another machine's.

Rule: frames come at the pace of what is received. Sound of another rate is converted, and what is broken is reported
and left out.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from rai_missions.connectors.connector import Close
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, RATE_HZ, FrameLoop, SoundFrame
from rai_missions.connectors.sound.wav import converted
from rai_missions.connectors.worker import Worker
from rai_missions.errors import UsageError
from rai_missions.redaction import logger

__all__ = ("TopicSound",)

log = logger(__name__)
SENT_FRAMES = 16
"""How much is sent at once: half a second."""
WAITING = 4


class TopicSound(FrameLoop):
    """Sound in messages of talk.

    Its clock is that of the sound received: a frame that no message brought does not pass.

    Args:
        hri: Carries the messages; its owner starts and stops it.
        microphone: The topic on which sound is received.
        speaker: The topic on which it is sent.
        now: Seconds on a clock that does not go back; the first frame begins then.
    """

    def __init__(
        self, hri: HRIConnector, microphone: str = FROM_HUMAN, speaker: str = TO_HUMAN, *,
        now: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        super().__init__()
        self._hri, self._topics, self._now = hri, (microphone, speaker), now
        self._lock = threading.Lock()
        self._close: Close | None = None
        self._worker: Worker | None = None
        self._held, self._out = bytearray(), bytearray()
        self._at = 0.0

    @property
    def running(self) -> bool:
        return self._close is not None

    def start(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            if self._close is not None:
                return
            self._held.clear()
            self._out.clear()
            self._at = max(self._at, self._now())
            self._worker = Worker("sound of a topic", limit=WAITING, keep="newest")
            self._close = self._hri.listen(self._topics[0], self._receive, author="human", is_whole=False)

    def stop(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            close, self._close = self._close, None
            worker, self._worker = self._worker, None
        if close is not None:
            close()
        if worker is not None:
            worker.close(2.0)

    def _receive(self, message: HRIMessage) -> None:
        worker = self._worker
        for audio in message.audios:
            try:
                sound = converted(audio.samples, audio.rate_hz, audio.channels, f"a message on {self._topics[0]}")
            except UsageError as fault:
                log.warning("%s", fault)
                continue
            if worker is not None:
                worker.post(lambda sound=sound: self._pass(sound))  # type: ignore[misc]

    def _pass(self, sound: bytes) -> None:
        """On the worker's thread: as many frames as are whole."""
        self._held += sound
        while len(self._held) >= FRAME_BYTES and self._close is not None:
            recorded = bytes(self._held[:FRAME_BYTES])
            del self._held[:FRAME_BYTES]
            played = self.played(self._at)
            self._send(played)
            self.give(SoundFrame(self._at, recorded, played))
            self._at += FRAME_S

    def _send(self, played: bytes) -> None:
        """Send what is played, half a second at a time; what is only silence is not sent."""
        is_silent = not any(played)
        if not is_silent:
            self._out += played
        if self._out and (is_silent or len(self._out) >= SENT_FRAMES * FRAME_BYTES):
            audio = Audio(bytes(self._out), RATE_HZ)
            self._out.clear()
            self._hri.send(HRIMessage(audios=(audio,), author="ai"), self._topics[1])

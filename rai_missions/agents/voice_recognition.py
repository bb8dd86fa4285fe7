# SPDX-License-Identifier: Apache-2.0
"""What a person speaks, as messages: an agent between a microphone and the conversation."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.speech_health import health_of
from rai_missions.connectors.connector import Close
from rai_missions.connectors.hri.connector import FROM_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.sound.connector import SoundConnector
from rai_missions.redaction import logger
from rai_missions.voice.listener import ListenSettings, Transcript
from rai_missions.voice.setup import ListenNames, Recognition, open_recognition

__all__ = ("VoiceRecognition",)

log = logger(__name__)
NAMES, SETTINGS = ListenNames(), ListenSettings()
NAME = "voice"


class VoiceRecognition:
    """Listens to a connector to sound, which its owner starts and stops.

    Args:
        sound: What is listened to.
        hri: Where each sentence is published; by default nowhere.
        topic: On which topic.
        names: Which recognisers and which wake word.
        settings: The phrases that are expected, and times.
        on_transcript: Called with each turn, also with one without words; with the readings of each recogniser, which
            a message does not have.
        on_present: Called when a person surely speaks: what is played should be silent.
        on_fault: Called with a sentence each time an ear or a recogniser ended, hung or could not be opened; None: it
            is logged.
    """

    def __init__(
        self,
        sound: SoundConnector,
        hri: HRIConnector | None = None,
        *,
        topic: str = FROM_HUMAN,
        names: ListenNames = NAMES,
        settings: ListenSettings = SETTINGS,
        on_transcript: Callable[[Transcript], object] = lambda transcript: None,
        on_present: Callable[[float], object] = lambda at: None,
        on_fault: Callable[[str], object] | None = None,
    ) -> None:
        self._sound, self._hri, self._topic, self._names, self._settings = sound, hri, topic, names, settings
        self._on_transcript, self._on_present, self._on_fault = on_transcript, on_present, on_fault
        self._lock = threading.Lock()
        self._recognition: Recognition | None = None
        self._close: Close = lambda: None

    def run(self) -> None:
        """Begin, and return; the recognisers are loaded meanwhile, in processes of their own."""
        with self._lock:
            if self._recognition is not None:
                return
            self._recognition = open_recognition(
                self._names,
                self._settings,
                on_transcript=self._take,
                on_present=self._on_present,
                on_fault=self._on_fault,
            )
            self._close = self._sound.listen(self._recognition.listener.take)

    def stop(self) -> None:
        """End every process that was begun."""
        with self._lock:
            recognition, self._recognition = self._recognition, None
        if recognition is not None:
            self._close()
            recognition.close()

    @property
    def health(self) -> AgentHealth:
        """Whether sound comes and all that listens can be opened, and how often each was started again."""
        recognition = self._recognition
        if recognition is None:
            return AgentHealth("stopped")
        found, fault = health_of(recognition.processes), self._sound.fault
        return found._replace(state="hangs", why=fault) if fault and found.lives else found

    def wait_ready(self) -> None:
        """Wait until all recognisers are loaded.

        Raises:
            UsageError: It does not run, or something is not installed.
        """
        recognition = self._recognition
        if recognition is not None:
            recognition.wait_ready()

    def catch_up(self) -> bool:
        """Wait until all sound that came is looked at, on a clock that can wait; whether it is."""
        recognition = self._recognition
        return recognition is not None and recognition.listener.catch_up()

    def finish(self) -> bool:
        """The sound ends here: wait until all of it is transcribed; whether it is."""
        recognition = self._recognition
        return recognition is not None and recognition.listener.finish()

    def _take(self, transcript: Transcript) -> None:
        self._on_transcript(transcript)
        if self._hri is not None and transcript.text:
            self._hri.send(HRIMessage(transcript.text, author="human", name=NAME), self._topic)

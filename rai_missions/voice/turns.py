# SPDX-License-Identifier: Apache-2.0
"""When a person begins and ends to speak, from how probable speech is in each frame; pure.

Rule: what is begun early may be void. A turn is offered after 32 ms of quiet, and counts once it has ended; a person
who only paused makes it void, and it is offered again with all that followed. What is to count at once counts after 128
ms of quiet.
"""

from __future__ import annotations

from collections import deque
from typing import Literal, NamedTuple

from rai_missions.connectors.sound.connector import FRAME_S

__all__ = ("TurnDetector", "TurnEvent", "TurnFrame", "TurnSettings")

TurnEventKind = Literal["began", "present", "offered", "settled", "void", "ended"]
"""`began`: again where `begin_again` shortens it. `present`: surely a person; again where they speak on after an offer
has settled. `offered`: to be transcribed. `settled`: what was offered counts, if it is a phrase that counts at once.
`void`: what was offered."""
WINDOW = 6
"""The last frames, of which some must be speech."""


class TurnSettings(NamedTuple):
    """Which frames are speech, and how long quiet has to last."""

    threshold: float = 0.5
    """How probable speech must be in a frame."""
    begin_frames: int = 2
    """Frames of speech with which a turn begins."""
    present_frames: int = 2
    """Frames of speech, of the last `WINDOW`, from which on a person surely speaks: what is played is cut."""
    early_s: float = 0.032
    """Quiet after which a turn is offered for transcription."""
    settle_s: float = 0.128
    """Quiet after which an offer is settled."""
    end_s: float = 0.4
    """Quiet after which a turn has ended."""
    short_end_s: float = 0.288
    """Quiet after which a turn has ended where a closed word was offered: yes, no."""
    before_s: float = 0.32
    """Sound before the first frame of speech that belongs to the turn."""
    longest_s: float = 14.0
    """After so long a turn ends, whether a person continues or not."""


class TurnFrame(NamedTuple):
    """A frame of sound, looked at."""

    at: float
    """When it began, in seconds."""
    speech: float
    """How probable it is that a person speaks."""
    clear: bytes
    quiet: bytes


class TurnEvent(NamedTuple):
    """Something about a turn."""

    kind: TurnEventKind
    number: int
    """Of the turn, counted from 1."""
    at: float
    """When it is known: the end of the frame that shows it."""
    spoken_until: float = 0.0
    """When the person stopped speaking; of `offered` and `ended`."""
    offer: int = 0
    """Which offer of the turn it is, or has ended with."""
    clear: bytes = b""
    """Of `offered`: the sound of the turn, without echo."""
    quiet: bytes = b""
    """Of `offered`: the sound of the turn, without echo and without steady noise."""


class TurnDetector:
    """The state of one stream of frames; not for several threads.

    Args:
        settings: Thresholds and times.
    """

    def __init__(self, settings: TurnSettings = TurnSettings()) -> None:  # noqa: B008 - it is frozen
        self._settings = settings
        self._before: deque[TurnFrame] = deque(maxlen=max(1, round(settings.before_s / FRAME_S)))
        self._recent: deque[bool] = deque(maxlen=WINDOW)
        self._number = 0
        self._turn: list[TurnFrame] = []
        self._reset()

    def _reset(self) -> None:
        self._turn = []
        self._offers, self._is_offered, self._is_settled = 0, False, False
        self._is_present, self._is_short = False, False
        self._spoken_until = 0.0

    @property
    def present(self) -> int:
        """The number of the turn in which a person surely speaks; 0: none does."""
        return self._number if self._is_present else 0

    @property
    def is_open(self) -> bool:
        """Whether a turn has begun and not ended."""
        return bool(self._turn)

    def end_sooner(self, number: int, offer: int) -> None:
        """What was offered is a closed word: its turn ends sooner, if it is still the one on offer."""
        if self._is_offered and (number, offer) == (self._number, self._offers):
            self._is_short = True

    def begin_again(self) -> tuple[TurnEvent, ...]:
        """A turn that is open begins with the last frame: what was before it counts for nothing."""
        if not self._turn:
            return ()
        last = self._turn[-1]
        self._turn = [last]
        found = [self._event("void", last)] if self._is_offered else []
        self._is_offered = self._is_settled = self._is_short = False
        return (*found, self._event("began", last))

    def take(self, frame: TurnFrame) -> tuple[TurnEvent, ...]:
        """The next frame; what it shows, and a gap before it."""
        found = [*self._gap(frame)]
        is_speech = frame.speech >= self._settings.threshold
        self._recent.append(is_speech)
        if not self._turn:
            self._before.append(frame)
            if sum(self._recent) >= self._settings.begin_frames and is_speech:
                self._number += 1
                self._turn = list(self._before)
                self._before.clear()
                found.append(self._event("began", frame))
        else:
            self._turn.append(frame)
        if self._turn:
            found += self._speech(frame) if is_speech else self._quiet(frame)
            found += self._cut_off(frame)
        return tuple(found)

    def end(self) -> tuple[TurnEvent, ...]:
        """The stream ends here: so does a turn."""
        return self._ended(self._turn[-1]) if self._turn else ()

    def _gap(self, frame: TurnFrame) -> tuple[TurnEvent, ...]:
        """Frames that are missing, as from a device that was away, are quiet: a turn ends in them."""
        before = self._turn or self._before
        if not before or frame.at - before[-1].at - FRAME_S < self._settings.end_s:
            return ()
        found = self.end()
        self._before.clear()
        self._recent.clear()
        return found

    def _speech(self, frame: TurnFrame) -> list[TurnEvent]:
        found = []
        self._spoken_until = frame.at + FRAME_S
        if self._is_offered:
            found.append(self._event("void", frame))
            self._is_present = self._is_present and not self._is_settled  # what settled may have let us speak since
            self._is_offered = self._is_settled = self._is_short = False
        if not self._is_present and sum(self._recent) >= self._settings.present_frames:
            self._is_present = True
            found.append(self._event("present", frame))
        return found

    def _quiet(self, frame: TurnFrame) -> list[TurnEvent]:
        quiet_s = frame.at + FRAME_S - self._spoken_until
        end_s = self._settings.short_end_s if self._is_short else self._settings.end_s
        found = []
        if quiet_s >= self._settings.early_s - 1e-6 and not self._is_offered:
            found.append(self._offer(frame))
        if quiet_s >= self._settings.settle_s - 1e-6 and not self._is_settled:
            self._is_settled = True
            found.append(self._event("settled", frame))
        if quiet_s >= end_s - 1e-6:
            found += self._ended(frame)
        return found

    def _cut_off(self, frame: TurnFrame) -> tuple[TurnEvent, ...]:
        is_long = bool(self._turn) and frame.at - self._turn[0].at >= self._settings.longest_s
        return self._ended(frame) if is_long else ()

    def _offer(self, frame: TurnFrame) -> TurnEvent:
        self._offers += 1
        self._is_offered = True
        clear, quiet = (b"".join(getattr(each, name) for each in self._turn) for name in ("clear", "quiet"))
        return self._event("offered", frame)._replace(clear=clear, quiet=quiet)

    def _ended(self, frame: TurnFrame) -> tuple[TurnEvent, ...]:
        found = [] if self._is_offered else [self._offer(frame)]
        found.append(self._event("ended", frame))
        self._reset()
        self._recent.clear()
        return tuple(found)

    def _event(self, kind: TurnEventKind, frame: TurnFrame) -> TurnEvent:
        return TurnEvent(kind, self._number, frame.at + FRAME_S, self._spoken_until, self._offers)

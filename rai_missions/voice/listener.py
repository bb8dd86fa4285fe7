# SPDX-License-Identifier: Apache-2.0
"""Frames of sound in, transcripts out: an ear, turns, and one recogniser or two.

Rule: every turn that ends has one transcript, with or without words, or one fault; nothing waits for a recogniser.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from rai_missions.connectors.process.frames import Broken
from rai_missions.connectors.sound.connector import FRAME_S, RATE_HZ, SoundFrame
from rai_missions.connectors.worker import SerialQueue
from rai_missions.redaction import logger
from rai_missions.voice.fusion import FusedTurn, evidence_in, fused, guesses_in, odds_in, votes_in
from rai_missions.voice.kind import SHORT_S
from rai_missions.voice.offers import OfferQueue, TurnOffer
from rai_missions.voice.process import SpeechProcess, SpeechReply, sound_in, text_in
from rai_missions.voice.turns import TurnDetector, TurnEvent, TurnFrame, TurnSettings

__all__ = ("PHRASES", "WAKE_CUTOFF", "ListenSettings", "SpeechListener", "Transcript")

log = logger(__name__)

PHRASES = (
    "stop", "yes", "no", "pause", "pause the mission", "wait", "resume", "resume the mission", "continue",
    "cancel", "cancel the mission", "start the mission",
)  # fmt: skip
"""Short sentences that are expected of any person who talks to a robot that works. "halt" is not looked for: in noise
it is taken for "stop" as well as for words that are no order; read freely it counts."""
WAKE_CUTOFF = 0.65
"""How probable the wake word must be, as the mean of 150 ms. For "okay nabu" and "hey jarvis" six hours of other speech
have 0.61 at most."""
AWAKE_S = 8.0
"""How long after the wake word, or after a turn that passed by it, a turn may begin."""
WORD_LASTS_S = 0.75
"""From the first frame in which the wake word is sure: how long it may be sure again, as the same word."""
LEAST_BEHIND_S = 0.24
"""So long is any word behind the wake word, from that frame on; what is shorter is the end of the wake word."""


class ListenSettings(NamedTuple):
    """Which phrases are expected, which of them count at once, and when a turn begins and ends."""

    phrases: tuple[str, ...] = PHRASES
    """In lower case without punctuation; the second recogniser knows no others."""
    at_once: tuple[str, ...] = ("stop", "halt")
    """Phrases whose transcript is given before the turn has ended, and without a wake word."""
    closed: tuple[str, ...] = ("yes", "no")
    """Phrases after which a turn ends sooner."""
    needs_wake_word: bool = False
    """A turn counts only where the wake word was spoken before."""
    turns: TurnSettings = TurnSettings()


class Transcript(NamedTuple):
    """What a person may have spoken in one turn."""

    text: str
    """Empty where no words were recognised: noise, or a false alarm."""
    readings: tuple[str, ...]
    """The text by each recogniser that recognised something; the first one's is first."""
    turn: int
    began: float
    spoken_until: float
    """When the person stopped speaking, on the clock of the sound."""
    at: float
    """When the turn was known to have ended, on the same clock."""
    given: float
    """Until when there was sound as this was given, on the same clock: what came before `began` the person knew."""
    fault: str = ""
    """Why there is no transcript; empty if there is one."""

    @property
    def waited_s(self) -> float:
        """How long ago the person had begun as this was given."""
        return self.given - self.began


class OfferReplies(NamedTuple):
    """What the recognisers made of an offer, as far as it is known."""

    first: SpeechReply | None = None
    second: SpeechReply | None = None
    spoken_s: float | None = None
    """How long the person spoke, pauses included."""

    @property
    def is_whole(self) -> bool:
        return self.first is not None and self.second is not None

    @property
    def fault(self) -> str:
        """Why there is no transcript; empty if there is one."""
        return self.first.fault if self.first is not None else ""


@dataclass(slots=True)
class OpenTurn:
    """A turn that has no transcript yet."""

    began: float
    replies: dict[int, OfferReplies] = field(default_factory=dict)
    """Number of an offer → what the recognisers made of it; the last offer counts."""
    settled: set[int] = field(default_factory=set)
    """The offers that count, if they are a phrase that counts at once."""
    is_called: bool = False
    """It begins with the wake word."""
    is_given: bool = False
    """A phrase of it was given at once."""
    end: TurnEvent | None = None
    awake_until: float = -1.0
    """Until when a turn might begin after the wake word, when this one ended: what wakes later is none of its own."""

    def latest(self, offer: int) -> OfferReplies | None:
        """What is made of an offer, once that is whole and unless another has followed."""
        known = self.replies.get(offer)
        return known if known is not None and known.is_whole and offer == next(reversed(self.replies)) else None

    @property
    def times(self) -> tuple[float, float, float]:
        """When it began, when the person stopped speaking, and when it was known to have ended."""
        end = self.end
        return (self.began, end.spoken_until, end.at) if end is not None else (self.began, self.began, self.began)


class SpeechListener:
    """Listens to one stream of frames; what it finds is given on threads of its processes, one thing at a time.

    Args:
        ear: Looks at frames.
        first: The recogniser whose words count.
        second: One that only decides whether a phrase is meant; it never counts alone.
        settings: What is listened for.
        on_transcript: Called once for each turn; a phrase of `at_once` may come before its turn has ended.
        on_present: Called when a person surely speaks, with the instant; what is played should be cut. Called again
            after the transcript of a turn where they speak in the next one.
    """

    def __init__(
        self,
        ear: SpeechProcess,
        first: SpeechProcess,
        second: SpeechProcess | None = None,
        *,
        settings: ListenSettings = ListenSettings(),  # noqa: B008 - it is frozen
        on_transcript: Callable[[Transcript], object],
        on_present: Callable[[float], object] = lambda at: None,
    ) -> None:
        self._ear = ear
        self._settings, self._on_transcript, self._on_present = settings, on_transcript, on_present
        self._queue = SerialQueue()
        self._detector = TurnDetector(settings.turns)
        self._recognisers = {"first": first} | ({"second": second} if second is not None else {})
        self._offers = {which: OfferQueue() for which in self._recognisers}
        self._turns: dict[int, OpenTurn] = {}
        self._woken_until = self._passed_until = -1.0
        """Until when a turn may begin after the wake word, and after a turn that passed."""
        self._is_waking, self._called_at = False, -math.inf
        """Whether the last frame had the wake word, which lasts some frames; when the first of them began."""
        self._pending = 0
        self._until = 0.0
        """The end of the last frame."""
        self._lost = 0
        """Frames that no ear looked at."""
        self._rest = threading.Condition()

    @property
    def lost_s(self) -> float:
        """How much sound was lost with an ear that ended, hung or could not be opened, in seconds."""
        return self._lost * FRAME_S

    def take(self, frame: SoundFrame) -> None:
        """The next frame; returns at once."""
        self._count(1)
        self._until = frame.at + FRAME_S
        self._ear.ask(
            {"do": "take"},
            (frame.recorded, frame.played),
            on_reply=lambda reply: self._post(partial(self._looked_at, frame, reply)),
        )

    def catch_up(self, within_s: float = 60.0) -> bool:
        """Wait until all that was given is looked at, and all that was offered is transcribed; whether it is."""
        with self._rest:
            return self._rest.wait_for(lambda: self._pending == 0, within_s)

    def finish(self, within_s: float = 60.0) -> bool:
        """The stream ends here: wait until all is transcribed; whether it is."""
        done = self.catch_up(within_s)
        self.end()
        return self.catch_up(within_s) and done

    def end(self) -> None:
        """The stream ends here: so does a turn; returns at once."""
        self._count(1)
        self._post(self._end_turn)

    # -- one at a time -------------------------------------------------------------------------------------------------

    def _post(self, work: Callable[[], object]) -> None:
        def do() -> None:
            try:
                work()
            finally:
                self._count(-1)

        self._queue.post(do)

    def _count(self, more: int) -> None:
        with self._rest:
            self._pending += more
            if self._pending == 0:
                self._rest.notify_all()

    def _looked_at(self, frame: SoundFrame, reply: SpeechReply) -> None:
        if reply.fault:
            self._lost += 1
            self._end_turn()  # what of a turn was before the fault is transcribed
            return
        try:
            clear, quiet = sound_in(reply.data, "clear"), sound_in(reply.data, "quiet")
            speech, wake = (float(reply.data[name]) for name in ("speech", "wake"))
        except (Broken, KeyError, TypeError, ValueError):
            log.warning("the ear sent what is no frame")
            return
        for event in self._detector.take(TurnFrame(frame.at, speech, clear, quiet)):
            self._turn_event(event)
        was_waking, self._is_waking = self._is_waking, wake >= WAKE_CUTOFF
        if self._is_waking:
            self._woken_until = frame.at + AWAKE_S
        if self._is_waking and not was_waking and frame.at - self._called_at > WORD_LASTS_S:
            self._called_at = frame.at  # what is before was for others, or is the word itself
            for event in self._detector.begin_again():
                self._turn_event(event)

    def _end_turn(self) -> None:
        for event in self._detector.end():
            self._turn_event(event)

    def _turn_event(self, event: TurnEvent) -> None:
        if event.kind == "began":
            is_called = event.number in self._turns
            turn = self._turns.setdefault(event.number, OpenTurn(event.at))
            turn.began, turn.is_called = event.at, is_called
        elif event.kind == "present":
            self._on_present(event.at)
        elif event.kind == "offered":
            self._transcribe(event)
        elif event.kind == "settled":
            self._turns[event.number].settled.add(event.offer)
            self._give_at_once(TurnOffer(event.number, event.offer))
        elif event.kind == "void":
            for queue in self._offers.values():
                self._count(-queue.void(TurnOffer(event.number, event.offer)))
        elif event.kind == "ended":
            turn = self._turns[event.number]
            turn.end, turn.awake_until = event, self._woken_until
            self._conclude()

    def _transcribe(self, event: TurnEvent) -> None:
        offer = TurnOffer(event.number, event.offer)
        turn = self._turns[event.number]
        if turn.is_called and event.spoken_until - turn.began < LEAST_BEHIND_S - 1e-6:
            turn.replies[event.offer] = OfferReplies(SpeechReply(), SpeechReply())
            return
        spoken_s = event.spoken_until - turn.began + self._settings.turns.begin_frames * FRAME_S
        second = None if "second" in self._offers else SpeechReply()
        turn.replies[event.offer] = OfferReplies(second=second, spoken_s=spoken_s)
        is_short = len(event.quiet) <= 2 * RATE_HZ * SHORT_S
        for which, queue in self._offers.items():
            self._count(1)
            queue.add(offer, event.quiet if is_short or which == "second" else event.clear)
            self._ask(which)

    def _ask(self, which: str) -> None:
        """Have a recogniser that has nothing to do transcribe what waits."""
        if (taken := self._offers[which].take()) is not None:
            offer, sound = taken
            order = {"do": "transcribe", "phrases": self._settings.phrases}
            self._recognisers[which].ask(order, (sound,), on_reply=self._on_reading(offer, which))

    def _on_reading(self, offer: TurnOffer, which: str) -> Callable[[SpeechReply], None]:
        return lambda reply: self._post(partial(self._read, offer, which, reply))

    def _read(self, offer: TurnOffer, which: str, reply: SpeechReply) -> None:
        if reply.is_lost and self._offers[which].again():
            self._count(1)
            self._ask(which)
            return
        self._offers[which].done()
        self._ask(which)
        turn = self._turns.get(offer.number)
        if turn is None:
            return
        before = turn.replies[offer.offer]
        turn.replies[offer.offer] = before._replace(first=reply) if which == "first" else before._replace(second=reply)
        known = turn.latest(offer.offer)
        if known is None:
            return
        if words_of(known, self._settings).text in self._settings.closed:
            self._detector.end_sooner(offer.number, offer.offer)
        self._give_at_once(offer)
        self._conclude()

    def _give_at_once(self, offer: TurnOffer) -> None:
        """Give a phrase that does not wait for the end of its turn, once the person is quiet and it is transcribed."""
        turn = self._turns[offer.number]
        known = turn.latest(offer.offer)
        if known is None or offer.offer not in turn.settled or turn.is_given or turn.end is not None:
            return
        text, readings = words_of(known, self._settings)
        if text in self._settings.at_once:
            turn.is_given = True
            self._give(Transcript(text, readings, offer.number, *turn.times, self._until))

    def _conclude(self) -> None:
        """Give the transcripts of turns that have ended, in their order, up to the first that is not transcribed."""
        for number, turn in list(self._turns.items()):
            known = turn.latest(turn.end.offer) if turn.end is not None else None
            if known is None:
                return
            del self._turns[number]
            self._give_whole(number, turn, known)

    def _give_whole(self, number: int, turn: OpenTurn, known: OfferReplies) -> None:
        """Give the transcript of a turn that has ended, unless a phrase of it was given at once."""
        text, readings = words_of(known, self._settings)
        is_awake = turn.began <= max(turn.awake_until, self._passed_until)
        if turn.is_given and text in self._settings.at_once:
            return
        if self._settings.needs_wake_word and not is_awake and text not in self._settings.at_once:
            text, readings = "", ()
        elif text and is_awake:
            self._passed_until = turn.times[2] + AWAKE_S
        self._give(Transcript(text, readings, number, *turn.times, self._until, known.fault))

    def _give(self, transcript: Transcript) -> None:
        """Give a transcript, by which a voice takes the person for finished; they may be speaking again."""
        self._on_transcript(transcript)
        if self._detector.present > transcript.turn:
            self._on_present(transcript.given)


def words_of(known: OfferReplies, settings: ListenSettings) -> FusedTurn:
    """The text of a turn, and each recogniser's own."""
    first, second = (reply.data if reply is not None and not reply.fault else {} for reply in known[:2])
    one, other = evidence_in(first, settings.phrases), votes_in(second, settings.phrases)
    phrases = (*settings.phrases, *settings.at_once)
    odds = odds_in(first, settings.phrases)
    return fused(text_in(first, "text"), one, other, phrases, known.spoken_s, guesses_in(first), odds)

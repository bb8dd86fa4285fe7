# SPDX-License-Identifier: Apache-2.0
"""The doors through which people talk with a robot: what each grants, and what is shown or spoken there.

Rule: a door sets the role of all that comes through it. A door that is shut counts as one at which nothing was spoken.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple, Protocol

from rai_missions.agents.agent import lacks, reports_health
from rai_missions.conversation import Speech
from rai_missions.conversation.inputs import SpeechResult
from rai_missions.conversation.outputs import Way
from rai_missions.errors import UsageError, raised_text
from rai_missions.event import Role
from rai_missions.redaction import cut, logger, shown
from rai_missions.voice.spoken_text import SpeechPriority

__all__ = ("OnSpoken", "TakesSentence", "TalkDoor", "TalkDoors", "TalkLine", "TextDoor")

log = logger(__name__)
OnSpoken = Callable[[SpeechResult], None]
"""Receives once, from any thread, how a speech ended."""


class TakesSentence(Protocol):
    """What takes a sentence of a door: `ConversationalAgent.receive`."""

    def __call__(
        self,
        text: str,
        *,
        role: Role,
        channel: str,
        author: str = "",
        readings: tuple[str, ...] = (),
        message_id: str = "",
        waited_s: float = 0.0,
        age_s: float = 0.0,
    ) -> str: ...


class TalkLine(NamedTuple):
    """One line of a conversation, as a page or a terminal shows it."""

    number: int
    by: Role | Literal["robot"]
    text: str
    author: str = ""
    channel: str = ""
    way: Way | Literal[""] = ""
    """Of the robot's lines; empty for any other."""
    priority: SpeechPriority | Literal[""] = ""
    at: float = 0.0
    spoken: Literal["", "cut", "failed"] = ""
    """How it ended where that is not `whole`."""
    repeated: bool = False
    report: str = ""
    """The identity of a report, as in `Speech.report`; empty for any other line."""


class TalkDoor(Protocol):
    """Where the robot is listened to or read."""

    @property
    def channel(self) -> str:
        """The name of the door, such as `terminal`, `page` or `voice`."""

    @property
    def is_open(self) -> bool:
        """Someone may be reached there now."""

    @property
    def is_aloud(self) -> bool:
        """What is given there is spoken, and takes its time."""

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        """Speak or show; never waits."""

    def silence(self, *, is_total: bool = True) -> None:
        """Stop speaking now.

        Args:
            is_total: Also what a person who begins to speak does not interrupt.
        """

    def show(self, line: TalkLine) -> None:
        """A line of the conversation, of anyone; one that came before with its number replaces that. Never waits."""


DOOR = tuple(sorted(each for each in vars(TalkDoor) if not each.startswith("_")))
"""What a door has."""


class TextDoor:
    """A door at which text is shown: it is read as soon as it is there.

    Args:
        channel: Its name.
        show: Shows a line; from any thread.
        is_open: Whether someone may read it now.
    """

    is_aloud = False

    def __init__(
        self, channel: str, show: Callable[[TalkLine], None], is_open: Callable[[], bool] = lambda: True
    ) -> None:
        self._channel, self._show, self._is_open = channel, show, is_open

    @property
    def channel(self) -> str:
        return self._channel

    @property
    def is_open(self) -> bool:
        return self._is_open()

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        on_end("whole" if self.is_open else "failed")

    def silence(self, *, is_total: bool = True) -> None:
        """What is shown is shown."""

    def show(self, line: TalkLine) -> None:
        self._show(line)


class TalkDoors:
    """All doors of a conversation. One that raises harms no other: it is shut, silent, or has failed to speak.

    Args:
        doors: Each has a channel of its own.

    Raises:
        UsageError: One is no door, or has the channel of another that is open.
    """

    def __init__(self, doors: Sequence[TalkDoor] = ()) -> None:
        self._doors: Mapping[str, TalkDoor] = {}
        for door in doors:
            self.add(door)

    def add(self, door: TalkDoor) -> None:
        """Have one more, in the place of one of its channel that is shut.

        Raises:
            UsageError: It is no door, or its channel has one that is open: an answer could not go to both.
        """
        if absent := next((each for each in DOOR if lacks(door, each)), ""):
            raise UsageError(f"{shown(door)} is no door: it lacks '{absent}'; a door has {', '.join(DOOR)}")
        other = self._doors.get(door.channel, door)
        if other is not door and _is_open(other):
            raise UsageError(f"the channel {shown(door.channel)} has an open door; give this one a channel of its own")
        self._doors = {**self._doors, door.channel: door}

    @property
    def is_open(self) -> bool:
        """There is one at which someone may be reached."""
        return any(map(_is_open, self._doors.values()))

    def show(self, line: TalkLine) -> None:
        """Show a line at every door that shows text."""
        for name, door in self._doors.items():
            try:
                door.show(line)
            except Exception:
                log.exception("the door '%s' cannot show a line", name)

    @property
    def open(self) -> tuple[str, ...]:
        """The channels at which someone may be reached now."""
        return tuple(name for name, door in self._doors.items() if _is_open(door))

    @property
    def fault(self) -> str:
        """What is wrong with a door that knows how it fares; empty where nothing is."""
        faults = ((name, _fault_of(door)) for name, door in self._doors.items())
        return next((f"the door '{name}': {why}" for name, why in faults if why), "")

    def silence(self, *, is_total: bool = True) -> None:
        """Have every door that speaks be silent now."""
        for name, door in self._doors.items():
            try:
                door.silence(is_total=is_total)
            except Exception:
                log.exception("the door '%s' cannot be silenced", name)

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        """Speak at the doors that are meant; how it ended is that of the door that speaks aloud, else of the best."""
        meant = [self._doors[speech.to]] if speech.to in self._doors else list(self._doors.values())
        meant = [door for door in meant if _is_open(door)]
        if not meant:
            on_end("failed")
            return
        tally = _Tally(len(meant), on_end)
        for door in meant:
            end = tally.of(is_aloud=door.is_aloud)
            try:
                door.speak(speech, end)
            except Exception:
                log.exception("the door '%s' cannot speak", door.channel)
                end("failed")


def _is_open(door: TalkDoor) -> bool:
    try:
        return door.is_open
    except Exception:
        log.exception("the door '%s' cannot report whether it is open", door.channel)
        return False


def _fault_of(door: TalkDoor) -> str:
    """Why a door that knows how it fares lives no more; empty where it does."""
    try:
        health = door.health if reports_health(door) else None
    except Exception as error:  # noqa: BLE001 - the code of a door of another program
        return f"it cannot report its health ({cut(raised_text(error), 200)})"
    return health.why if health is not None and not health.lives else ""


RANK: tuple[SpeechResult, ...] = ("whole", "cut", "failed")


class _Tally:
    """How a speech ended at each of several doors."""

    def __init__(self, count: int, on_end: OnSpoken) -> None:
        self._lock, self._left, self._on_end = threading.Lock(), count, on_end
        self._aloud: list[SpeechResult] = []
        self._shown: list[SpeechResult] = []

    def of(self, *, is_aloud: bool) -> OnSpoken:
        ended: list[bool] = []

        def end(result: SpeechResult) -> None:
            with self._lock:
                if ended:
                    return
                ended.append(True)
                (self._aloud if is_aloud else self._shown).append(result)
                self._left -= 1
                is_last = not self._left
            if is_last:
                self._on_end(min(self._aloud or self._shown, key=RANK.index))

        return end

# SPDX-License-Identifier: Apache-2.0
"""Parts as messages again, whatever their order.

Rule: everything here is pure; time comes in. What is held is bounded, and what is given up is reported with what there
was of it, never dropped in silence.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from rai_missions.connectors.hri.message import MOST_BYTES, MOST_ITEMS, MOST_TEXT, HRIMessage, size_of

__all__ = ("Assembly", "ReceivedMessage")

MOST_PARTS = 1000
"""The largest number of parts of one message."""
MOST_OPEN = 64
"""Messages that may be incomplete at the same time."""
MOST_HELD = 64 * 1024 * 1024
"""Bytes of all incomplete messages together."""
MOST_ENDED = 256
"""Ended messages whose parts are known again when they come a second time."""
Sender = tuple[str, str, str]
"""Author, name and communication id: whose parts belong together."""


class ReceivedMessage(NamedTuple):
    """A message that was received: whole, or what there is of it and why there is no more."""

    message: HRIMessage
    """`seq_end` is false where no part was marked as the last one."""
    missing: tuple[int, ...] = ()
    """The parts that did not come, of those that are known to exist."""
    duplicated: int = 0
    """How many parts came a second time; the first one counts."""
    reordered: int = 0
    """How many parts came after a later one."""
    why: str = ""
    """Why it is not whole; empty for a message that is."""


class Assembly:
    """Joins parts to messages, those of several senders at a time, whatever their order.

    Args:
        within_s: How long the next part of a message may take; ten times that, the whole message.
        lone_s: How long after a first part that is not marked as the last it counts as the whole message, where no
            other came. Other programs send short messages so.
        most_open: Messages that may be incomplete at the same time.
        most_held: Bytes of all of them.
    """

    def __init__(
        self, *, within_s: float = 30.0, lone_s: float = 0.3, most_open: int = MOST_OPEN, most_held: int = MOST_HELD
    ) -> None:
        self._within_s, self._lone_s, self._most_open, self._most_held = within_s, lone_s, most_open, most_held
        self._open: OrderedDict[Sender, _Sequence] = OrderedDict()
        self._ended: OrderedDict[Sender, frozenset[int]] = OrderedDict()
        self._held = 0

    @property
    def due(self) -> float | None:
        """The earliest instant at which `expire` has something to report; None while nothing is incomplete."""
        return min(map(self._due, self._open.values()), default=None)

    def add(self, part: HRIMessage, at: float) -> tuple[ReceivedMessage, ...]:
        """What a part completes, and what is to be reported of it.

        Args:
            part: A part, or a whole message.
            at: Now, in seconds on any clock that does not go back.
        """
        sender = (part.author, part.name, part.communication_id)
        if part.seq_no == 0 and (part.seq_end or not part.communication_id):
            return (ReceivedMessage(replace(part, seq_end=True)),)
        if not part.communication_id:
            return (
                ReceivedMessage(part, why=f"part {part.seq_no} has no communication_id, by which the others are known"),
            )
        if part.seq_no >= MOST_PARTS:
            return (ReceivedMessage(part, why=f"part {part.seq_no}: a message has {MOST_PARTS} parts at the most"),)
        if hash(part) in self._ended.get(sender, ()):
            return (
                ReceivedMessage(part, duplicated=1, why=f"part {part.seq_no} of a message that has ended came again"),
            )
        return self._join(sender, part, at)

    def expire(self, at: float) -> tuple[ReceivedMessage, ...]:
        """What has waited for long enough: first parts that were the whole message, and messages that are given up."""
        found = []
        for sender, sequence in tuple(self._open.items()):
            if self._due(sequence) <= at:
                late = f"{sequence.lacking()} did not come within {self._within_s:g} s"
                found.append(self._end(sender, "" if sequence.is_lone else late))
        return tuple(found)

    def leave(self) -> tuple[ReceivedMessage, ...]:
        """What is incomplete once no more is received; all of it is given up."""
        return tuple(
            self._end(sender, f"{sequence.lacking()} had not come when the topic was left")
            for sender, sequence in tuple(self._open.items())
        )

    def _join(self, sender: Sender, part: HRIMessage, at: float) -> tuple[ReceivedMessage, ...]:
        sequence = self._open.get(sender) or self._open.setdefault(sender, _Sequence(at, at))
        if sequence.parts.get(part.seq_no) == part:
            sequence.duplicated += 1
            return ()
        if why := sequence.refusal(part):
            return (ReceivedMessage(part, why=why),)
        if why := sequence.excess(part):
            return (self._end(sender, why), ReceivedMessage(part, why=why))
        sequence.take(part, at)
        self._held += _size(part)
        if sequence.is_whole:
            return (self._end(sender),)
        return tuple(self._make_room())

    def _make_room(self) -> Iterator[ReceivedMessage]:
        while len(self._open) > self._most_open:
            yield self._push_out(f"more than {self._most_open} messages are incomplete")
        while self._held > self._most_held:
            yield self._push_out(f"incomplete messages are more than {self._most_held} bytes")

    def _push_out(self, why: str) -> ReceivedMessage:
        """The oldest has to go; a lone first part counts as the whole message, as it would in its time."""
        sender, sequence = next(iter(self._open.items()))
        return self._end(sender, "" if sequence.is_lone else why)

    def _due(self, sequence: _Sequence) -> float:
        if sequence.is_lone:
            return sequence.latest + self._lone_s
        return min(sequence.latest + self._within_s, sequence.began + 10 * self._within_s)

    def _end(self, sender: Sender, why: str = "") -> ReceivedMessage:
        sequence = self._open.pop(sender)
        self._held -= sequence.size
        self._ended[sender] = frozenset(map(hash, sequence.parts.values()))
        self._ended.move_to_end(sender)
        if len(self._ended) > MOST_ENDED:
            self._ended.popitem(last=False)
        return sequence.received(why)


@dataclass(slots=True)
class _Sequence:
    """The parts of one message that have come."""

    began: float
    latest: float
    parts: dict[int, HRIMessage] = field(default_factory=dict)
    size: int = 0
    end: int | None = None
    """The number of the last part, once it is known."""
    duplicated: int = 0
    reordered: int = 0

    @property
    def is_whole(self) -> bool:
        return self.end is not None and len(self.parts) == self.end + 1

    @property
    def is_lone(self) -> bool:
        """The first part alone, which may be all there is: other programs do not mark the end of a short message."""
        return self.end is None and self.parts.keys() == {0}

    def take(self, part: HRIMessage, at: float) -> None:
        self.reordered += bool(self.parts) and part.seq_no < max(self.parts)
        self.parts[part.seq_no], self.latest = part, at
        self.size += _size(part)
        if part.seq_end:
            self.end = part.seq_no

    def refusal(self, part: HRIMessage) -> str:
        """Why a part does not fit those that are here; empty where it does."""
        if part.seq_no in self.parts:
            return f"part {part.seq_no} came twice, with different contents; the first one counts"
        if self.end is not None and (part.seq_end or part.seq_no > self.end):
            return f"part {part.seq_no} came, and part {self.end} is marked as the last one"
        if part.seq_end and max(self.parts, default=0) > part.seq_no:
            return f"part {part.seq_no} is marked as the last one, and part {max(self.parts)} is here"
        return ""

    def excess(self, part: HRIMessage) -> str:
        """Why a message with this part as well would be too large; empty where it would not."""
        every = (*self.parts.values(), part)
        text = sum(len(each.text) for each in every)
        if text > MOST_TEXT:
            return f"its text has more than {MOST_TEXT} characters"
        if sum(size_of(item) for each in every for item in each.attachments) > MOST_BYTES:
            return f"its pictures and sound are more than {MOST_BYTES} bytes"
        if max(sum(len(each.images) for each in every), sum(len(each.audios) for each in every)) > MOST_ITEMS:
            return f"it has more than {MOST_ITEMS} pictures or pieces of sound"
        return ""

    def lacking(self) -> str:
        """The parts that are still to come, in words."""
        missing = self.received().missing
        word = "part" if len(missing) == 1 else "parts"
        return f"{word} {', '.join(map(str, missing))}" if missing else "the last part"

    def received(self, why: str = "") -> ReceivedMessage:
        parts = [self.parts[number] for number in sorted(self.parts)]
        message = replace(
            parts[0],
            text="".join(each.text for each in parts),
            seq_no=0,
            seq_end=self.end is not None,
            images=tuple(image for each in parts for image in each.images),
            audios=tuple(audio for each in parts for audio in each.audios),
        )
        count = max(self.parts) + 1 if self.end is None else self.end + 1
        missing = tuple(number for number in range(count) if number not in self.parts)
        return ReceivedMessage(message, missing, self.duplicated, self.reordered, why)


def _size(part: HRIMessage) -> int:
    return len(part.text) + sum(map(size_of, part.attachments))

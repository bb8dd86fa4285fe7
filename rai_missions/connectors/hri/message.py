# SPDX-License-Identifier: Apache-2.0
"""A message between a person and a robot, as a value: text, pictures, sound, and who wrote it.

Rule: a message holds no role. What its author may order is set by the door that received it, never by what it holds.

Source: the fields are those of `rai_interfaces/msg/HRIMessage` and `AudioMessage` (RobotecAI/rai).
"""

from __future__ import annotations

import io
import wave
from dataclasses import dataclass, field
from typing import Literal, get_args

from rai_missions.errors import UsageError
from rai_missions.image import Image
from rai_missions.plain_data import text_fault
from rai_missions.redaction import shown

__all__ = ("MOST_BYTES", "MOST_ITEMS", "MOST_TEXT", "Audio", "Author", "HRIMessage", "size_of")

Author = Literal["human", "ai"]
"""Who wrote a message: a person, or a machine that speaks for itself."""
MOST_TEXT = 100_000
"""Characters of a message's text."""
MOST_BYTES = 32 * 1024 * 1024
"""Bytes of a message's pictures and sound together."""
MOST_ITEMS = 64
"""Pictures of a message, and pieces of sound."""
MOST_NAME = 200
"""Characters of a name and of a communication's id."""
MOST_PARTS = 2**31
"""A sequence number is below this."""
RATES_HZ = (4_000, 65_535)
"""The lowest and highest sample rate; the message type has 16 bits for it."""
MOST_CHANNELS = 8
SAMPLE_BYTES = 2


@dataclass(frozen=True, slots=True)
class Audio:
    """Sound as samples of 16 bits.

    Raises:
        UsageError: It is broken: half a sample, a rate or a number of channels that no sound has.
    """

    samples: bytes
    """Signed, little-endian, 16 bits each; those of the channels alternate."""
    rate_hz: int
    """Samples of one channel in a second."""
    channels: int = 1

    def __post_init__(self) -> None:
        least, most = RATES_HZ
        if not _is_whole(self.rate_hz, least, most):
            raise UsageError(f"audio: rate_hz {shown(self.rate_hz)} is no sample rate; one goes from {least} to {most}")
        if not _is_whole(self.channels, 1, MOST_CHANNELS):
            raise UsageError(f"audio: {shown(self.channels)} channels; there are 1 to {MOST_CHANNELS}")
        if not isinstance(self.samples, bytes):
            raise UsageError(f"audio: samples are bytes, not {type(self.samples).__name__}")
        if len(self.samples) % (SAMPLE_BYTES * self.channels):
            whole = f"{SAMPLE_BYTES * self.channels} bytes for each of {self.channels} channels' samples"
            raise UsageError(f"audio: {len(self.samples)} bytes are no whole number of samples; {whole}")

    @property
    def frames(self) -> int:
        """Samples of one channel."""
        return len(self.samples) // (SAMPLE_BYTES * self.channels)

    @property
    def duration_s(self) -> float:
        return self.frames / self.rate_hz

    def wav(self) -> bytes:
        """The sound as a WAV file."""
        file = io.BytesIO()
        with wave.open(file, "wb") as writer:
            writer.setnchannels(self.channels)
            writer.setsampwidth(SAMPLE_BYTES)
            writer.setframerate(self.rate_hz)
            writer.writeframes(self.samples)
        return file.getvalue()

    @classmethod
    def of_wav(cls, data: bytes) -> Audio:
        """The sound in a WAV file of 16 bits.

        Raises:
            UsageError: It is none, is cut short, or has samples of another size.
        """
        try:
            with wave.open(io.BytesIO(data)) as reader:
                width, channels, rate_hz = reader.getsampwidth(), reader.getnchannels(), reader.getframerate()
                count, samples = reader.getnframes(), reader.readframes(MOST_BYTES)
        except (wave.Error, EOFError, RuntimeError, ValueError) as fault:  # RuntimeError: a piece ends beyond the file
            raise UsageError(
                f"audio: {len(data)} bytes are no WAV file: {shown(str(fault) or 'it is cut short')}"
            ) from None
        if width != SAMPLE_BYTES:
            raise UsageError(f"audio: samples of {8 * width} bits; WAV files of 16 bits are read")
        audio = cls(samples, rate_hz, channels)
        if audio.frames < count:
            raise UsageError(f"audio: a WAV file that is cut short: {audio.frames} of {count} samples")
        return audio


@dataclass(frozen=True, slots=True)
class HRIMessage:
    """One message, or one part of a long one.

    Raises:
        UsageError: A field is at fault; the sentence names it, quotes what was given, and states what would be right.
    """

    text: str = ""
    images: tuple[Image, ...] = ()
    audios: tuple[Audio, ...] = ()
    author: Author = "human"
    name: str = ""
    """Who the author is by their own word; for people to read, and grants nothing."""
    communication_id: str = ""
    """The parts of one message share it; empty for a message that is sent whole."""
    seq_no: int = 0
    """Which part this is, from 0."""
    seq_end: bool = True
    """The last part, and so the whole message where `seq_no` is 0."""
    age_s: float = field(default=0.0, compare=False)
    """Of a received one, seconds from its own stamp to its receipt; 0 without a stamp, or with one in the future."""

    def __post_init__(self) -> None:
        if self.author not in get_args(Author):
            raise UsageError(f"author: {shown(self.author)} is neither 'human' nor 'ai'")
        for name, most in (("text", MOST_TEXT), ("name", MOST_NAME), ("communication_id", MOST_NAME)):
            _check_text(name, getattr(self, name), most)
        if not _is_whole(self.seq_no, 0, MOST_PARTS - 1):
            raise UsageError(f"seq_no: {shown(self.seq_no)} is no number of a part; the first is 0")
        if not isinstance(self.seq_end, bool):
            raise UsageError(f"seq_end: {shown(self.seq_end)} is neither true nor false")
        _check_items("images", self.images, Image)
        _check_items("audios", self.audios, Audio)
        size = sum(map(size_of, self.attachments))
        if size > MOST_BYTES:
            raise UsageError(f"images and audios: {size} bytes; a message carries {MOST_BYTES} at the most")

    @property
    def attachments(self) -> tuple[Image | Audio, ...]:
        """The message's pictures, then its sound."""
        return (*self.images, *self.audios)

    def __bool__(self) -> bool:
        """Whether it carries anything."""
        return bool(self.text or self.images or self.audios)


def size_of(item: Image | Audio) -> int:
    """Bytes of a picture or a piece of sound; raw pixels, which may be costly, are not asked for."""
    if isinstance(item, Audio):
        return len(item.samples)
    return item.width * item.height * 3 if item.encoding == "rgb8" else len(item.data)


def _is_whole(value: object, least: int, most: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _check_text(field: str, value: object, most: int) -> None:
    if not isinstance(value, str):
        raise UsageError(f"{field}: {shown(value)} is given where text belongs")
    if len(value) > most:
        raise UsageError(f"{field}: {len(value)} characters; there are {most} at the most")
    if fault := text_fault(value):
        raise UsageError(f"{field}: {fault}")


def _check_items(field: str, items: object, kind: type) -> None:
    if not isinstance(items, tuple) or not all(isinstance(each, kind) for each in items):
        raise UsageError(f"{field}: {shown(items)} is no tuple of {kind.__name__}")
    if len(items) > MOST_ITEMS:
        raise UsageError(f"{field}: {len(items)} of them; there are {MOST_ITEMS} at the most")

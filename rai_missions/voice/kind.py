# SPDX-License-Identifier: Apache-2.0
"""What a recogniser, a voice and an ear do, and which there are: ours, and those of other packages by entry points.

Rule: one of them is loaded in the process that holds it, and nowhere else. It is looked up by its name only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from inspect import Parameter, signature
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Protocol

from rai_missions.errors import UsageError, suggestion
from rai_missions.kinds import PackageOffer, known_names, offered

__all__ = ("SHORT_S", "EarReading", "FrameReader", "Reading", "Recogniser", "SpeechSort", "Voice", "known", "opened")

SHORT_S = 3.0
"""A longer turn, with the quiet around it, is no phrase."""
SpeechSort = Literal["recogniser", "voice", "ear"]


class Reading(NamedTuple):
    """What a recogniser makes of some sound."""

    text: str
    """Empty where it recognises no words."""
    evidence: Mapping[str, float] = MappingProxyType({})
    """Of those phrases that were looked for: the logarithm of how much more probable the sound makes them than sound
    that is no speech. It need not be of a probability: what votes for a phrase gives it a few nats."""
    guesses: Mapping[str, float] = MappingProxyType({})
    """Texts that the sound may be where such phrases are spoken, each with the logarithm of its probability."""
    odds: Mapping[str, float] = MappingProxyType({})
    """Of those phrases that a network was trained for: the logarithm of how much more probable each is than none."""


class Recogniser(Protocol):
    """Makes words of sound."""

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        """Transcribe one turn of speech.

        Args:
            samples: 16 kHz, mono, 16 bits.
            phrases: Short sentences that are expected, in lower case without punctuation.
        """


class Voice(Protocol):
    """Makes sound of words."""

    def speak(self, text: str) -> Iterator[bytes]:
        """The sound of a text, 16 kHz, mono, 16 bits, in pieces as they are made."""


class EarReading(NamedTuple):
    """What an ear makes of a frame."""

    speech: float
    """How probable it is that a person speaks, from 0 to 1."""
    wake: float
    """How probable it is that the wake word has just been spoken, from 0 to 1."""
    clear: bytes
    """The frame without the echo of what was played."""
    quiet: bytes
    """The frame without the echo and without steady noise."""


class FrameReader(Protocol):
    """Looks at sound frame by frame, before it is transcribed."""

    def take(self, recorded: bytes, played: bytes) -> EarReading:
        """Look at the next frame."""


RECOGNISERS: Mapping[str, str] = {
    "whisper": "rai_missions.voice.recognisers.whisper:open_recogniser",
    "pocketsphinx": "rai_missions.voice.recognisers.pocketsphinx:PocketSphinx",
}
"""Ours: name → what opens it, given its options as keywords."""
VOICES: Mapping[str, str] = {
    "flite": "rai_missions.voice.voices.flite:open_voice",
    "espeak": "rai_missions.voice.voices.espeak:Espeak",
    "piper": "rai_missions.voice.voices.piper:Piper",
    "kokoro": "rai_missions.voice.voices.kokoro:Kokoro",
}
EARS: Mapping[str, str] = {"ear": "rai_missions.voice.ear:SoundEar"}
PROTOCOLS: Mapping[SpeechSort, type[Any]] = {"recogniser": Recogniser, "voice": Voice, "ear": FrameReader}
VARIADIC = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
OURS: Mapping[SpeechSort, Mapping[str, str]] = {"recogniser": RECOGNISERS, "voice": VOICES, "ear": EARS}


def known(sort: SpeechSort, name: str) -> PackageOffer:
    """Who offers one of a name; nothing of it is loaded.

    Raises:
        UsageError: No package offers it, or two do.
    """
    group = f"rai_missions.{sort}s"
    offer = offered(group, name, OURS[sort])
    if offer is None:
        raise UsageError(f"no {sort} '{name}' is known{suggestion(name, known_names(group, OURS[sort]))}")
    return offer


def opened(sort: SpeechSort, name: str, options: Mapping[str, Any]) -> Any:
    """A recogniser, a voice or an ear, ready; in the process that is to hold it.

    Raises:
        UsageError: No package offers it, two do, it does not load, an option is none of its own, or what it opens
            lacks a method.
    """
    offer = known(sort, name)
    opener = offer.load()
    with offer.opening():
        if why := _option_fault(opener, options):
            raise UsageError(f"the {sort} '{name}' {why}")
        held = opener(**options)
    return offer.keeping(PROTOCOLS[sort], held)


def _option_fault(opener: Callable[..., Any], options: Mapping[str, Any]) -> str:
    """Why it does not take the options; empty if it does."""
    takes = signature(opener).parameters
    free = any(each.kind is each.VAR_KEYWORD for each in takes.values())
    if unknown := [] if free else sorted(options.keys() - takes.keys()):
        return f"has no option '{unknown[0]}'{suggestion(unknown[0], takes)}"
    needed = [name for name, each in takes.items() if each.default is each.empty and each.kind not in VARIADIC]
    lacking = next((name for name in needed if name not in options), "")
    return f"needs a value for its option '{lacking}'" if lacking else ""

# SPDX-License-Identifier: Apache-2.0
"""The contracts of recognisers and voices: ours keep them, and one that breaks a promise is named."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from rai_missions.testing import check_recogniser, check_voice
from rai_missions.voice.kind import Reading, opened
from tests.voice.conftest import needs_voice, spoken


class Hum:
    """A voice that hums for each word."""

    def __init__(self, rate: int = 16_000, pieces: Sequence[Any] = ()) -> None:
        self._rate, self._pieces = rate, pieces

    def speak(self, text: str) -> Iterator[bytes]:
        word = array("h", (int(9000 * math.sin(at / 10)) for at in range(self._rate // 4))).tobytes()
        yield from self._pieces or [word for _ in text.split()]


class Fixed:
    """A recogniser that makes the same of every sound."""

    def __init__(self, reading: Any) -> None:
        self._reading = reading

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Any:
        return self._reading


class Loud:
    """A recogniser that takes each loud sound for what is expected first."""

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        if not phrases or max(map(abs, array("h", samples)), default=0) < 1000:
            return Reading("")
        return Reading(phrases[0], {phrases[0]: 3})


class Forgetful(Hum):
    """A voice of which a process has one: the last that was opened has it."""

    last: Forgetful | None = None

    def __init__(self) -> None:
        super().__init__()
        Forgetful.last = self

    def speak(self, text: str) -> Iterator[bytes]:
        yield from super().speak(text) if self is Forgetful.last else ()


def test_a_voice_and_a_recogniser_of_another_package_keep_their_contracts() -> None:
    check_voice(Hum, ["One.", "Two words."])
    check_recogniser(Loud, [b"\x11\x22" * 8000])


@pytest.mark.parametrize(
    ("voice", "named"),
    [
        (Hum(pieces=["text"]), "sound comes as bytes"),
        (Hum(pieces=[b"\x01" * 9601, b"\x01" * 9601]), "a piece whole samples"),
        (Hum(pieces=[bytes(32_000)]), "is spoken, not silence"),
        (Hum(pieces=[b""]), "is spoken, not silence"),
        (Hum(rate=16_000 * 20), "is its rate another"),
    ],
)
def test_a_voice_that_breaks_a_promise_is_named(voice: Hum, named: str) -> None:
    with pytest.raises(AssertionError, match=named):
        check_voice(lambda: voice)


def test_a_voice_that_is_silent_once_another_is_open_is_named() -> None:
    with pytest.raises(AssertionError, match="is spoken, not silence"):
        check_voice(Forgetful)


@pytest.mark.parametrize(
    ("reading", "named"),
    [
        ("stop", "is a Reading, not 'stop'"),
        (Reading(None), "is text, not None"),  # type: ignore[arg-type]
        (Reading("stop"), "without sound there are no words"),
        (Reading("", {"halt": 1.0}), r"expected only, not for \['halt'\]"),
    ],
)
def test_a_recogniser_that_breaks_a_promise_is_named(reading: Any, named: str) -> None:
    with pytest.raises(AssertionError, match=named):
        check_recogniser(lambda: Fixed(reading))


def test_evidence_is_a_finite_number() -> None:
    class Unsure(Loud):
        def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
            return Reading("", dict.fromkeys(phrases, -math.inf))

    with pytest.raises(AssertionError, match="a finite number, not -inf"):
        check_recogniser(Unsure)


@pytest.mark.parametrize(
    ("guesses", "named"), [({"yes": math.nan}, "a finite number, not nan"), ({1: -1.0}, r"is text, not \[1\]")]
)
def test_guesses_are_texts_with_numbers(guesses: dict[Any, float], named: str) -> None:
    class Guesses(Loud):
        def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
            return Reading("", {}, guesses)

    with pytest.raises(AssertionError, match=named):
        check_recogniser(Guesses)


@needs_voice
@pytest.mark.xdist_group("voice")
def test_flite_keeps_the_contract_of_voices() -> None:
    check_voice(lambda: opened("voice", "flite", {}))


@needs_voice
@pytest.mark.long
@pytest.mark.xdist_group("voice")
@pytest.mark.parametrize("name", ["whisper", "pocketsphinx"])
def test_our_recognisers_keep_the_contract(name: str) -> None:
    check_recogniser(lambda: opened("recogniser", name, {}), [spoken("Stop."), spoken("Where are you going?")])

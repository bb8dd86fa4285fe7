# SPDX-License-Identifier: Apache-2.0
"""A listener and a voice by the names of what they are made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.errors import UsageError
from rai_missions.voice.kind import known
from rai_missions.voice.listener import ListenSettings, SpeechListener, Transcript
from rai_missions.voice.process import SpeechProcess

__all__ = ("ListenNames", "Recognition", "check_names", "open_recognition", "split_options")

AGREES_ONLY = ("pocketsphinx",)
"""Recognisers that take any sound for a phrase."""
SILENCE = bytes(2 * RATE_HZ)
"""A second, which every recogniser transcribes first: what it loads or computes once is there when a person speaks."""


class ListenNames(NamedTuple):
    """What listens, by name."""

    recogniser: str = "whisper"
    second: str = "pocketsphinx"
    """Empty: none; then no order is agreed on by two."""
    wake_word: str = ""
    echo: bool = True
    """Whether the echo of what is played is subtracted."""


class Recognition(NamedTuple):
    """A listener with the processes behind it, all started."""

    listener: SpeechListener
    processes: tuple[SpeechProcess, ...]

    def wait_ready(self) -> None:
        """Wait until all processes are open.

        Raises:
            UsageError: One cannot be opened; the sentence states what is missing.
        """
        for process in self.processes:
            process.wait_open()

    def close(self) -> None:
        """End all processes; a turn that is open ends with what is known of it, so that a voice waits for no one."""
        ear, *recognisers = self.processes
        ear.close()
        self.listener.end()
        for recogniser in recognisers:
            recogniser.close()


def check_names(names: ListenNames) -> None:
    """Whether recognisers of these names may listen together; none of them is loaded.

    Raises:
        UsageError: There is none of a name, or the first is one that can only agree, or both are one.
    """
    first, second = (split_options(each)[0] for each in (names.recogniser, names.second))
    for name in (first, second)[: 1 + bool(names.second)]:
        known("recogniser", name)
    if first in AGREES_ONLY:
        raise UsageError(f"the recogniser '{first}' takes any sound for a phrase: it may be the second, which agrees")
    if names.recogniser == names.second:
        raise UsageError(f"'{names.second}' as the second recogniser agrees with itself: name another, or none")


def open_recognition(
    names: ListenNames,
    settings: ListenSettings,
    *,
    on_transcript: Callable[[Transcript], object],
    on_present: Callable[[float], object] = lambda at: None,
    on_fault: Callable[[str], object] | None = None,
) -> Recognition:
    """Start what listens; returns at once.

    Args:
        names: The names of the recognisers and the wake word; `NAME` or `NAME:KEY=VALUE,…`.
        settings: The phrases that are expected, and times.
        on_transcript: See `SpeechListener`.
        on_present: See `SpeechListener`.
        on_fault: Called with a sentence each time one of the processes ended, hung or could not be opened; None: it is
            logged.

    Raises:
        UsageError: See `check_names`.
    """
    check_names(names)
    settings = settings._replace(needs_wake_word=bool(names.wake_word))
    ear = SpeechProcess(
        "ear", "ear", {"wake_word": names.wake_word, "echo": names.echo}, within_s=5.0, on_fault=on_fault
    )
    recognisers = []
    for given in filter(None, (names.recogniser, names.second)):
        name, options = split_options(given)
        recognisers.append(SpeechProcess("recogniser", name, options, within_s=10.0, on_fault=on_fault))
    processes = (ear, *recognisers)
    for process in processes:
        process.open()
    for recogniser in recognisers:
        order = {"do": "transcribe", "phrases": settings.phrases}
        recogniser.ask(order, (SILENCE,), on_reply=lambda reply: None)
    listener = SpeechListener(ear, *recognisers, settings=settings, on_transcript=on_transcript, on_present=on_present)
    return Recognition(listener, processes)


def split_options(given: str) -> tuple[str, Mapping[str, Any]]:
    """`flite:speaker=rms` as a name and its options.

    Raises:
        UsageError: An option has no value.
    """
    name, _, rest = given.partition(":")
    pairs = [pair.partition("=") for pair in rest.split(",") if pair]
    if lacking := [key for key, sign, _ in pairs if not sign]:
        raise UsageError(f"the option '{lacking[0]}' of '{name}' has no value; write {name}:{lacking[0]}=VALUE")
    return name, {key: value for key, _, value in pairs}

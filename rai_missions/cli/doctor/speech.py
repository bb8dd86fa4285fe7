# SPDX-License-Identifier: Apache-2.0
"""Whether a person can be listened to and be spoken to here: recognisers, voices, and the devices of sound."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping

from rai_missions.cli.doctor.finding import MachineFinding, tried
from rai_missions.errors import install_command
from rai_missions.voice.kind import SpeechSort
from rai_missions.voice.process import SpeechProcess

__all__ = ("microphone", "speech")

OPEN_S = 60.0
LISTENERS: tuple[tuple[SpeechSort, str, Mapping[str, str], str], ...] = (
    ("ear", "ear", {}, "turns of speech, and our own voice subtracted"),
    ("recogniser", "whisper", {}, "what is spoken"),
    ("recogniser", "pocketsphinx", {}, "the second recogniser, which agrees on orders"),
)
WAKE: tuple[SpeechSort, str, Mapping[str, str], str] = ("ear", "ear", {"wake_word": "okay_nabu"}, "wake words")
VOICES = ("flite", "espeak")
OPENED = "the default microphone and speaker, opened together at 16 kHz"
CLIPPED_SHARE = 0.001
OPTIONAL = {
    "piper": "(GPL-3.0-or-later), and name a model",
    "kokoro": "(GPL-3.0-or-later parts), and name its weights",
}


def speech() -> Iterator[MachineFinding]:
    """Open everything that listens and speaks, each in a process of its own, and list the devices."""
    for sort, name, options, what in LISTENERS:
        why = why_absent(sort, name, options)
        title = f"{sort} ({what})" if sort == name else f"{sort} {name} ({what})"
        yield MachineFinding("missing" if why else "ok", title, why)
    why = why_absent(*WAKE[:3])
    yield MachineFinding("absent" if why else "ok", WAKE[3], why)
    lacking = {name: why for name in VOICES if (why := why_absent("voice", name, {}))}
    for name in VOICES:
        if name in lacking:
            is_needed = len(lacking) == len(VOICES)
            yield MachineFinding("missing" if is_needed else "absent", f"voice {name}", lacking[name])
        else:
            yield MachineFinding("ok", f"voice {name}")
    for name, more in OPTIONAL.items():
        yield MachineFinding("absent", f"voice {name}", f"{install_command(f'voice-{name}')} {more}")
    yield from _devices()


def why_absent(sort: SpeechSort, name: str, options: Mapping[str, str]) -> str:
    """Why one cannot be opened here; empty if it can."""
    process = SpeechProcess(sort, name, options)
    process.open()
    try:
        if process.wait_ready(OPEN_S):
            return ""
        return process.absent or f"it did not open within {OPEN_S:g} s, or crashed"
    finally:
        process.close()


def _devices() -> Iterator[MachineFinding]:
    found = tried("sound_devices", None, os.environ)
    if found.fault:
        yield MachineFinding("absent", "devices of sound", found.fault)
        return
    for title, place in (("microphone", 1), ("speaker", 2)):
        names = [f"'{device[0]}'" for device in found.value if device[place] > 0]
        remedy = "" if names else "files and topics need none"
        yield MachineFinding("ok" if names else "absent", f"{title}s: {', '.join(names) or 'none'}", remedy)
    if all(any(device[place] > 0 for device in found.value) for place in (1, 2)):
        opened = tried("microphone_level", None, os.environ)
        yield MachineFinding("absent", OPENED, opened.fault) if opened.fault else microphone(*opened.value)


def microphone(samples: int, loudest: int, clipped: int) -> MachineFinding:
    """What is found of the default microphone, from what it records."""
    if not samples:
        return MachineFinding("warns", OPENED, "no sound comes; the sound system may hang, or a program may hold it")
    if not loudest:
        return MachineFinding("warns", OPENED, "each sample is 0; the microphone may be muted")
    if clipped > CLIPPED_SHARE * samples:
        share = f"{100 * clipped / samples:.1f} % of the sound is clipped"
        return MachineFinding("warns", OPENED, f"{share}; words are lost so: turn the microphone down")
    return MachineFinding("ok", f"{OPENED}: {20 * math.log10(loudest / 32768):.0f} dB of full scale at most")

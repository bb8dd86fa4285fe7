# SPDX-License-Identifier: Apache-2.0
"""eSpeak NG by the wheel `espeakng-loader`: a voice for machines without root; the only door to it.

Licence: eSpeak NG is under GPL-3.0-or-later, therefore an extra of its own, which no other extra brings along.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from typing import Any

from rai_missions.connectors.sound.wav import converted
from rai_missions.errors import UsageError, install_command
from rai_missions.voice.absent import absent

__all__ = ("Espeak",)

SYNCHRONOUS, NO_EXIT, UTF8 = 2, 0x8000, 1
RATE, WORDS_A_MINUTE = 1, 160

SPEAKING = threading.Lock()
"""A process has one library, with one language and one callback: one sentence at a time."""
Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)


class Espeak:
    """The library in one language.

    Args:
        language: As eSpeak NG names it, such as en-us or de.

    Raises:
        UsageError: It is not installed, or has no such language.
    """

    def __init__(self, language: str = "en-us") -> None:
        try:
            import espeakng_loader as loader
        except ImportError:
            raise absent("the voice 'espeak'", "espeakng-loader", install_command("voice-espeak")) from None
        self._library = ctypes.CDLL(loader.get_library_path())
        self._sound: list[bytes] = []
        self._language = language.encode()
        self._callback = Callback(self._take)  # kept: the library calls it
        self._rate = self._library.espeak_Initialize(SYNCHRONOUS, 0, str(loader.get_data_path()).encode(), NO_EXIT)
        if self._rate <= 0:
            raise UsageError("eSpeak NG does not start: its data is not where its package puts it")
        if self._library.espeak_SetVoiceByName(self._language):
            raise UsageError(f"eSpeak NG has no language '{language}'; give one such as en-us or de")

    def speak(self, text: str) -> Iterator[bytes]:
        """See `Voice`."""
        words = text.encode() + b"\0"
        with SPEAKING:
            self._sound.clear()
            self._library.espeak_SetSynthCallback(self._callback)
            self._library.espeak_SetVoiceByName(self._language)
            self._library.espeak_SetParameter(RATE, WORDS_A_MINUTE, 0)
            failed = self._library.espeak_Synth(words, len(words), 0, 0, 0, UTF8, None, None)
            sound = b"".join(self._sound)
        if failed or not sound:
            raise UsageError(f"eSpeak NG made no sound (error {failed})")
        yield converted(sound, self._rate)

    def _take(self, samples: Any, count: int, _events: int | None) -> int:
        if samples and count > 0:
            self._sound.append(ctypes.string_at(samples, 2 * count))
        return 0

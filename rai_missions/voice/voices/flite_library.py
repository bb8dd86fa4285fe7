# SPDX-License-Identifier: Apache-2.0
"""flite as a library that stays loaded, the only door to it: sound comes while the sentence is still being made.

Source: flite 2.2, `cst_voice.h`, `cst_audio.h`, `cst_wave.h`, `flite.h`: the structures and functions used here.
"""

from __future__ import annotations

import ctypes
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.errors import UsageError

__all__ = ("FliteLibrary",)

PARTS = ("flite", "flite_usenglish", "flite_cmulex")
FIRST_BYTES, MOST_BYTES = RATE_HZ // 2, 2 * RATE_HZ
"""Bytes of a piece: the first has 250 ms, each other twice as much as the one before it, up to a second."""
LEAST_SAMPLES = 256
"""The least number of samples that the library gives at a time."""
CONTINUE, STOP = 0, -1


class _Wave(ctypes.Structure):
    """`cst_wave`."""

    _fields_ = (
        ("type", ctypes.c_char_p),
        ("sample_rate", ctypes.c_int),
        ("num_samples", ctypes.c_int),
        ("num_channels", ctypes.c_int),
        ("samples", ctypes.c_void_p),
    )


_OnSound = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.POINTER(_Wave), ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_void_p
)
"""Is given the sound so far, where the next samples begin, how many they are, whether they are the last."""


class _StreamingInfo(ctypes.Structure):
    """`cst_audio_streaming_info`."""

    _fields_ = (
        ("min_buffsize", ctypes.c_int),
        ("asc", _OnSound),
        ("utt", ctypes.c_void_p),
        ("item", ctypes.c_void_p),
        ("userdata", ctypes.c_void_p),
    )


class _Voice(ctypes.Structure):
    """The beginning of `cst_voice`."""

    _fields_ = (("name", ctypes.c_char_p), ("features", ctypes.c_void_p))


VOICE = ctypes.POINTER(_Voice)
REGISTER = ctypes.CFUNCTYPE(VOICE, ctypes.c_char_p)
SPEAK_FILE = ctypes.CFUNCTYPE(ctypes.c_float, ctypes.c_char_p, VOICE, ctypes.c_char_p)
NEW_STREAMING = ctypes.CFUNCTYPE(ctypes.POINTER(_StreamingInfo))
STREAMING_VALUE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.POINTER(_StreamingInfo))
SET_FEATURE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
SPEAKING = threading.Lock()
"""A process has one voice of each speaker, and flite is not for several threads: one sentence at a time."""


class FliteLibrary:
    """One speaker; not for several threads.

    Args:
        speaker: One whose sound has 16 kHz.

    Raises:
        OSError: The libraries are not installed.
        AttributeError: They are of another version.
    """

    def __init__(self, speaker: str) -> None:
        library, *_ = [_loaded(part) for part in PARTS]
        register = REGISTER((f"register_cmu_us_{speaker}", _loaded(f"flite_cmu_us_{speaker}")))
        library.flite_init()
        self._voice = register(None)
        self._speak = SPEAK_FILE(("flite_file_to_speech", library))
        self._new_streaming = NEW_STREAMING(("new_audio_streaming_info", library))
        self._as_value = STREAMING_VALUE(("audio_streaming_info_val", library))
        self._set_feature = SET_FEATURE(("feat_set", library))
        self._on_sound = _OnSound(self._take)  # kept: the library has its address alone
        self._pieces: SimpleQueue[bytes | None] = SimpleQueue()
        self._sound, self._size = bytearray(), FIRST_BYTES
        self._is_given_up = self._is_odd = False

    def speak(self, text: str) -> Iterator[bytes]:
        """See `Voice`: a thread makes the sound while the pieces before it are used.

        Raises:
            UsageError: The sound has not 16 kHz, or several channels.
        """
        self._pieces, self._sound, self._size = SimpleQueue(), bytearray(), FIRST_BYTES
        self._is_given_up = self._is_odd = False
        thread = threading.Thread(target=self._make, args=(text,), name="flite", daemon=True)
        thread.start()
        try:
            yield from iter(self._pieces.get, None)
        finally:
            self._is_given_up = True
            thread.join()
        if self._is_odd:
            raise UsageError("flite made sound that is not of 16 kHz on one channel")

    def _make(self, text: str) -> None:
        try:
            with tempfile.TemporaryDirectory() as folder:
                words = Path(folder, "text")
                words.write_text(text + "\n", encoding="utf-8")
                with SPEAKING:
                    self._give_to_us()
                    self._speak(bytes(words), self._voice, b"stream")
            if self._sound:
                self._pieces.put(bytes(self._sound))
        finally:
            self._pieces.put(None)

    def _give_to_us(self) -> None:
        """Have the speaker's voice call this object back, and none that had it before.

        The structure is the library's: it frees the one that this one replaces.
        """
        streaming = self._new_streaming()
        streaming[0] = _StreamingInfo(LEAST_SAMPLES, self._on_sound)
        self._set_feature(self._voice.contents.features, b"streaming_info", self._as_value(streaming))

    def _take(self, wave: Any, start: int, count: int, _is_last: int, _streaming: int | None) -> int:
        sound = wave.contents
        self._is_odd |= sound.sample_rate != RATE_HZ or sound.num_channels != 1
        if self._is_given_up or self._is_odd:
            return STOP
        self._sound += ctypes.string_at(sound.samples + 2 * start, 2 * count)
        if len(self._sound) >= self._size:
            self._pieces.put(bytes(self._sound))
            self._sound, self._size = bytearray(), min(MOST_BYTES, 2 * self._size)
        return CONTINUE


def _loaded(name: str) -> Any:
    return ctypes.CDLL(f"lib{name}.so.1", mode=ctypes.RTLD_GLOBAL)

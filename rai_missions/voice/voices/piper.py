# SPDX-License-Identifier: Apache-2.0
"""Piper, a neural voice, with a voice that the user names; the only door to it.

Licence: piper-tts is under GPL-3.0-or-later and its voices have licences of their own, therefore an extra of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rai_missions.connectors.sound.wav import converted
from rai_missions.errors import UsageError, install_command
from rai_missions.voice.absent import absent

__all__ = ("Piper",)


class Piper:
    """A voice of Piper.

    Args:
        model: Its file, which ends in `.onnx`, with its `.onnx.json` next to it.

    Raises:
        UsageError: It is not installed, or no voice is given.
    """

    def __init__(self, model: str = "") -> None:
        try:
            from piper import PiperVoice
        except ImportError:
            raise absent("the voice 'piper'", "piper-tts", install_command("voice-piper")) from None
        if not Path(model).is_file():
            raise UsageError(
                f"piper needs a voice: give model=FILE.onnx, not '{model}' (python -m piper.download_voices)"
            )
        self._voice = PiperVoice.load(model)

    def speak(self, text: str) -> Iterator[bytes]:
        """See `Voice`."""
        for chunk in self._voice.synthesize(text):
            yield converted(chunk.audio_int16_bytes, chunk.sample_rate, chunk.sample_channels, "piper's sound")

# SPDX-License-Identifier: Apache-2.0
"""Kokoro, a neural voice by ONNX, with weights that the user names; the only door to it.

Licence: its weights are under Apache-2.0, its package under MIT; the phonemizer that it needs is under
GPL-3.0-or-later, therefore an extra of its own.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from rai_missions.connectors.sound.wav import converted
from rai_missions.errors import UsageError, install_command
from rai_missions.voice.absent import absent

__all__ = ("Kokoro",)


class Kokoro:
    """A speaker of Kokoro.

    Args:
        model: The file of the network, `kokoro-v1.0.onnx`.
        voices: The file of the speakers, `voices-v1.0.bin`.
        speaker: One of them.

    Raises:
        UsageError: It is not installed, or no weights are given.
    """

    def __init__(self, model: str = "", voices: str = "", speaker: str = "af_heart") -> None:
        os.environ["ORT_DISABLE_TELEMETRY"] = "1"  # onnxruntime reports to its maker, from its import on
        try:
            from kokoro_onnx import Kokoro as Network
        except ImportError:
            raise absent("the voice 'kokoro'", "kokoro-onnx", install_command("voice-kokoro")) from None
        for name, file in (("model", model), ("voices", voices)):
            if not Path(file).is_file():
                raise UsageError(f"kokoro needs its weights: give {name}=FILE, not '{file}'")
        self._network, self._speaker = Network(model, voices), speaker

    def speak(self, text: str) -> Iterator[bytes]:
        """See `Voice`."""
        import numpy as np

        samples, rate = self._network.create(text, voice=self._speaker, lang="en-us")
        sound = np.clip(np.asarray(samples) * 32767, -32768, 32767).astype("<i2").tobytes()
        yield converted(bytes(sound), int(rate), 1, "kokoro's sound")

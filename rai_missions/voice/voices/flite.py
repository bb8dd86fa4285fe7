# SPDX-License-Identifier: Apache-2.0
"""flite, a small voice that Debian has: its library where that loads, otherwise the program, once a sentence."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rai_missions.connectors.sound.wav import read_wav
from rai_missions.errors import UsageError, install_command
from rai_missions.redaction import cut
from rai_missions.voice.absent import absent
from rai_missions.voice.voices.flite_library import FliteLibrary

__all__ = ("Flite", "open_voice")

SPEAKERS = ("slt", "rms", "awb", "kal", "kal16")
STREAMED = ("slt", "rms", "awb", "kal16")
"""The voices whose sound has 16 kHz: it is taken from the library as it is made."""
WITHIN_S = 30.0


def open_voice(speaker: str = "slt") -> Flite | FliteLibrary:
    """flite, with one of its speakers.

    Raises:
        UsageError: It is not installed, or has no such speaker.
    """
    program = Flite(speaker)
    if speaker in STREAMED:
        try:
            return FliteLibrary(speaker)
        except (OSError, AttributeError):  # another version, or a system that has the program alone
            return program
    return program


class Flite:
    """The program `flite`.

    Args:
        speaker: slt, rms, awb, kal or kal16.
    """

    def __init__(self, speaker: str = "slt") -> None:
        if speaker not in SPEAKERS:
            raise UsageError(f"flite has no speaker '{speaker}'; there is: {', '.join(SPEAKERS)}")
        program = shutil.which("flite")
        if program is None:
            without_root = f"without root take the voice 'espeak': {install_command('voice-espeak')}"
            remedy = f"on Debian: apt-get install flite; {without_root}"
            raise absent("the voice 'flite'", "the program flite", remedy)
        self._program, self._speaker = program, speaker

    def speak(self, text: str) -> Iterator[bytes]:
        """See `Voice`."""
        with tempfile.TemporaryDirectory() as folder:
            words, sound = Path(folder, "text"), Path(folder, "sound.wav")
            words.write_text(text + "\n", encoding="utf-8")
            done = subprocess.run(
                [self._program, "-voice", self._speaker, "-f", str(words), "-o", str(sound)],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=WITHIN_S,
                check=False,
            )
            if done.returncode or not sound.exists():
                why = cut(done.stderr.decode(errors="replace").strip() or f"status {done.returncode}", 200)
                raise UsageError(f"flite made no sound ({why})")
            yield read_wav(sound)

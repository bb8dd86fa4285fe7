# SPDX-License-Identifier: Apache-2.0
"""Sound in files: WAV of any usual rate in, 16 kHz mono out.

Rule: a broken file is an error with its path; no sound is made up for what is missing.
"""

from __future__ import annotations

import wave
from pathlib import Path
from typing import Any

from rai_missions.connectors.sound.connector import RATE_HZ
from rai_missions.errors import UsageError, install_command, irregular, make_folder_of
from rai_missions.redaction import cut

__all__ = ("check_wav_name", "converted", "read_wav", "write_wav")

LONGEST_S = 3600.0
"""Longer files are refused: a part of an hour is 115 MB."""
RATES_HZ = (4_000, 192_000)


def read_wav(path: Path | str) -> bytes:
    """A WAV file as 16 kHz mono samples.

    Raises:
        UsageError: There is none, it is broken or too long, or its format is not known.
    """
    if what := irregular(path):
        raise UsageError(f"{path} is {what}, no WAV file")
    try:
        with wave.open(str(path)) as file:
            width, channels, rate, count = (
                file.getsampwidth(),
                file.getnchannels(),
                file.getframerate(),
                file.getnframes(),
            )
            most = int(LONGEST_S * max(rate, 1))
            data = file.readframes(min(count, most) + 1)  # what a program wrote into a pipe has no count that is true
    except FileNotFoundError:
        raise UsageError(f"there is no file {path}") from None
    except (wave.Error, EOFError, OSError, RuntimeError, ValueError) as error:
        why = cut(str(error) or "it is cut short", 200)  # wave gives no text where a piece ends beyond the file
        raise UsageError(f"{path} is no WAV file that can be read ({why}); give PCM, 16 bits") from None
    if width != 2:
        raise UsageError(f"{path} has {8 * width} bits a sample; give PCM, 16 bits")
    _check_form(rate, channels, str(path))
    if len(data) > most * width * channels:
        raise UsageError(f"{path} is longer than an hour; give a shorter file")
    if len(data) < count * width * channels:
        raise UsageError(f"{path} is cut short: {len(data) // (width * channels)} of {count} samples are there")
    return converted(data, rate, channels, str(path))


def converted(data: bytes, rate: int, channels: int = 1, what: str = "the sound") -> bytes:
    """16-bit samples of any usual rate as 16 kHz mono.

    Args:
        data: Little-endian samples, the channels interleaved.
        rate: Of them, in Hz.
        channels: How many there are; their mean is taken.
        what: Names the sound in an error.

    Raises:
        UsageError: The rate or the number of channels is none, or a sample is cut.
    """
    _check_form(rate, channels, what)
    if len(data) % (2 * channels):
        raise UsageError(f"{what} ends within a sample: {len(data)} bytes are no multiple of {2 * channels}")
    if (rate, channels) == (RATE_HZ, 1):
        return data
    np = numpy()
    samples = np.frombuffer(data, "<i2").astype(np.float32).reshape(-1, channels).mean(axis=1)
    if rate != RATE_HZ and len(samples):
        samples = _resampled(samples, RATE_HZ / rate)
    return bytes(np.clip(np.rint(samples), -32768, 32767).astype("<i2").tobytes())


def _check_form(rate: int, channels: int, what: str) -> None:
    low, high = RATES_HZ
    if not low <= rate <= high:
        raise UsageError(f"{what} has a rate of {rate} Hz; {low} to {high} Hz can be read")
    if not 1 <= channels <= 16:
        raise UsageError(f"{what} has {channels} channels; 1 to 16 can be read")


def check_wav_name(path: Path | str) -> None:
    """Whether a file for sound is called what it will be.

    Raises:
        UsageError: Its name has another ending.
    """
    if Path(path).suffix.lower() != ".wav":
        raise UsageError(f"'{path}' does not end in .wav, the form in which sound is written; name it so")


def write_wav(path: Path | str, samples: bytes) -> None:
    """Write 16 kHz mono samples; the folder is made where there is none.

    Raises:
        UsageError: They cannot be written there.
    """
    try:
        make_folder_of(path)
        with open(path, "wb") as raw, wave.open(raw, "wb") as file:
            file.setnchannels(1)
            file.setsampwidth(2)
            file.setframerate(RATE_HZ)
            file.writeframes(samples)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}; name another file") from None


def numpy() -> Any:
    """The module numpy, which sound needs.

    Raises:
        UsageError: It is not installed.
    """
    try:
        import numpy
    except ImportError:
        raise UsageError(f"numpy is needed for sound and is not installed; {install_command('voice')}") from None
    return numpy


def _resampled(samples: Any, ratio: float) -> Any:
    try:
        from samplerate import resample
    except ImportError:
        raise UsageError(
            f"samplerate is needed to convert sound to 16 kHz and is not installed; {install_command('voice')}"
        ) from None
    return resample(samples, ratio, "sinc_medium")

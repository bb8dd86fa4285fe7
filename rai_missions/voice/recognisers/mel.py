# SPDX-License-Identifier: Apache-2.0
"""Whisper's input: the energy in 80 mel bands every 10 ms, as base-10 logarithms.

Source: A. Radford et al., "Robust Speech Recognition via Large-Scale Weak Supervision", 2022, section 2.2; the mel
scale is Slaney's (Auditory Toolbox, 1998).
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray[tuple[int, ...], np.dtype[np.float32]]

__all__ = ("BANDS", "HOP", "mel_features")

RATE_HZ, WINDOW, HOP, BANDS = 16_000, 400, 160, 80
LINEAR_HZ, BREAK_HZ, BREAK_MEL = 200 / 3, 1000.0, 15.0
STEP = np.log(6.4) / 27
"""Above 1 kHz the scale is logarithmic: 27 mels to a factor of 6.4."""
RANGE = 8.0
"""Decades below the loudest that are kept."""
LEAST_POWER = 1e-10


def _bands() -> Array:
    """Triangles of equal area over the frequencies of the spectrum: bands × frequencies."""
    top = BREAK_MEL + np.log(RATE_HZ / 2 / BREAK_HZ) / STEP
    mels = np.linspace(0, top, BANDS + 2)
    edges = np.where(mels < BREAK_MEL, mels * LINEAR_HZ, BREAK_HZ * np.exp(STEP * (mels - BREAK_MEL)))
    widths, away = np.diff(edges), edges[:, None] - np.arange(WINDOW // 2 + 1) * RATE_HZ / WINDOW
    rising, falling = -away[:-2] / widths[:-1, None], away[2:] / widths[1:, None]
    triangles = np.maximum(0, np.minimum(rising, falling)) * (2 / (edges[2:] - edges[:-2]))[:, None]
    return np.asarray(triangles, np.float32)


BAND = _bands()
SHAPE = np.hanning(WINDOW + 1)[:-1].astype(np.float32)


def mel_features(samples: Array, frames: int) -> Array:
    """The features of a sound.

    Args:
        samples: From -1 to 1, at 16 kHz; cut off where it is longer than the frames, filled with silence where shorter.
        frames: How many steps of 10 ms.

    Returns:
        80 bands × `frames`, about -1 to 1.
    """
    used = min(frames, -(-(len(samples) + WINDOW) // HOP))  # those after it are silence
    length = used * HOP
    sound = np.zeros(length, np.float32)
    sound[: min(len(samples), length)] = samples[:length]
    sound = np.pad(sound, WINDOW // 2, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(sound, WINDOW)[::HOP][:used] * SHAPE
    power = np.abs(np.fft.rfft(windows, axis=1)).astype(np.float32) ** 2
    bands = np.full((BANDS, frames), np.log10(LEAST_POWER), np.float32)
    bands[:, :used] = np.log10(np.maximum(BAND @ power.T, LEAST_POWER))
    return np.asarray((np.maximum(bands, np.max(bands) - RANGE) + 4.0) / 4.0, np.float32)

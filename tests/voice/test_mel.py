# SPDX-License-Identifier: Apache-2.0
"""Whisper's input: laws over any sound."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.voice.recognisers.mel import HOP, mel_features

STEPS = 40


@given(st.integers(0, STEPS * HOP + 500), st.integers(0, 2000), st.integers(0, 2**32 - 1))
def test_silence_after_a_sound_changes_none_of_its_features(count: int, silence: int, seed: int) -> None:
    sound = np.random.default_rng(seed).normal(0.0, 0.1, count).astype(np.float32)
    longer = np.concatenate([sound, np.zeros(silence, np.float32)])
    assert mel_features(sound, STEPS) == pytest.approx(mel_features(longer, STEPS), abs=1e-5)
    assert mel_features(sound, STEPS).shape == (80, STEPS)

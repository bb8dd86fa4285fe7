# SPDX-License-Identifier: Apache-2.0
"""What the doctor makes of a second of sound from the microphone."""

from __future__ import annotations

import pytest

from rai_missions.cli.doctor.speech import microphone


@pytest.mark.parametrize(
    ("samples", "loudest", "clipped", "status", "words"),
    [
        (0, 0, 0, "warns", "no sound comes"),
        (16_384, 0, 0, "warns", "each sample is 0"),
        (16_384, 1, 0, "ok", "-90 dB"),
        (16_384, 32_767, 16, "ok", "0 dB"),
        (16_384, 32_768, 17, "warns", "0.1 % of the sound is clipped"),
        (16_384, 32_768, 16_384, "warns", "100.0 % of the sound is clipped"),
    ],
)
def test_a_microphone_that_lacks_sound_or_has_too_much_is_named(
    samples: int, loudest: int, clipped: int, status: str, words: str
) -> None:
    found = microphone(samples, loudest, clipped)
    assert found.status == status
    assert words in str(found)

# SPDX-License-Identifier: Apache-2.0
"""Whisper's evidence for phrases, by the real model."""

from __future__ import annotations

import pytest

from rai_missions.voice.recognisers.whisper import open_recogniser
from tests.voice.conftest import needs_voice, quiet, spoken

pytestmark = [needs_voice, pytest.mark.xdist_group("voice")]


def test_evidence_depends_little_on_how_much_quiet_follows() -> None:
    whisper = open_recogniser(threads=1)
    word = quiet(0.1) + spoken("Top.")[: 2 * 16_000 * 35 // 100]
    found = [
        whisper.transcribe((word + quiet(1.0))[: 2 * 320 * steps], ("stop", "yes")).evidence
        for steps in (28, 29, 30, 31)
    ]
    for each in ("stop", "yes"):
        values = [evidence[each] for evidence in found]
        assert max(values) - min(values) < 2.0, values

# SPDX-License-Identifier: Apache-2.0
"""Whisper's evidence for phrases, by the real model."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.voice.recognisers.whisper import once, open_recogniser
from tests.voice.conftest import needs_voice, quiet, spoken

WORDS = st.lists(st.sampled_from(["stop", "no", "the", "mission"]), min_size=1, max_size=4)


@given(WORDS, st.integers(3, 9), st.integers(0, 3))
def test_words_that_are_repeated_to_the_end_are_read_once(words: list[str], times: int, more: int) -> None:
    read = once(" ".join(words * times + words[:more]))
    assert read.split() == words or len(read.split()) < len(words), "fewer where the words repeat themselves"
    assert once(read) in (read, once(" ".join(words)))


@given(WORDS)
def test_other_words_stay(words: list[str]) -> None:
    assert once(" ".join([*words, "else"])) == " ".join([*words, "else"])
    assert once("Stop, stop! Stop") == "Stop,"


@needs_voice
@pytest.mark.xdist_group("voice")
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

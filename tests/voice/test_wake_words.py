# SPDX-License-Identifier: Apache-2.0
"""A wake word before, within and after what a person speaks: which words count, and that stop needs none.

A frame has how probable speech is, whether the wake word has just been spoken, and the letter that it sounds like: the
ear and the recogniser read them from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SoundFrame
from rai_missions.voice.listener import ListenSettings, SpeechListener, Transcript
from rai_missions.voice.process import SpeechProcess
from rai_missions.voice.setup import Recognition

PACKAGE = """
from rai_missions.connectors.sound.connector import FRAME_BYTES
from rai_missions.voice.kind import EarReading, Reading

class WrittenEar:
    def take(self, recorded, played):
        return EarReading(recorded[0] / 100, recorded[1] / 100, recorded, recorded)

class Spelling:
    def transcribe(self, samples, phrases):
        return Reading("".join(chr(samples[at + 2]) for at in range(0, len(samples), FRAME_BYTES) if samples[at]))
"""
OFFERS = """[rai_missions.ears]
written = written_ear:WrittenEar
[rai_missions.recognisers]
spelling = written_ear:Spelling
"""
QUIET = bytes(FRAME_BYTES)
PAUSE = [QUIET] * 13


def letters(text: str) -> list[bytes]:
    """A frame a letter; at a capital the wake word has just been spoken."""
    return [bytes([90, 90 * each.isupper(), ord(each.lower())]).ljust(FRAME_BYTES, b"\0") for each in text]


class Scene:
    """A listener that needs a wake word, and what it gives."""

    def __init__(self) -> None:
        self._ear, self._words = SpeechProcess("ear", "written"), SpeechProcess("recogniser", "spelling")
        for process in (self._ear, self._words):
            process.open()
            process.wait_open()
        self._count, self.found = 0, list[Transcript]()
        settings = ListenSettings(needs_wake_word=True)
        self._listener = SpeechListener(
            self._ear, self._words, settings=settings, on_transcript=lambda each: self.found.append(each)
        )

    def texts(self, *frames: bytes) -> list[str]:
        """What the turns in the next frames become."""
        before = len(self.found)
        for frame in frames:
            self._listener.take(SoundFrame(self._count * FRAME_S, frame, QUIET))
            self._count += 1
        assert self._listener.catch_up(20)
        return [each.text for each in self.found[before:]]

    def close(self) -> None:
        Recognition(self._listener, (self._ear, self._words)).close()


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene]:
    (tmp_path / "written_ear.py").write_text(PACKAGE)
    data = tmp_path / "written_ear-1.0.dist-info"
    data.mkdir()
    (data / "METADATA").write_text("Metadata-Version: 2.1\nName: written-ear\nVersion: 1.0\n")
    (data / "entry_points.txt").write_text(OFFERS)
    monkeypatch.syspath_prepend(str(tmp_path))
    found = Scene()
    yield found
    found.close()


def test_words_without_a_wake_word_count_for_nothing_but_stop(scene: Scene) -> None:
    assert scene.texts(*letters("hello"), *PAUSE, *letters("stop"), *PAUSE, *letters("fine"), *PAUSE) == [
        "",
        "stop",
        "",
    ]


def test_what_follows_a_wake_word_within_8_s_counts_and_what_follows_that(scene: Scene) -> None:
    scene.texts(*letters("nabU"), *PAUSE)
    later = *[QUIET] * 200, *letters("hello"), *PAUSE, *[QUIET] * 200, *letters("fine"), *PAUSE
    assert scene.texts(*later, *[QUIET] * 260, *letters("hello"), *PAUSE) == ["hello", "fine", ""]


@pytest.mark.parametrize("before", ["nab", "cancelnab", "stopsignsnab"])
@pytest.mark.parametrize("word", ["UUu", "UuuU"])
def test_a_wake_word_within_a_sentence_begins_it(scene: Scene, before: str, word: str) -> None:
    """The word is sure in some frames, also with others between, of which the first is the one that counts."""
    assert scene.texts(*letters(f"{before}{word}helloyou"), *PAUSE) == [f"{word.lower()}helloyou"]
    assert scene.found[0].began == pytest.approx((len(before) + 1) * FRAME_S), "the person addressed the robot then"


def test_a_pause_before_the_wake_word_leaves_nothing_of_the_words_before(scene: Scene) -> None:
    assert scene.texts(*letters("cancel"), *[QUIET] * 6, *letters("nabUhelloyou"), *PAUSE) == ["uhelloyou"]


@pytest.mark.parametrize("end", ["", "uuu", "uuuuuuu"])
def test_a_wake_word_alone_is_no_sentence(scene: Scene, end: str) -> None:
    """It may be sure before its end, which is speech as well: shorter than any word behind it."""
    assert scene.texts(*letters(f"nabU{end}"), *PAUSE, *letters("hello"), *PAUSE) == ["", "hello"]
    assert scene.found[0].readings == ()


def test_a_wake_word_that_is_spoken_again_begins_the_sentence_again(scene: Scene) -> None:
    assert scene.texts(*letters("nabU"), *letters("cancel" * 4), *letters("nabUhelloyou"), *PAUSE) == ["uhelloyou"]

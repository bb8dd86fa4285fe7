# SPDX-License-Identifier: Apache-2.0
"""A person who speaks again while the turn before is still transcribed: the robot is quiet, and knows what came first.

The ear reads how probable speech and the wake word are from the frame itself, and the recogniser has the words that the
test writes into a pipe, once it does: so the order of all that happens is the test's.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SoundFrame
from rai_missions.testing import Inbox
from rai_missions.voice.listener import SpeechListener, Transcript
from rai_missions.voice.process import SpeechProcess
from rai_missions.voice.setup import Recognition

PACKAGE = """
import os
from rai_missions.voice.kind import EarReading, Reading

class LevelEar:
    def take(self, recorded, played):
        if recorded[2]:
            os.abort()
        return EarReading(recorded[0] / 100, recorded[1] / 100, recorded, recorded)

class PipedWords:
    def __init__(self, pipe):
        self._pipe = pipe
    def transcribe(self, samples, phrases):
        with open(self._pipe) as words:
            text = words.readline().strip()
        if text == "crash":
            os.abort()
        return Reading(text)
"""
OFFERS = """[rai_missions.ears]
level = piped_words:LevelEar
[rai_missions.recognisers]
piped = piped_words:PipedWords
"""
SPEECH, WOKEN, QUIET, DEADLY = (bytes(each).ljust(FRAME_BYTES, b"\0") for each in ([90], [90, 90], [], [0, 0, 1]))


class Reported(NamedTuple):
    """What a listener reports: `present`, or a text."""

    what: str
    turn: int = 0
    began: float = 0.0
    given: float = 0.0


class Scene:
    """A listener, the frames that it is given, and the words that its recogniser finds."""

    def __init__(self, pipe: Path) -> None:
        self._pipe, self._frames = pipe, 0
        os.mkfifo(pipe)
        self.found, self.faults = Inbox[Reported](), Inbox[str]()
        self._ear = SpeechProcess("ear", "level", on_fault=self.faults)
        self._words = SpeechProcess("recogniser", "piped", {"pipe": str(pipe)}, on_fault=self.faults)
        for process in (self._ear, self._words):
            process.open()
            process.wait_open()
        self.listener = SpeechListener(
            self._ear, self._words, on_transcript=self._take, on_present=lambda at: self.found(Reported("present"))
        )

    def _take(self, found: Transcript) -> None:
        self.found(Reported(found.text, found.turn, found.began, found.given))

    def frames(self, *frames: bytes) -> None:
        """The next frames, looked at."""
        looked_at = threading.Event()
        for frame in frames:
            self.listener.take(SoundFrame(self._frames * FRAME_S, frame, QUIET))
            self._frames += 1
        self._ear.ask({"do": "take"}, (QUIET, QUIET), on_reply=lambda reply: looked_at.set())
        assert looked_at.wait(20)

    def words(self, text: str) -> None:
        """What the recogniser finds in the sound that it has."""
        self._pipe.write_text(f"{text}\n")

    def wait(self, count: int) -> list[Reported]:
        return self.found.wait(lambda all_: len(all_) >= count, f"{count} things are reported")

    def close(self) -> None:
        Recognition(self.listener, (self._ear, self._words)).close()


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene]:
    (tmp_path / "piped_words.py").write_text(PACKAGE)
    data = tmp_path / "piped_words-1.0.dist-info"
    data.mkdir()
    (data / "METADATA").write_text("Metadata-Version: 2.1\nName: piped-words\nVersion: 1.0\n")
    (data / "entry_points.txt").write_text(OFFERS)
    monkeypatch.syspath_prepend(str(tmp_path))
    found = Scene(tmp_path / "pipe")
    yield found
    found.close()


def test_a_transcript_of_the_turn_before_leaves_a_person_present_who_speaks_again(scene: Scene) -> None:
    scene.frames(*[SPEECH] * 5, *[QUIET] * 13, *[SPEECH] * 5)
    assert [each.what for each in scene.wait(2)] == ["present", "present"]
    scene.words("good morning")
    assert [each.what for each in scene.wait(4)[2:]] == ["good morning", "present"]
    scene.frames(*[QUIET] * 13)
    scene.words("how are you")
    assert [each.what for each in scene.wait(5)[4:]] == ["how are you"], "and they have finished"


def test_a_person_who_speaks_on_after_a_stop_that_was_given_at_once_is_present_again(scene: Scene) -> None:
    scene.frames(*[SPEECH] * 5, *[QUIET] * 5)
    scene.words("stop")
    assert [each.what for each in scene.wait(2)] == ["present", "stop"]
    scene.frames(*[SPEECH] * 5)
    assert [each.what for each in scene.wait(3)[2:]] == ["present"]


def test_a_wake_word_alone_waits_for_what_was_spoken_before_it(scene: Scene) -> None:
    """It has no words, so nothing of it is transcribed: a "stop" before it that is still transcribed was lost."""
    scene.frames(*[SPEECH] * 5, *[QUIET] * 13, *[SPEECH] * 4, WOKEN, *[QUIET] * 13)
    assert [each.what for each in scene.wait(2)] == ["present", "present"]
    scene.words("stop")
    assert [(each.what, each.turn) for each in scene.wait(4)[2:4]] == [("stop", 1), ("", 2)]


def test_a_transcript_has_the_instant_at_which_it_is_given(scene: Scene) -> None:
    scene.frames(*[QUIET] * 10, *[SPEECH] * 5, *[QUIET] * 13, *[QUIET] * 30)
    scene.words("yes")
    found = scene.wait(2)[1]
    assert (found.began, found.given) == (pytest.approx(12 * FRAME_S), pytest.approx(58 * FRAME_S))


def test_a_person_who_speaks_as_the_listening_ends_has_a_transcript_so_that_last_words_are_spoken(scene: Scene) -> None:
    scene.frames(*[SPEECH] * 5)
    assert [each.what for each in scene.wait(1)] == ["present"]
    scene.close()
    assert [each.what for each in scene.wait(2)] == ["present", ""]


@pytest.mark.parametrize(("text", "found"), [("good morning", "good morning"), ("crash", "")])
def test_a_turn_whose_recogniser_ended_is_transcribed_by_the_next_one_once(scene: Scene, text: str, found: str) -> None:
    scene.frames(*[SPEECH] * 5, *[QUIET] * 13)
    scene.words("crash")
    scene.faults.wait(bool, "the recogniser has ended")
    threading.Thread(target=scene.words, args=(text,), daemon=True).start()  # it waits where no recogniser reads
    assert [each.what for each in scene.wait(2)] == ["present", found]


def test_sound_that_is_lost_with_an_ear_is_counted_and_what_was_before_is_transcribed(scene: Scene) -> None:
    scene.frames(*[SPEECH] * 5)
    assert scene.listener.lost_s == 0
    scene.frames(DEADLY)
    scene.faults.wait(bool, "the ear has ended")
    assert scene.listener.lost_s == pytest.approx(FRAME_S)
    scene.words("stop")
    scene.frames(*[SPEECH] * 5)
    assert [each.what for each in scene.wait(3)] == ["present", "stop", "present"]

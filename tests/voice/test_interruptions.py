# SPDX-License-Identifier: Apache-2.0
"""A person who begins to speak, finishes, or only coughs, at any instants: what is played, and how each text ends."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.sound.connector import SILENCE
from rai_missions.voice.process import SpeechProcess
from rai_missions.voice.speaker import Speaker
from rai_missions.voice.spoken_text import SpokenEnd, SpokenText

PACKAGE = """
class TonePerSentence:
    def speak(self, text):
        yield int(text.split()[-1].strip(".")).to_bytes(2, "little") * 1300
"""
SAMPLES = 1300
"""Of a sentence: two frames and a half."""
TEXTS = ("Sentence 1. Sentence 2. Sentence 3.", "Sentence 4. Sentence 5.")
HAPPENS = st.tuples(st.sampled_from(["person", "person", "words", "cough", "cough"]), st.integers(0, 6))
"""What a person does, and how many frames pass after it."""


@pytest.fixture(scope="module")
def voice(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SpeechProcess]:
    folder: Path = tmp_path_factory.mktemp("tones")
    (folder / "tone_voice.py").write_text(PACKAGE)
    data = folder / "tone_voice-1.0.dist-info"
    data.mkdir()
    (data / "METADATA").write_text("Metadata-Version: 2.1\nName: tone-voice\nVersion: 1.0\n")
    (data / "entry_points.txt").write_text("[rai_missions.voices]\ntones = tone_voice:TonePerSentence\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        process = SpeechProcess("voice", "tones")
        process.open()
        process.wait_open()
        yield process
        process.close()


class Played:
    """A speaker that has two texts, and what it played."""

    def __init__(self, voice: SpeechProcess, uncut: tuple[bool, bool]) -> None:
        self._voice = voice
        self.ends = list[tuple[str, SpokenEnd]]()
        self.sound, self.is_person = b"", False
        self.speaker = Speaker(voice, lambda key, how: self.ends.append((key, how)), patience_s=float("inf"))
        for key, text in enumerate(TEXTS):
            self.speaker.speak(SpokenText(str(key), text, uncut=uncut[key]))

    def frames(self, count: int) -> bytes:
        """So many frames at most, until both texts have ended; each once all that may be in it is made."""
        found = b""
        while count and len(self.ends) < len(TEXTS):
            count -= 1
            frame = self.speaker.frame(0.0)
            if not frame:
                for _ in range(3):  # the sentences of a text are made one after the other
                    self._voice.ask_and_wait({"do": "speak", "text": "Sentence 0."})
                frame = self.speaker.frame(0.0)
            found += frame or SILENCE
        self.sound += found
        return found

    def happens(self, what: str) -> None:
        if what == "person":
            self.speaker.interrupt()
            self.is_person = True
        else:
            self.speaker.resume(cut=what == "words")
            self.is_person = False

    def sentences(self) -> list[int]:
        """The sentences that were played whole, in their order."""
        found, samples = list[int](), [self.sound[at] for at in range(0, len(self.sound), 2)]
        while samples:
            run = next((place for place, each in enumerate(samples) if each != samples[0]), len(samples))
            found += [samples[0]] * (run // SAMPLES) if samples[0] else []
            samples = samples[run:]
        return found


def texts_in(sound: bytes) -> set[int]:
    """Which of the texts some sound is of."""
    return {0 if each < 4 else 1 for each in sound[::2] if each}


@given(st.integers(1, 6), st.lists(HAPPENS, min_size=2, max_size=10), st.tuples(st.booleans(), st.booleans()))
@settings(max_examples=40)
@example(6, [("person", 6)], (True, False))
def test_each_text_ends_once_and_whole_unless_words_cut_it(
    voice: SpeechProcess, before: int, happens: list[tuple[str, int]], uncut: tuple[bool, bool]
) -> None:
    played = Played(voice, uncut)
    played.frames(before)
    for what, count in happens:
        now = len(played.ends)
        played.happens(what)
        texts = texts_in(played.frames(count))
        if played.is_person:
            assert texts <= {each for each in (0, 1) if each == now and uncut[each]}, "no text begins next to a person"
    played.happens("cough")
    played.frames(100)
    ends = dict(played.ends)
    assert sorted(ends) == ["0", "1"] and len(played.ends) == 2
    for key, is_uncut in zip("01", uncut, strict=True):
        if is_uncut or "words" not in [what for what, _ in happens]:
            assert ends[key] == "whole"
    due = [each for key, sentences in (("0", (1, 2, 3)), ("1", (4, 5))) if ends[key] == "whole" for each in sentences]
    assert [each for each in dict.fromkeys(played.sentences()) if each in due] == due, "each sentence, and in order"

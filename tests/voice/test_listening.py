# SPDX-License-Identifier: Apache-2.0
"""Speech to text, by the real recognisers, from files and in a simulated room."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rai_missions.connectors.sound.connector import SoundFrame
from rai_missions.connectors.sound.files import FileSound
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.voice.ear import SoundEar
from rai_missions.voice.listener import ListenSettings, SpeechListener, Transcript
from rai_missions.voice.process import SpeechProcess
from rai_missions.voice.setup import ListenNames, Recognition, open_recognition
from rai_missions.voice.turns import TurnDetector, TurnFrame
from tests.voice.conftest import needs_voice, quiet, spoken

pytestmark = [needs_voice, pytest.mark.xdist_group("voice")]


class TranscriptCollector:
    """One recognition, whose transcripts are collected."""

    def __init__(self) -> None:
        self.transcripts: list[Transcript] = []
        self.present: list[float] = []
        self.recognition: Recognition = open_recognition(
            ListenNames(), ListenSettings(), on_transcript=self.transcripts.append, on_present=self.present.append
        )
        self.recognition.wait_ready()

    def of(self, sound: FileSound) -> list[Transcript]:
        """The transcripts of a whole recording, by a listener of its own on the same processes."""
        self.transcripts.clear()
        self.present.clear()
        listener = SpeechListener(
            *self.recognition.processes, on_transcript=self.transcripts.append, on_present=self.present.append
        )
        sound.listen(listener.take)
        sound.start()
        while not sound.over:
            sound.step()
        for _ in range(30):
            sound.step()
        assert listener.finish()
        return [each for each in self.transcripts if each.text]


@pytest.fixture(scope="module")
def collector() -> Iterator[TranscriptCollector]:
    found = TranscriptCollector()
    yield found
    found.recognition.close()


def test_a_sentence_is_transcribed_with_the_times_at_which_it_was_spoken(collector: TranscriptCollector) -> None:
    before, sentence = quiet(1.0), spoken("What are you doing?")
    (found,) = collector.of(FileSound(before + sentence))
    assert found.text == "What are you doing?"
    assert found.readings == (found.text,)
    assert found.began == pytest.approx(1.1, abs=0.3)
    assert found.spoken_until == pytest.approx(1.0 + len(sentence) / 32_000, abs=0.35)
    assert found.at - found.spoken_until == pytest.approx(0.416, abs=0.04)
    assert len(collector.present) == 1


def test_two_recognisers_agree_on_an_order(collector: TranscriptCollector) -> None:
    (found,) = collector.of(FileSound(quiet(0.5) + spoken("Cancel the mission.", "rms")))
    assert (found.text, found.readings[:2]) == ("cancel the mission", ("cancel the mission",) * 2)


def test_stop_is_given_as_soon_as_its_turn_is_settled(collector: TranscriptCollector) -> None:
    recorded = quiet(0.5) + spoken("Stop.", "rms") + quiet(0.5)
    ear, detector, settled, given = SoundEar(), TurnDetector(), list[float](), list[float]()
    listener = SpeechListener(
        *collector.recognition.processes, on_transcript=lambda each: given.append(sound.at) if each.text else None
    )
    sound = FileSound(recorded)

    def look(frame: SoundFrame) -> None:
        reading = ear.take(frame.recorded, frame.played)
        settled.extend(
            event.at
            for event in detector.take(TurnFrame(frame.at, reading.speech, reading.clear, reading.quiet))
            if event.kind == "settled"
        )

    sound.listen(look)
    sound.listen(listener.take)
    sound.start()
    while not sound.over:
        sound.step()
        assert listener.catch_up()
    assert listener.finish()
    assert given == [pytest.approx(each) for each in settled]


def test_sentences_with_a_pause_between_are_turns_of_their_own(collector: TranscriptCollector) -> None:
    found = collector.of(FileSound(quiet(0.5) + spoken("Yes.") + quiet(0.8) + spoken("Where is the kitchen?")))
    assert [each.text for each in found] == ["yes", "Where is the kitchen?"]
    assert [each.turn for each in found] == [1, 2]


def test_without_the_wake_word_a_stop_alone_counts(collector: TranscriptCollector) -> None:
    found = list[Transcript]()
    ear = SpeechProcess("ear", "ear", {"wake_word": "okay_nabu"}, within_s=30.0)
    ear.open()
    listener = SpeechListener(
        ear,
        *collector.recognition.processes[1:],
        settings=ListenSettings(needs_wake_word=True),
        on_transcript=found.append,
    )
    sentences = ("Where are you going?", "Stop.", "What are you doing?", "Okay nah boo.", "Where is the kitchen?")
    sound = FileSound(b"".join(quiet(0.6) + spoken(each, "rms") for each in sentences))
    sound.listen(listener.take)
    sound.start()
    while not sound.over:
        sound.step()
    assert listener.finish()
    ear.close()
    assert [each.text for each in found[:3]] == ["", "stop", ""], "also where the wake word comes before the transcript"
    assert found[-1].text == "Where is the kitchen?"


def test_silence_and_noise_are_no_words(collector: TranscriptCollector) -> None:
    assert collector.of(RoomSound(quiet(3.0), noise=300.0)) == []
    assert collector.of(FileSound(quiet(2.0))) == []


@pytest.mark.parametrize(("echo_db", "delay_ms"), [(-6.0, 20.0), pytest.param(-12.0, 200.0, marks=pytest.mark.long)])
def test_our_own_voice_is_never_transcribed(collector: TranscriptCollector, echo_db: float, delay_ms: float) -> None:
    ours = spoken("The mission has ended. Stop. Cancel the mission.")
    room = RoomSound(quiet(len(ours) / 32_000 + 0.5), echo_db=echo_db, delay_ms=delay_ms)
    pieces = iter(range(0, len(ours), 1024))
    room.play(lambda at: ours[start : start + 1024] if (start := next(pieces, None)) is not None else b"")
    assert collector.of(room) == []
    assert collector.present == [], "and cuts nothing"

# SPDX-License-Identifier: Apache-2.0
"""Text to speech: laws of the queue, and texts that are spoken whole, cut, or not at all, by a real voice."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.agents.text_to_speech import TextToSpeech
from rai_missions.agents.voice_recognition import VoiceRecognition
from rai_missions.connectors.hri.connector import TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.sound.connector import FRAME_S, SILENCE, SoundFrame
from rai_missions.connectors.sound.files import FileSound
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.errors import UsageError
from rai_missions.testing import Inbox, check_agent
from rai_missions.voice.listener import Transcript
from rai_missions.voice.spoken_text import MOST_LETTERS, PRIORITIES, SpeechQueue, SpokenText, sentences
from tests.voice.conftest import needs_voice, spoken

TEXTS = st.lists(st.sampled_from(PRIORITIES), max_size=20)
Ends = Inbox[tuple[str, str]]


@given(TEXTS)
def test_the_most_urgent_text_is_first_and_equal_ones_keep_their_order(priorities: list[str]) -> None:
    queue = SpeechQueue()
    texts = [SpokenText(str(number), "x", priority) for number, priority in enumerate(priorities)]  # type: ignore[arg-type]
    for text in texts:
        queue.add(text)
    taken = [text for text in iter(queue.take, None) if text is not None]
    assert taken == sorted(texts, key=lambda text: PRIORITIES.index(text.priority)), "sorted() is stable"


@given(TEXTS, st.sampled_from(PRIORITIES))
def test_what_is_dropped_and_what_stays_are_all(priorities: list[str], which: str) -> None:
    queue = SpeechQueue()
    for number, priority in enumerate(priorities):
        queue.add(SpokenText(str(number), "x", priority))  # type: ignore[arg-type]
    dropped = queue.drop(lambda text: text.priority == which)
    assert {text.priority for text in dropped} <= {which}
    assert len(dropped) + len(queue) == len(priorities)


@given(st.lists(st.text(alphabet="ab .!?\n", max_size=30)))
def test_sentences_lose_no_letter(texts: list[str]) -> None:
    text = " ".join(texts)
    assert "".join(sentences(text)).replace(" ", "").replace("\n", "").count("a") == text.count("a")


@given(st.text(alphabet="ab \n", min_size=1, max_size=900))
def test_what_is_spoken_in_one_piece_is_short_and_is_divided_between_words(text: str) -> None:
    found = sentences(text)
    assert all(len(each) <= MOST_LETTERS for each in found) or len(text.strip()) <= MOST_LETTERS
    if max(map(len, text.split()), default=0) <= MOST_LETTERS:
        assert [word for each in found for word in each.split()] == text.split()
    assert sentences("a" * 4000) == ["a" * MOST_LETTERS] * (4000 // MOST_LETTERS)


class Stage:
    """A voice that speaks into a recording, on time that the test lets pass."""

    def __init__(self, sound: FileSound, ends: Ends, *, last_words_s: float = 0.0) -> None:
        self.sound, self.ends = sound, ends
        self.frames: list[SoundFrame] = []
        self.agent = TextToSpeech(
            sound, on_end=lambda key, how: ends((key, how)), patience_s=math.inf, last_words_s=last_words_s
        )
        sound.listen(self.frames.append)
        sound.start()

    def pass_until(self, is_so: Callable[[], bool], most_s: float = 600.0) -> None:
        """Let time pass as fast as the voice makes sound."""
        tick = threading.Event()
        for _ in range(int(most_s / FRAME_S)):
            if is_so():
                return
            self.sound.step()
            tick.wait(0.001)
        raise AssertionError(f"not so within {most_s:g} s of sound")

    @property
    def is_loud(self) -> bool:
        return bool(self.frames) and self.frames[-1].played != SILENCE

    def loud_s(self) -> float:
        return sum(frame.played != SILENCE for frame in self.frames) * FRAME_S

    def end_of(self, key: str) -> str:
        return dict(self.ends.all).get(key, "")


@pytest.fixture
def stage() -> Iterator[Stage]:
    found = Stage(FileSound(), Inbox())
    found.agent.run()
    yield found
    found.agent.stop()


@needs_voice
def test_a_text_is_spoken_whole_and_reported_once(stage: Stage) -> None:
    stage.agent.speak(SpokenText("a", "The mission has ended. I am at home."))
    stage.pass_until(lambda: stage.end_of("a") != "")
    assert stage.ends.all == [("a", "whole")]
    assert stage.loud_s() == pytest.approx(2.6, abs=0.6)
    assert not stage.agent.speaking


@needs_voice
@pytest.mark.parametrize(("last_words_s", "how"), [(60.0, "whole"), (0.0, "failed")])
def test_stopped_it_ends_after_its_last_words(last_words_s: float, how: str) -> None:
    stage = Stage(FileSound(), Inbox(), last_words_s=last_words_s)
    stage.agent.run()
    for key in ("a", "b"):
        stage.agent.speak(SpokenText(key, "The mission has ended."))
    stage.pass_until(lambda: stage.is_loud)
    stopping = threading.Thread(target=stage.agent.stop)
    stopping.start()
    stage.pass_until(lambda: not stopping.is_alive())
    assert sorted(stage.ends.all) == [("a", how), ("b", how)]
    assert stage.agent.stop_s > last_words_s


@needs_voice
def test_a_person_who_speaks_cuts_within_a_frame_and_what_waits_follows(stage: Stage) -> None:
    stage.agent.speak(SpokenText("a", "Four of six waypoints are done, and I am driving on to the kitchen."))
    stage.agent.speak(SpokenText("b", "Yes."))
    stage.pass_until(lambda: stage.loud_s() > 1.0)
    stage.agent.interrupt()
    before = len(stage.frames)
    for _ in range(10):
        stage.sound.step()
    assert [frame.played for frame in stage.frames[before:]] == [SILENCE] * 10, "quiet from the next frame on"
    assert stage.ends.all == []
    stage.agent.resume(cut=True)
    stage.pass_until(lambda: stage.end_of("b") != "")
    assert stage.ends.all == [("a", "cut"), ("b", "whole")]


@needs_voice
def test_after_a_false_alarm_the_sentence_is_spoken_again(stage: Stage) -> None:
    stage.agent.speak(SpokenText("a", "I am at home. The battery is at sixty percent."))
    stage.pass_until(lambda: stage.loud_s() > 1.6)
    stage.agent.interrupt()
    stage.agent.resume(cut=False)
    stage.pass_until(lambda: stage.end_of("a") != "")
    whole = len(spoken("I am at home.") + spoken("The battery is at sixty percent.")) / 32_000
    assert stage.ends.all == [("a", "whole")]
    assert whole - 0.5 < stage.loud_s() < whole + 2.0, "a sentence was repeated, not the whole text"


@needs_voice
def test_what_is_uncut_stops_for_a_total_silence_alone(stage: Stage) -> None:
    stage.agent.speak(SpokenText("a", "The mission has ended, and everything is at its place.", "end", uncut=True))
    stage.agent.speak(SpokenText("b", "By the way, the sun is shining.", "chatter"))
    stage.pass_until(lambda: stage.loud_s() > 0.5)
    stage.agent.interrupt()
    stage.sound.step()
    assert stage.is_loud
    stage.agent.resume(cut=True)
    stage.agent.silence(is_total=False)
    assert stage.ends.all == [("b", "cut")]
    stage.agent.silence()
    assert stage.ends.all == [("b", "cut"), ("a", "cut")]
    stage.sound.step()
    assert not stage.is_loud


@needs_voice
def test_a_voice_that_dies_has_failed_at_its_text_and_speaks_the_next() -> None:
    stage, faults = Stage(FileSound(), Inbox()), Inbox[str]()
    agent = TextToSpeech(
        stage.sound, voice="flite", on_end=lambda key, how: stage.ends((key, how)), on_fault=faults, patience_s=math.inf
    )
    agent.run()
    try:
        agent.speak(SpokenText("a", "Hello."))
        stage.pass_until(lambda: stage.end_of("a") == "whole")
        agent.speak(SpokenText("b", "This is a long sentence about the weather of the last days. " * 20))
        voice = agent._process
        assert voice._life is not None
        voice._life.end("it was killed")
        faults.wait(bool, "the voice was killed")
        stage.ends.wait(lambda all_: ("b", "failed") in all_, "the text was not spoken")
        agent.speak(SpokenText("c", "I am back."))
        stage.pass_until(lambda: stage.end_of("c") != "")
        assert stage.end_of("c") == "whole"
        assert faults.all == ["the voice 'flite' ended: it was killed"]
    finally:
        agent.stop()


@pytest.fixture
def hri() -> Iterator[HRIConnector]:
    connector = LocalConnector()
    connector.start()
    yield HRIConnector(connector)
    connector.stop()


@needs_voice
def test_a_message_at_which_the_voice_dies_is_spoken_again_and_is_reported_once(hri: HRIConnector) -> None:
    stage, faults, ends = Stage(FileSound(), Inbox()), Inbox[str](), list[tuple[str, str]]()
    agent = TextToSpeech(
        stage.sound,
        hri,
        on_message_end=lambda text, how: ends.append((text, how)),
        on_fault=faults,
        patience_s=math.inf,
    )
    agent.run()
    try:
        end = "The mission has ended. I am at home."
        hri.send(HRIMessage(end, author="ai"), TO_HUMAN)
        stage.pass_until(lambda: stage.is_loud)
        voice = agent._process
        assert voice._life is not None
        voice._life.end("it was killed")
        faults.wait(bool, "the voice was killed")
        stage.pass_until(lambda: bool(ends))
        assert (ends, agent.speaking) == ([(end, "whole")], False)
    finally:
        agent.stop()


@needs_voice
@pytest.mark.parametrize(
    ("communication", "command", "how"), [("run:end", "", "whole"), ("run:end", "stop", "cut"), ("", "", "cut")]
)
def test_a_report_that_a_person_cuts_is_spoken_again_uncut(
    hri: HRIConnector, communication: str, command: str, how: str
) -> None:
    """No answer is, and none of what is silenced by a command."""
    stage, ends, text = Stage(FileSound(), Inbox()), list[tuple[str, str]](), "The mission has ended. I am at home."
    agent = TextToSpeech(
        stage.sound, hri, on_message_end=lambda text, how: ends.append((text, how)), patience_s=math.inf
    )
    agent.run()
    try:
        hri.send(HRIMessage(text, author="ai", communication_id=communication), TO_HUMAN)
        for is_again in (False, True):
            stage.pass_until(lambda: bool(ends) or stage.is_loud)
            if command:
                hri.send_voice_command(command)
                stage.pass_until(lambda: bool(ends))
            agent.interrupt()
            stage.sound.step()
            assert stage.is_loud == (is_again and not ends)
            agent.resume(cut=True)
        stage.pass_until(lambda: not agent.speaking)
        assert ends == [(text, how)]
    finally:
        agent.stop()


def test_a_message_that_no_voice_speaks_has_failed_once(hri: HRIConnector) -> None:
    ends = Ends()
    agent = TextToSpeech(FileSound(), hri, voice="nightingale", on_message_end=lambda text, how: ends((text, how)))
    agent.run()
    hri.send(HRIMessage("Hello.", author="ai"), TO_HUMAN)
    ends.wait(bool, "it has failed")
    agent.stop()
    assert ends.all == [("Hello.", "failed")]


@needs_voice
def test_a_device_that_takes_no_sound_is_a_failure() -> None:
    ends = Ends(20.0)
    agent = TextToSpeech(FileSound(), on_end=lambda key, how: ends((key, how)), patience_s=0.2)
    agent.run()
    agent.speak(SpokenText("a", "Is any one there?"))
    agent.speak(SpokenText("b", "No."))
    assert ends.wait(lambda all_: len(all_) == 2, "no frame was taken") == [("b", "failed"), ("a", "failed")]
    agent.stop()


def test_a_voice_that_is_not_there_fails_every_text_and_is_named() -> None:
    ends, faults = Ends(), Inbox[str]()
    agent = TextToSpeech(FileSound(), voice="nightingale", on_end=lambda key, how: ends((key, how)), on_fault=faults)
    agent.run()
    agent.speak(SpokenText("a", "Hello."))
    agent.speak(SpokenText("b", "Hello."))
    assert set(ends.wait(lambda all_: len(all_) == 2, "both fail")) == {("a", "failed"), ("b", "failed")}
    faults.wait(lambda all_: "no voice 'nightingale' is known; there is: espeak, flite, kokoro, piper" in all_, "why")
    agent.stop()


def test_what_is_spoken_to_an_agent_that_does_not_run_has_failed() -> None:
    ends = Ends()
    TextToSpeech(FileSound(), on_end=lambda key, how: ends((key, how))).speak(SpokenText("a", "Hello."))
    assert ends.all == [("a", "failed")]


def test_a_second_voice_on_a_speaker_is_refused_and_leaves_nothing_behind() -> None:
    sound = FileSound()
    sound.play(lambda at: b"")
    before = set(threading.enumerate())
    agent = TextToSpeech(sound)
    with pytest.raises(UsageError, match="something is played already"):
        agent.run()
    agent.stop()
    assert set(threading.enumerate()) <= before


def test_text_to_speech_is_an_agent() -> None:
    sound = FileSound()
    check_agent(lambda: TextToSpeech(sound))


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.drill
def test_voice_recognition_is_an_agent() -> None:
    check_agent(lambda: VoiceRecognition(FileSound()))


class AwaySound(FileSound):
    """A sound whose device is away."""

    fault = "no sound has come"


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.parametrize(("sound", "state"), [(FileSound(), "running"), (AwaySound(), "hangs")])
def test_recognition_without_sound_reports_why(sound: FileSound, state: str) -> None:
    recognition = VoiceRecognition(sound)
    recognition.run()
    health = recognition.health
    recognition.stop()
    assert (health.state, health.why) == (state, sound.fault)
    assert recognition.health.state == "stopped"


@pytest.mark.long
@needs_voice
@pytest.mark.xdist_group("voice")
def test_a_person_interrupts_and_is_understood_while_the_robot_speaks() -> None:
    room, transcripts = RoomSound(echo_db=-20.0, delay_ms=60.0), Inbox[Transcript]()
    stage = Stage(room, Inbox())

    def take(transcript: Transcript) -> None:
        stage.agent.resume(cut=bool(transcript.text))
        transcripts(transcript)

    recognition = VoiceRecognition(room, on_transcript=take, on_present=stage.agent.interrupt)
    recognition.run()
    stage.agent.run()
    try:
        recognition.wait_ready()
        stage.agent.speak(SpokenText("report", "I am driving to the kitchen. " + "The battery is full. " * 4))
        stage.pass_until(lambda: stage.loud_s() > 1.0)
        room.person_speaks(spoken("Hello robot, where are you going?", "rms"))
        stage.pass_until(lambda: recognition.catch_up() and stage.end_of("report") != "")
        recognition.finish()
        assert stage.end_of("report") == "cut"
        (text,) = [each.text for each in transcripts.all if each.text]
        assert text.rstrip("?").endswith("are you going"), text
    finally:
        recognition.stop()
        stage.agent.stop()

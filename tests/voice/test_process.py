# SPDX-License-Identifier: Apache-2.0
"""A recogniser of another package, in a process of its own: it crashes, hangs, babbles, and takes nothing along."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rai_missions.errors import UsageError
from rai_missions.testing import Inbox
from rai_missions.voice.listener import ListenSettings
from rai_missions.voice.process import SpeechProcess, SpeechReply
from rai_missions.voice.setup import ListenNames, open_recognition
from tests.rigs.files import many_files
from tests.voice.conftest import needs_voice

__all__ = ("many_files",)

HOSTILE = """
import os, sys, time
class Hostile:
    def transcribe(self, samples, phrases):
        what = samples.decode()
        if what == "crash": os._exit(3)
        if what == "abort": os.abort()
        if what == "hang": time.sleep(600)
        if what == "raise": raise ValueError("no words")
        if what == "\\0" * 32_000: Hostile.phrases = phrases
        if what == "phrases": what = repr(Hostile.phrases)
        if what == "text": return "a text"
        if what == "babble": os.write(1, b"x" * 1000); print("noise")
        from rai_missions.voice.kind import Reading
        return Reading(what)
def open_recogniser(mood=""):
    if mood == "mute": return 7
    if mood == "broken": return mood + 7
    if mood == "crash": os._exit(3)
    if mood == "absent": raise ImportError("no such weights")
    return Hostile()
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An installed package that offers the recogniser `hostile`."""
    (tmp_path / "hostile_words.py").write_text(HOSTILE)
    data = tmp_path / "hostile_words-1.0.dist-info"
    data.mkdir()
    (data / "METADATA").write_text("Metadata-Version: 2.1\nName: hostile-words\nVersion: 1.0\n")
    (data / "entry_points.txt").write_text("[rai_missions.recognisers]\nhostile = hostile_words:open_recogniser\n")
    monkeypatch.syspath_prepend(str(tmp_path))


Asked = Callable[[str], SpeechReply]


@pytest.fixture
def recogniser(package: None) -> Iterator[tuple[SpeechProcess, Inbox[str], Asked]]:
    faults = Inbox[str]()
    process = SpeechProcess("recogniser", "hostile", within_s=1.0, on_fault=faults)
    process.open()

    def ask(what: str) -> SpeechReply:
        return process.ask_and_wait({"do": "transcribe", "phrases": []}, (what.encode(),))[0]

    assert ask("ready").fault == ""
    yield process, faults, ask
    process.close()


@pytest.mark.parametrize(
    ("what", "why"),
    [
        ("crash", "it ended with status 3"),
        ("abort", "it was ended by SIGABRT"),
        ("hang", "it did not reply within 1 s"),
    ],
)
def test_one_that_ends_or_hangs_is_named_and_started_again(
    recogniser: tuple[SpeechProcess, Inbox[str], Asked], what: str, why: str, caplog: pytest.LogCaptureFixture
) -> None:
    process, faults, ask = recogniser
    assert ask(what).fault == f"the recogniser 'hostile' ended: {why}"
    faults.wait(lambda all_: all_ == [f"the recogniser 'hostile' ended: {why}"], "it is named once")
    assert not [each for each in caplog.records if each.name == "rai_missions.voice.process"]
    assert ask("again").data["text"] == "again"
    assert process.restarts == 1


def test_an_order_that_comes_while_the_process_ends_leaves_the_one_before_its_reply(
    recogniser: tuple[SpeechProcess, Inbox[str], Asked],
) -> None:
    process, faults, ask = recogniser
    before = Inbox[SpeechReply]()
    process.ask({"do": "transcribe", "phrases": []}, (b"hang",), on_reply=before)
    assert process._life is not None
    process._life.end("it was killed")
    assert ask("next").data["text"] == "next"
    (reply,) = before.wait(bool, "the order that it had when it ended has a reply")
    assert reply.fault == "the recogniser 'hostile' ended: it was killed"
    faults.wait(lambda all_: all_ == [reply.fault], "it is named once")
    assert process.restarts == 1


def test_one_that_raises_or_babbles_stays(recogniser: tuple[SpeechProcess, Inbox[str], Asked]) -> None:
    process, faults, ask = recogniser
    assert ask("raise").fault == "the recogniser 'hostile' failed (ValueError: no words)"
    assert ask("text").fault.endswith("failed (TypeError: what it makes of sound is a Reading, not 'a text')")
    assert ask("babble").data["text"] == "babble"
    assert (process.restarts, faults.all) == (0, [])


def test_one_transcribes_for_a_program_with_many_files(
    many_files: None, recogniser: tuple[SpeechProcess, Inbox[str], Asked]
) -> None:
    _, _, ask = recogniser
    assert ask("hello").data["text"] == "hello"
    assert ask("crash").fault == "the recogniser 'hostile' ended: it ended with status 3"


def test_every_order_ends_once_also_when_the_process_is_closed(
    recogniser: tuple[SpeechProcess, Inbox[str], Asked],
) -> None:
    process, _, _ask = recogniser
    replies = Inbox[SpeechReply]()
    for _ in range(5):
        process.ask({"do": "transcribe", "phrases": []}, (b"hang",), on_reply=replies)
    process.close()
    assert len(replies.wait(lambda all_: len(all_) >= 5, "each has an end")) == 5
    assert all(reply.fault for reply in replies.all)
    process.ask({"do": "transcribe", "phrases": []}, (b"x",), on_reply=replies)
    assert replies.all[-1].fault == "the recogniser 'hostile': it was closed"


def test_one_that_cannot_be_opened_is_absent_with_its_reason(package: None) -> None:
    began = time.monotonic()
    process = SpeechProcess("recogniser", "hostile", {"mood": "absent"})
    process.open()
    assert not process.wait_ready(30)
    assert process.absent.endswith("of hostile-words 1.0 cannot be opened (ImportError: no such weights)")
    reply, _ = process.ask_and_wait({"do": "transcribe", "phrases": []}, (b"x",))
    assert "no such weights" in reply.fault
    assert time.monotonic() - began < 30
    process.close()


def test_one_that_crashes_where_it_is_opened_is_not_ready_and_its_end_is_named(package: None) -> None:
    process = SpeechProcess("recogniser", "hostile", {"mood": "crash"})
    process.open()
    assert not process.wait_ready(30)
    with pytest.raises(UsageError, match=r"^the recogniser 'hostile' ended: it ended with status 3$"):
        process.wait_open()
    process.close()


@pytest.mark.parametrize(
    ("name", "options", "why"),
    [
        ("whispr", {}, "no recogniser 'whispr' is known; did you mean 'whisper'?"),
        ("hostile", {"moood": "calm"}, "the recogniser 'hostile' has no option 'moood'; did you mean 'mood'?"),
        (
            "hostile",
            {"mood": "broken"},
            "the recogniser 'hostile' of hostile-words 1.0 cannot be opened (TypeError: can only concatenate",
        ),
        (
            "hostile",
            {"mood": "mute"},
            "the recogniser 'hostile' of hostile-words 1.0 opens 7, which is no recogniser: it lacks 'transcribe'",
        ),
    ],
)
def test_an_unknown_name_or_option_is_answered_with_what_there_is(
    package: None, name: str, options: dict[str, object], why: str
) -> None:
    process = SpeechProcess("recogniser", name, options)
    process.open()
    assert not process.wait_ready(30)
    assert process.absent.startswith(why)
    process.close()


def test_no_thread_is_left(package: None) -> None:
    before = set(threading.enumerate())
    process = SpeechProcess("recogniser", "hostile")
    process.open()
    process.wait_ready(30)
    process.close()
    for thread in set(threading.enumerate()) - before:
        thread.join(5)
        assert not thread.is_alive(), thread.name


@needs_voice
@pytest.mark.xdist_group("voice")
def test_a_recogniser_transcribes_a_second_of_silence_before_anyone_speaks(package: None) -> None:
    settings = ListenSettings(phrases=("stop", "wait"))
    recognition = open_recognition(ListenNames("hostile", ""), settings, on_transcript=lambda each: None)
    _, recogniser = recognition.processes
    reply, _ = recogniser.ask_and_wait({"do": "transcribe", "phrases": []}, (b"phrases",))
    assert reply.data.get("text") == "['stop', 'wait']", reply.fault
    recognition.close()

# SPDX-License-Identifier: Apache-2.0
"""What is spoken into a page is transcribed and passed on with the page's role; one microphone at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rai_missions.agents.talk import page_ear
from rai_missions.agents.talk.page_ear import AWAY_S, LATE_S, PageEar
from rai_missions.errors import install_command
from rai_missions.event import Role
from tests.voice.conftest import needs_voice, quiet, spoken

PIECE = 4096
PATIENCE_S = 60.0


class Clock:
    """Passes as it is set."""

    def __init__(self) -> None:
        self.at = 0.0

    def __call__(self) -> float:
        return self.at


class Conversation:
    """Keeps the sentences of an ear with a clock of its own."""

    def __init__(self, **words: Any) -> None:
        self.clock, self.sentences, self.came = Clock(), list[tuple[str, dict[str, Any]]](), threading.Event()
        self.ear = PageEar(self.receive, now=self.clock, **words)

    def receive(self, text: str, **words: Any) -> str:
        self.sentences.append((text, words))
        self.came.set()
        return ""


@pytest.fixture
def conversation() -> Iterator[Conversation]:
    made = Conversation()
    yield made
    made.ear.stop()


@needs_voice
@pytest.mark.xdist_group("voice")
def test_what_is_spoken_into_a_page_is_a_sentence_of_its_role_with_its_readings(conversation: Conversation) -> None:
    sound = quiet(0.5) + spoken("Cancel the mission.", "rms") + quiet(0.2)
    for at in range(0, len(sound), PIECE):
        assert conversation.ear.listen(sound[at : at + PIECE], key="1", author="Anna", role="viewer") == ""
    assert conversation.ear.listen(b"", key="1", author="Anna", role="viewer", is_last=True) == ""
    assert conversation.came.wait(PATIENCE_S)
    ((text, given),) = conversation.sentences
    assert (text, given["role"], given["channel"], given["author"]) == ("cancel the mission", "viewer", "page", "Anna")
    readings = given["readings"]
    assert readings[:2] == ("cancel the mission",) * 2, "one of each recogniser"
    assert set(readings[2:]) <= {"cancel"}, "which a processor with other rounding may have read as well"
    assert given["waited_s"] > 0.5, "it came when the person began"


@needs_voice
def test_one_microphone_is_open_at_a_time_and_one_that_is_gone_frees_its_place(conversation: Conversation) -> None:
    ear = conversation.ear
    assert ear.listen(b"", key="1", author="", role="operator") == ""
    assert ear.listen(b"", key="2", author="", role="operator").startswith("another microphone is open")
    conversation.clock.at = AWAY_S
    assert ear.listen(b"", key="2", author="", role="operator") == ""
    ear.stop()
    assert ear.listen(b"", key="2", author="", role="operator") == "the conversation is over"


@needs_voice
@pytest.mark.xdist_group("voice")
def test_a_sentence_that_a_page_left_unfinished_keeps_its_role_and_is_dropped_where_it_is_late(
    conversation: Conversation,
) -> None:
    ear, clock = conversation.ear, conversation.clock

    def say(key: str, role: Role, *, is_last: bool = False) -> None:
        sound = quiet(0.5) + spoken("Cancel the mission.", "rms")
        for at in range(0, len(sound), PIECE):
            assert ear.listen(sound[at : at + PIECE], key=key, author=key, role=role) == ""
        if is_last:
            assert ear.listen(b"", key=key, author=key, role=role, is_last=True) == ""

    say("1", "viewer")
    clock.at += AWAY_S  # the page has gone, and another speaks
    assert ear.listen(quiet(0.1), key="2", author="2", role="operator", is_last=True) == ""
    assert conversation.came.wait(PATIENCE_S)
    conversation.came.clear()
    say("3", "operator")
    clock.at += LATE_S + 1
    say("4", "operator", is_last=True)
    assert conversation.came.wait(PATIENCE_S)
    assert [(words["author"], words["role"]) for _, words in conversation.sentences] == [
        ("1", "viewer"),
        ("4", "operator"),
    ]


@needs_voice
def test_an_operator_s_microphone_comes_before_a_viewer_s_and_a_shut_one_frees_its_place_at_once(
    conversation: Conversation,
) -> None:
    ear = conversation.ear
    assert ear.listen(b"", key="1", author="", role="viewer") == ""
    assert ear.listen(b"", key="1", author="", role="operator") == ""
    for key in ("1", "2"):
        assert ear.listen(b"", key=key, author="", role="viewer").startswith("another microphone is open")
    assert ear.listen(b"", key="1", author="", role="operator", is_last=True) == ""
    assert ear.listen(b"", key="2", author="", role="viewer") == ""


def test_what_is_not_installed_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_ear, "NEEDED", ("no_such_module",))
    ear = Conversation().ear
    assert ear.deaf.startswith(f"speech needs no_such_module, not installed here: {install_command('voice')}")
    assert ear.listen(bytes(2), key="1", author="", role="operator") == ear.deaf


def test_another_language_than_english_is_not_recognised() -> None:
    ear = Conversation(language="de").ear
    assert ear.deaf == "English alone is recognised, and this conversation is in 'de'"

# SPDX-License-Identifier: Apache-2.0
"""A conversation by sound: a person's speech goes in as samples, and the robot's comes out as samples."""

from __future__ import annotations

import math
import threading

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.voice_door import VoiceDoor
from rai_missions.connectors.sound.connector import SILENCE, SoundFrame
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.conversation import Speech
from rai_missions.testing import Inbox
from tests.voice.conftest import needs_voice, quiet, spoken

pytestmark = [needs_voice, pytest.mark.xdist_group("voice")]


@pytest.mark.long
def test_a_question_that_is_spoken_is_answered_in_sound() -> None:
    room, frames = RoomSound(echo_db=-20.0), list[SoundFrame]()
    agent, received = ConversationalAgent(), list[tuple[str, dict[str, object]]]()

    def receive(text: str, **words: object) -> str:
        received.append((text, words))
        return agent.receive(text, **words)  # type: ignore[arg-type]

    door = VoiceDoor(room, receive, patience_s=math.inf)
    agent.add_door(door)
    agent.run()
    door.run()
    room.listen(frames.append)
    tick = threading.Event()
    try:
        room.person_speaks(quiet(0.5) + spoken("What are you doing?"))
        for _ in range(400):
            room.step()
            door.recognition.catch_up()
            tick.wait(0.002)
            if any(frame.played != SILENCE for frame in frames) and not door.speech.speaking:
                break
        (sentence,) = received
        assert sentence[0] == "What are you doing?"
        waited_s = sentence[1].pop("waited_s")
        assert sentence[1] == {"role": "person", "channel": "voice", "readings": ("What are you doing?",)}
        assert isinstance(waited_s, float) and 1.0 < waited_s < 4.0, "from the beginning of the sentence on"
        assert sum(frame.played != SILENCE for frame in frames) > 10, "an answer was played"
    finally:
        door.stop()
        agent.stop()


def test_a_text_at_a_door_that_is_stopped_has_failed_and_the_door_is_shut() -> None:
    door, ends = VoiceDoor(RoomSound(), lambda *_, **__: ""), Inbox[str]()
    assert not door.is_open
    door.speak(Speech("a", "Hello."), ends)
    assert ends.all == ["failed"]

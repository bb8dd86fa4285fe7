# SPDX-License-Identifier: Apache-2.0
"""No claim of a hostile model reaches a reader: not on a screen, on a topic, aloud, or in a journal's lines.

The dialogue alone is judged in `tests/conversation/test_hostile_models.py`, with each claim; here are all doors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import pytest
from langchain_core.messages import AIMessage, BaseMessage

from rai_missions.agents.talk.doors import OnSpoken, TextDoor
from rai_missions.agents.talk.hri_door import HRIDoor
from rai_missions.agents.talk.journal import LINES
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Speech
from rai_missions.runtime.clock import WallClock
from rai_missions.testing import Inbox
from tests.agents.talk.scenes import Screen, Talk, settle
from tests.conversation.stored import CLAIMS
from tests.conversation.test_hostile_models import MODELS, QUESTION, letters
from tests.rigs.runs import mission

TEN = [*MODELS][::3]
CLAIMS_OF_EACH = 4
"""Of the stored claims, other ones for each model."""
LONG = [each for each in CLAIMS["claims"]["en"] if len(each.split()) > 2]
"""A claim of one word may be a word of what the rules report."""
WORKING = {"working": {"about": "works", "transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}}


class Claimant(DoubleModel):
    """Replies with one text after the other."""

    replies: list[str]

    def reply_to(self, messages: list[BaseMessage]) -> AIMessage:
        return AIMessage(self.replies.pop(0))


class Aloud(TextDoor):
    """Keeps what is spoken."""

    is_aloud = True

    def __init__(self) -> None:
        super().__init__("voice", Screen().show)
        self.spoken: list[str] = []

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        self.spoken.append(speech.words)
        on_end("whole")


def has_judged(talk: Talk, least: int) -> bool:
    """Whether sentences of so many replies have been judged."""
    return len({row["request"] for row in talk.talk() if row["kind"] == "model_text"}) >= least


def reached(replies: Sequence[str]) -> Mapping[str, str]:
    """What a reader of each door reads of all that was shown of these replies, each to a question from that door."""
    connector, received = LocalConnector(), Inbox[HRIMessage]()
    connector.start()
    hri, person, aloud = HRIConnector(connector), HRIConnector(connector), Aloud()
    person.listen(TO_HUMAN, received)
    door = HRIDoor(hri, "rob")
    model = Claimant(replies=[each for each in replies for _ in range(3)])
    with Talk(mission(WORKING), clock=WallClock(), model=model, doors=[door, aloud]) as talk:
        door.open(talk.agent.receive)
        talk.screen.until(lambda line: "started" in line.text)
        for number in range(1, len(model.replies) + 1):
            if number % 3 == 0:
                person.send(HRIMessage(QUESTION["en"], name="Ada", communication_id=str(number)), FROM_HUMAN)
            else:
                channel = ("terminal", "voice")[number % 3 - 1]
                talk.agent.receive(QUESTION["en"], role="operator", channel=channel, author="Anna")
            talk.until(partial(has_judged, talk, number))
            settle(talk.agent)
    hri.close()
    person.close()
    connector.stop()
    lines = [row for data in talk.book.data if isinstance(data, Mapping) for row in data.get(LINES, [])]
    texts = {
        "screen": talk.screen.texts(),
        "topic": [each.text for each in received.all],
        "voice": aloud.spoken,
        "journal": [each["text"] for each in lines if each["by"] == "robot"],
    }
    assert not model.replies, "the model was asked each time"
    assert all(len(each) >= len(replies) for each in texts.values()), "each door had its answers"
    return {name: letters("".join(each)) for name, each in texts.items()}


@pytest.mark.parametrize("name", TEN)
def test_no_claim_of_a_hostile_model_reaches_a_reader(name: str) -> None:
    at = list(MODELS).index(name)
    claims = LONG[at :: len(LONG) // CLAIMS_OF_EACH][:CLAIMS_OF_EACH]
    read = reached(["".join(MODELS[name](each)) for each in claims])
    assert [(door, each) for door, text in read.items() for each in claims if letters(each) in text] == []


def test_there_are_ten_hostile_models() -> None:
    assert len(TEN) >= 10

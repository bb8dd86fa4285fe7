# SPDX-License-Identifier: Apache-2.0
"""What talk over a connector must do, as a function that a connector's tests call.

Rule: each check opens a fresh connector, so that one broken promise does not hide another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rai_missions.connectors.connector import Connector
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.hri.assembly import ReceivedMessage
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import MOST_TEXT, Audio, HRIMessage
from rai_missions.connectors.hri.parts import parts_of
from rai_missions.connectors.hri.wire import TYPE
from rai_missions.errors import ConnectorError
from rai_missions.image import Image

__all__ = ("check_hri_connector",)

LONG = "".join(f"sentence {number}; " for number in range(3000))


def check_hri_connector(make: Callable[[], Connector]) -> None:
    """Hold a connector that carries topics to what `HRIConnector` promises over it.

    Args:
        make: Gives a fresh connector, not started.

    Raises:
        AssertionError: A promise is broken; the text states which.
    """
    for check in CHECKS:
        connector = make()
        connector.start()
        hri = HRIConnector(connector, within_s=1.0)
        try:
            check(hri)
        finally:
            hri.close()
            connector.stop()


def _carries_every_field(hri: HRIConnector) -> None:
    picture = Image("red", 3, 2, "rgb8", bytes(range(18)))
    sound = Audio(b"\x00\x80\xff\x7f\x01\x00\xff\xff", 16_000, 2)
    sent = HRIMessage("grüß dich\n<b>", (picture,), (sound,), "ai", "Robi", "one", 0, True)
    inbox: Inbox[HRIMessage] = Inbox()
    hri.listen(TO_HUMAN, inbox)
    hri.send(sent, TO_HUMAN)
    (got,) = inbox.wait(bool, "a message was sent")
    assert replace(got, images=()) == replace(sent, images=()), f"a message is received as it was sent, not as {got}"
    (seen,) = got.images
    assert (seen.width, seen.height, seen.data) == (3, 2, picture.data), "a picture keeps its pixels"


def _joins_a_long_message(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    faults: Inbox[ReceivedMessage | ConnectorError] = Inbox()
    hri.listen(FROM_HUMAN, inbox, on_fault=faults)
    for name in ("Anna", "Ben"):
        hri.send(HRIMessage(f"{name}: {LONG}", name=name), FROM_HUMAN)
    got = inbox.wait(lambda all_: len(all_) == 2, "two long messages were sent")
    assert [each.text for each in got] == [f"{each.name}: {LONG}" for each in got], "a long message is one again"
    assert not faults.all, f"nothing was lost, and yet it is reported: {faults.all}"


def _joins_what_comes_mixed(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    hri.listen(FROM_HUMAN, inbox)
    parts = [parts_of(HRIMessage(LONG + name, name=name), "same") for name in ("Anna", "Ben")]
    for each in (part for pair in zip(*map(reversed, parts), strict=True) for part in pair):
        hri.send(each, FROM_HUMAN)
    got = inbox.wait(lambda all_: len(all_) == 2, "the parts of two messages were sent, mixed and reversed")
    assert {each.text for each in got} == {LONG + "Anna", LONG + "Ben"}, "the parts of each are joined"


def _reports_a_lost_part(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    faults: Inbox[ReceivedMessage | ConnectorError] = Inbox()
    hri.listen(FROM_HUMAN, inbox, on_fault=faults)
    first, second, *rest = parts_of(HRIMessage(LONG), "lossy")
    for each in (first, first, *rest):
        hri.send(each, FROM_HUMAN)
    (fault,) = faults.wait(bool, "a part was lost")
    assert isinstance(fault, ReceivedMessage) and fault.missing == (1,), f"the lost part is named: {fault}"
    assert fault.duplicated == 1 and fault.message.text == LONG.replace(second.text, "", 1), "with what there was"
    assert not inbox.all, "half a message is no message"


def _reports_what_is_no_message(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    faults: Inbox[ReceivedMessage | ConnectorError] = Inbox()
    hri.listen(FROM_HUMAN, inbox, on_fault=faults)
    broken = {"audio": [1, 2, 3], "sample_rate": 16_000, "channels": 2}
    hri.connector.publish(FROM_HUMAN, TYPE, {"text": "x" * 10_000_000})
    hri.connector.publish(FROM_HUMAN, TYPE, {"text": "listen", "audios": [broken]})
    hri.send(HRIMessage("are you there?"), FROM_HUMAN)
    (got,) = inbox.wait(bool, "a message followed two that are none")
    assert got.text == "are you there?", "what is at fault in one message stops no other"
    sentences = [str(each) for each in faults.wait(lambda all_: len(all_) == 2, "two messages were at fault")]
    assert f"{FROM_HUMAN}: text: 10000000 characters; there are {MOST_TEXT} at the most" in sentences[0], sentences
    assert "audios/0: audio: 6 bytes are no whole number of samples" in sentences[1], sentences


def _receives_short_messages_of_other_programs(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    hri.listen(FROM_HUMAN, inbox)
    hri.connector.publish(FROM_HUMAN, TYPE, {"text": "stop", "communication_id": "as RAI's microphone sends it"})
    hri.connector.publish(FROM_HUMAN, TYPE, {"text": "go"})
    got = inbox.wait(lambda all_: len(all_) == 2, "two messages were sent without a mark of their end")
    assert sorted((each.text, each.author) for each in got) == [("go", "human"), ("stop", "human")]


def _passes_parts_on_as_they_come(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    hri.listen(TO_HUMAN, inbox, is_whole=False)
    sentences = [HRIMessage(f"{number}.", (), (), "ai", "", "id", number, number == 2) for number in range(3)]
    for each in sentences:
        hri.send(each, TO_HUMAN)
    assert inbox.wait(lambda all_: len(all_) == 3, "three parts were sent") == sentences


def _closes(hri: HRIConnector) -> None:
    inbox: Inbox[HRIMessage] = Inbox()
    after: Inbox[HRIMessage] = Inbox()
    close = hri.listen(FROM_HUMAN, inbox)
    close()
    close()
    hri.listen(FROM_HUMAN, after)
    hri.send(HRIMessage("late"), FROM_HUMAN)
    after.wait(bool, "another listener is there")
    assert not inbox.all, "a listener that has closed receives nothing"


def _steers_the_speaker(hri: HRIConnector) -> None:
    inbox: Inbox[str] = Inbox()
    hri.listen_to_voice_commands(inbox)
    for word in ("pause", "play", "stop"):
        hri.send_voice_command(word)
    assert inbox.wait(lambda all_: len(all_) == 3, "three words were sent") == ["pause", "play", "stop"]


CHECKS = (
    _carries_every_field,
    _joins_a_long_message,
    _joins_what_comes_mixed,
    _reports_a_lost_part,
    _reports_what_is_no_message,
    _receives_short_messages_of_other_programs,
    _passes_parts_on_as_they_come,
    _closes,
    _steers_the_speaker,
)

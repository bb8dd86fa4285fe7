# SPDX-License-Identifier: Apache-2.0
"""Talk over connectors: the contract in the process and over a broker, and who is at fault."""

from __future__ import annotations

import logging
import re
from typing import Any

import pytest

from rai_missions.connectors.chaos import ChaosConnector, Rates
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, VOICE_COMMANDS, HRIConnector
from rai_missions.connectors.hri.contract import check_hri_connector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.hri.wire import TYPE
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.mqtt.connector import MqttConnector
from rai_missions.connectors.worker import Work
from rai_missions.errors import UsageError
from tests.connectors.test_mqtt import Broker, broker, needs_broker

__all__ = ("broker",)


def test_talk_in_the_process_keeps_the_contract() -> None:
    check_hri_connector(LocalConnector)


@needs_broker
def test_talk_over_a_broker_keeps_the_contract(broker: Broker) -> None:
    check_hri_connector(lambda: MqttConnector({"port": broker.port}))


class Clock:
    """Time that the test moves."""

    def __init__(self) -> None:
        self.at = 0.0
        self._due: list[tuple[float, Work]] = []

    def later(self, seconds: float, work: Work) -> Work:
        entry = (self.at + seconds, work)
        self._due.append(entry)
        return lambda: self._due.remove(entry) if entry in self._due else None

    def move(self, to: float) -> None:
        self.at = to
        for entry in [each for each in self._due if each[0] <= to]:
            self._due.remove(entry)
            entry[1]()


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def hri(clock: Clock) -> HRIConnector:
    connector = LocalConnector()
    connector.start()
    return HRIConnector(connector, now=lambda: clock.at, later=clock.later, within_s=2.0)


def test_time_comes_from_the_clock_that_is_given(hri: HRIConnector, clock: Clock) -> None:
    got: list[HRIMessage] = []
    hri.listen(FROM_HUMAN, got.append)
    for number in range(3):
        hri.connector.publish(FROM_HUMAN, TYPE, {"text": f"stop {number}", "communication_id": f"{number}"})
        clock.move(0.05 + number / 20)
    assert got == []
    clock.move(0.31)
    assert [each.text for each in got] == ["stop 0"]
    clock.move(0.41)
    assert [each.text for each in got] == ["stop 0", "stop 1", "stop 2"]
    assert [each.seq_end for each in got] == [False] * 3, "that no end was marked stays to be seen"


def test_what_is_not_received_whole_is_logged_where_no_one_asks_for_it(
    hri: HRIConnector, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    hri.listen(FROM_HUMAN, lambda _: None)
    hri.listen_to_voice_commands(lambda _: None)
    with caplog.at_level(logging.WARNING):
        hri.send(HRIMessage("half", name="Anna", communication_id="id", seq_no=1), FROM_HUMAN)
        clock.move(2.0)
        hri.connector.publish(FROM_HUMAN, TYPE, {"seq_no": "first"})
        hri.connector.publish(VOICE_COMMANDS, "std_msgs/msg/String", {"data": "rewind"})
    assert [record.getMessage() for record in caplog.records] == [
        "a message of 'Anna' is not whole: part 0 did not come within 2 s",
        "/from_human: seq_no: 'first' is no number of a part; the first is 0",
        "/voice_commands: 'rewind' is no word for the speaker",
    ]


def test_what_is_incomplete_once_the_topic_is_left_is_reported_once(hri: HRIConnector, clock: Clock) -> None:
    got, faults = list[HRIMessage](), list[Any]()
    hri.listen(FROM_HUMAN, got.append, on_fault=faults.append)
    for number, name in ((0, "Anna"), (1, "Ben")):
        hri.send(HRIMessage("half", name=name, communication_id="id", seq_no=number, seq_end=False), FROM_HUMAN)
    hri.close()
    clock.move(60.0)
    assert got == []
    assert [(each.message.name, each.message.text, each.why) for each in faults] == [
        ("Anna", "half", "the last part had not come when the topic was left"),
        ("Ben", "half", "part 0 had not come when the topic was left"),
    ]


def test_a_listener_that_fails_keeps_no_message_from_the_next(hri: HRIConnector) -> None:
    got: list[str] = []

    def fail(message: HRIMessage) -> None:
        got.append(message.text)
        raise RuntimeError("not today")

    hri.listen(TO_HUMAN, fail)
    for text in ("one", "two"):
        hri.send(HRIMessage(text, author="ai"), TO_HUMAN)
    assert got == ["one", "two"]


def test_a_word_that_no_speaker_knows_is_not_sent(hri: HRIConnector) -> None:
    with pytest.raises(UsageError, match="'rewind' is no word for the speaker; there is: play, pause, tog_play, stop"):
        hri.send_voice_command("rewind")


def test_what_is_no_message_is_not_sent(hri: HRIConnector) -> None:
    text: Any = "Where are you?"
    with pytest.raises(UsageError, match=re.escape("is no message; write HRIMessage('Where are you?')")):
        hri.send(text, TO_HUMAN)


def test_over_a_connector_that_repeats_and_swaps_a_message_comes_once(clock: Clock) -> None:
    rates = Rates(lose=0, backdate=0, garble=0, repeat=0.4, delay=0.5)
    chaos = ChaosConnector(LocalConnector(), seed=3, incoming=rates, outgoing=Rates(0, 0, 0, 0, 0), later=clock.later)
    chaos.start()
    hri = HRIConnector(chaos, now=lambda: clock.at, later=clock.later)
    got: list[HRIMessage] = []
    hri.listen(FROM_HUMAN, got.append, on_fault=lambda _: None)
    long = "".join(map(str, range(20_000)))
    hri.send(HRIMessage(long), FROM_HUMAN)
    assert not got, "some part is delayed"
    for step in range(1, 20):
        clock.move(step / 10)
    assert [each.text for each in got] == [long]

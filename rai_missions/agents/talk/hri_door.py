# SPDX-License-Identifier: Apache-2.0
"""The door of other programs' microphones, pages and speakers: messages in on `/from_human`, out on `/to_human`.

Rule: who writes on a topic is a person, whatever name the message has.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from rai_missions.agents.talk.doors import OnSpoken, TakesSentence, TalkLine
from rai_missions.connectors.hri.assembly import ReceivedMessage
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import MOST_NAME, HRIMessage
from rai_missions.conversation import Speech
from rai_missions.conversation.inputs import SpeechResult
from rai_missions.errors import ConnectorError, MissionError
from rai_missions.redaction import cut, logger

__all__ = ("HRIDoor",)

log = logger(__name__)
CHANNEL = "topic"


class HRIDoor:
    """Messages over a connector that is running.

    Args:
        hri: Carries them.
        name: The robot's, in what it sends.
        below: What the names of the topics begin with, as `/alpha`.
        is_stop: Whether a sentence orders to stop: one to all robots is taken, too, where the door is below a name.
    """

    channel, is_aloud, is_open = CHANNEL, False, True

    def __init__(
        self, hri: HRIConnector, name: str = "", *, below: str = "", is_stop: Callable[[str], bool] = lambda _: False
    ) -> None:
        self._hri, self._name, self._is_stop = hri, cut(name, 200), is_stop
        self._refused_at = -math.inf
        self._from, self._to = below + FROM_HUMAN, below + TO_HUMAN

    def open(self, take: TakesSentence) -> None:
        """Receive from now on."""

        def receive(message: HRIMessage) -> None:
            why = take(
                message.text,
                role="person",
                channel=CHANNEL,
                author=message.name,
                message_id=message.communication_id,
                age_s=message.age_s,
            )
            if why:
                self._refuse(message.name, why)

        def refuse(fault: ReceivedMessage | ConnectorError) -> None:
            if isinstance(fault, ConnectorError):
                self._refuse("", str(fault))
            elif not fault.duplicated:  # the first has been taken
                self._refuse(fault.message.name, fault.why)

        self._hri.listen(self._from, receive, on_fault=refuse)
        if self._from != FROM_HUMAN:  # a person who calls out to stop may not know which robot it is
            self._hri.listen(FROM_HUMAN, lambda message: receive(message) if self._is_stop(message.text) else None)

    def close(self) -> None:
        """Receive no more."""
        self._hri.close()

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        """Publish; whether anyone was reached, no topic reports. A report is a communication of its own."""
        on_end(self._publish(speech.words, cut(speech.report, MOST_NAME)))

    def _refuse(self, author: str, why: str) -> None:
        """Reply to a person whose message is not taken; a flood has one reply a second."""
        log.warning("a message of '%s' on %s is not taken: %s", cut(author, 40), self._from, cut(why, 300))
        at = self._hri.now()
        if at - self._refused_at >= 1.0:
            self._refused_at = at
            whom = f"{cut(author, 40)}: y" if author else "Y"
            self._publish(f"{whom}our message is not taken: {cut(why, 300)}")

    def _publish(self, text: str, report: str = "") -> SpeechResult:
        try:
            self._hri.send(HRIMessage(text, author="ai", name=self._name, communication_id=report), self._to)
        except MissionError as error:
            log.warning("%s: %s", self._to, cut(error, 200))
            return "failed"
        return "whole"

    def silence(self, *, is_total: bool = True) -> None:
        """What is sent is sent."""

    def show(self, line: TalkLine) -> None:
        """Lines of others are of no concern to a topic."""

# SPDX-License-Identifier: Apache-2.0
"""Talk over any connector: messages between a person and a robot, sent and received whole.

Rule: what is at fault in one message is reported, and stops no other.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable

from rai_missions.connectors.connector import Close, Connector, Message
from rai_missions.connectors.hri.assembly import Assembly, ReceivedMessage
from rai_missions.connectors.hri.message import Author, HRIMessage
from rai_missions.connectors.hri.parts import parts_of
from rai_missions.connectors.hri.parts_inbox import PartsInbox
from rai_missions.connectors.hri.wire import TYPE, message_from_data, message_to_data
from rai_missions.connectors.worker import Work, Worker
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut, logger, shown

__all__ = ("FROM_HUMAN", "TO_HUMAN", "VOICE_COMMANDS", "HRIConnector")

log = logger(__name__)

FROM_HUMAN, TO_HUMAN, VOICE_COMMANDS = "/from_human", "/to_human", "/voice_commands"
"""The topics of RAI: what a person writes or speaks, what the robot replies, and words for the speaker."""
VOICE_WORDS = ("play", "pause", "tog_play", "stop")
"""What is sent on `/voice_commands`."""
STRING = "std_msgs/msg/String"
LONE_S = 0.3
"""RAI's microphones mark no end: a person's first part is the whole message where no other came for so long."""
Later = Callable[[float, Work], Work]
OnFault = Callable[[ReceivedMessage | ConnectorError], object]


class HRIConnector:
    """Sends and receives messages over a connector, which its owner starts and stops.

    Args:
        connector: Any; over ROS 2 and MQTT other programs take part.
        now: Seconds on a clock that does not go back.
        later: Has something done so many seconds from now, and returns what cancels it; a thread of its own by default.
        within_s: How long the next part of a message may take.
    """

    def __init__(
        self,
        connector: Connector,
        *,
        now: Callable[[], float] = time.monotonic,
        later: Later | None = None,
        within_s: float = 30.0,
    ) -> None:
        self.connector = connector
        self.now, self._within_s = now, within_s
        self._worker = Worker("parts of messages")
        self._later = later or self._worker.after
        self._closes: list[Close] = []

    def close(self) -> None:
        """Receive no more, and end the own thread; the connector itself continues."""
        while self._closes:
            self._closes.pop()()
        self._worker.close()

    def send(self, message: HRIMessage, topic: str) -> None:
        """Send a message, in parts where it is long; a part is sent as it is.

        Raises:
            ConnectorError: The connector cannot carry it.
            UsageError: It is no `HRIMessage`.
        """
        if not isinstance(message, HRIMessage):
            raise UsageError(f"{shown(message)} is no message; write HRIMessage({shown(message)})")
        is_part = message.seq_no > 0 or not message.seq_end
        for part in (message,) if is_part else parts_of(message, uuid.uuid4().hex):
            self.connector.publish(topic, TYPE, message_to_data(part, time.time()))

    def listen(
        self,
        topic: str,
        on_message: Callable[[HRIMessage], object],
        *,
        on_fault: OnFault | None = None,
        author: Author | None = None,
        is_whole: bool = True,
    ) -> Close:
        """Receive the messages of a topic from now on; both callbacks may run on any thread.

        Args:
            topic: Its messages are a door of their own: the listener knows by the topic what an author may do.
            on_message: Receives each message; its `seq_end` is false where a single part was all that came.
            on_fault: Receives what is no message, and each that did not become whole. Left out, they are logged.
            author: Who writes on the topic; left out, a machine on `/to_human` and a person elsewhere.
            is_whole: Join parts to messages; else each part is passed on as it comes.
        """
        writer = author or ("ai" if topic.rpartition("/")[2] == "to_human" else "human")
        report = on_fault or _logged
        assembly = Assembly(within_s=self._within_s, lone_s=LONE_S if writer == "human" else self._within_s)
        inbox = PartsInbox(
            assembly, lambda found: (report if found.why else _passing(on_message))(found), self.now, self._later
        )

        def receive(message: Message) -> None:
            if message.kept:
                report(
                    ConnectorError(f"{topic}: a message that was kept for later readers is of the past, and is left")
                )
                return
            try:
                part = message_from_data(message.data, writer, topic, message.age_s)
            except ConnectorError as fault:
                report(fault)
                return
            if is_whole:
                inbox.add(part)
            else:
                on_message(part)

        return self._kept(self.connector.subscribe(topic, TYPE, receive), inbox.close)

    def send_voice_command(self, word: str) -> None:
        """Steer whatever speaks.

        Raises:
            UsageError: It is none of `VOICE_WORDS`.
        """
        if word not in VOICE_WORDS:
            raise UsageError(f"{shown(word)} is no word for the speaker; there is: {', '.join(VOICE_WORDS)}")
        self.connector.publish(VOICE_COMMANDS, STRING, {"data": word})

    def listen_to_voice_commands(self, on_word: Callable[[str], object]) -> Close:
        """Receive the words for the speaker; any other text is logged and left out."""

        def receive(message: Message) -> None:
            word = message.data.get("data")
            if word in VOICE_WORDS and not message.kept:
                on_word(str(word))
            elif not message.kept:
                log.warning("%s: %s is no word for the speaker", VOICE_COMMANDS, shown(word))

        return self._kept(self.connector.subscribe(VOICE_COMMANDS, STRING, receive))

    def _kept(self, *closes: Close) -> Close:
        self._closes += closes

        def close() -> None:
            for each in closes:
                each()

        return close


def _passing(on_message: Callable[[HRIMessage], object]) -> Callable[[ReceivedMessage], object]:
    return lambda found: on_message(found.message)


def _logged(fault: ReceivedMessage | ConnectorError) -> None:
    if isinstance(fault, ReceivedMessage):
        log.warning("a message of '%s' is not whole: %s", cut(fault.message.name, 40), cut(fault.why, 200))
    else:
        log.warning("%s", cut(fault, 300))

# SPDX-License-Identifier: Apache-2.0
"""A connector that is recorded: it does what the one inside does, and hands what is received to the recording.

Rule: what a mission receives is the same with it and without it.
"""

from __future__ import annotations

import time

from rai_missions.connectors.connector import (
    Close,
    Connector,
    Data,
    Message,
    OnMessage,
    OnReply,
    OnReport,
    RawMessage,
    Reply,
    Report,
    SupportsRawMessages,
)
from rai_missions.connectors.wrapper import ConnectorWrapper
from rai_missions.errors import ConnectorError
from rai_missions.recording.recording import Recording

__all__ = ("RecordedConnector", "recorded")


class RecordedConnector(ConnectorWrapper):
    """Around a `Connector`, for the mission that runs with it; another user of the one inside is not recorded.

    Args:
        inner: Does everything.
        recording: Learns what is received: messages (raw where they can be had so), replies and reports.
    """

    def __init__(self, inner: Connector, recording: Recording) -> None:
        super().__init__(inner)
        self._recording = recording
        self._keeps: dict[str, object] = {}

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        """Subscribe; a topic that is subscribed to more than once is recorded once."""
        key = object()

        def is_kept() -> bool:
            return self._keeps.setdefault(topic, key) is key

        def record(message: Message) -> None:
            if is_kept():
                self._recording.received(message, type_name)
            on_message(message)

        definition = self._definition(type_name)
        if isinstance(self.inner, SupportsRawMessages) and definition:

            def record_raw(message: RawMessage) -> None:
                if is_kept():
                    self._recording.received_raw(message, definition)

            close = self.inner.tap(topic, type_name, on_message, record_raw)
        else:
            close = self.inner.subscribe(topic, type_name, record)

        def end() -> None:
            close()
            if self._keeps.get(topic) is key:
                del self._keeps[topic]

        return end

    def _definition(self, type_name: str) -> str:
        """How the bytes of a type are read; empty where no one knows, and messages are recorded as plain data."""
        try:
            return self.inner.definition(type_name) if isinstance(self.inner, SupportsRawMessages) else ""
        except ConnectorError:
            return ""

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        began = time.monotonic()

        def record(reply: Reply) -> None:
            self._recording.called(service, request, reply, time.monotonic() - began)
            on_reply(reply)

        self.inner.call(service, type_name, request, on_reply=record, timeout_s=timeout_s)

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        self.inner.send_goal(action, type_name, goal, goal_id=goal_id, on_report=self._recorded(action, on_report))

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        self.inner.find_goal(action, type_name, goal_id=goal_id, on_report=self._recorded(action, on_report))

    def _recorded(self, action: str, on_report: OnReport) -> OnReport:
        def record(one: Report) -> None:
            self._recording.reported(action, one)
            on_report(one)

        return record


def recorded(connector: Connector | None, recording: Recording) -> Connector | None:
    """A connector as a mission is to have it: recorded, where there is one."""
    return RecordedConnector(connector, recording) if connector is not None else None

# SPDX-License-Identifier: Apache-2.0
"""What the world has to state, kept until its step is over.

Rule: nothing leaves while the world's lock is held, so anyone who receives it may call the world's services at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Mapping
from typing import Any, ClassVar

from rai_missions.connectors.connector import ActionServer, Connector, Data, OnReport, SupportsPreconnect

__all__ = ("LockedServer", "Outbox")


class Outbox:
    """Messages and reports on their way out.

    Args:
        prefix: What the names of topics begin with, such as `/tractor1`; may be empty.
        types: Topics, without the prefix, and the types of their messages.
    """

    LEADS_OUT: ClassVar = {"_connector": lambda: None, "_waiting": list}

    def __init__(self, prefix: str, types: Mapping[str, str]) -> None:
        self.lock = threading.RLock()
        self._connector: Connector | None = None
        self._prefix, self._types = prefix, types
        self._waiting: list[Callable[[], None]] = []
        self._sent: dict[str, Any] = {}

    def open(self, connector: Connector, without: Collection[str] = ()) -> None:
        """Publish on a connector from now on; every topic is visible at once, silent ones too.

        Args:
            connector: Where to.
            without: Topics that this world will not have.
        """
        self._connector = connector
        if isinstance(connector, SupportsPreconnect):
            for name in self._types.keys() - set(without):
                connector.expect("topics", self.name(name), self._types[name])

    def name(self, name: str) -> str:
        return f"{self._prefix}/{name}"

    def add(self, send: Callable[[], None]) -> None:
        self._waiting.append(send)

    def publish(self, name: str, message: Data) -> None:
        connector = self._connector
        if connector is not None:
            self.add(lambda: connector.publish(self.name(name), self._types[name], message))

    def put(self, name: str, fact: Any, message: Data, *, anyway: bool = False) -> None:
        """Publish a fact if it is not what was reported last, or anyway."""
        if anyway or self._sent.get(name) != fact:
            self._sent[name] = fact
            self.publish(name, message)

    def send(self) -> None:
        """Let everything go that waits, with no lock held."""
        with self.lock:
            out, self._waiting = self._waiting, []
        for one in out:
            one()


class LockedServer:
    """An action server behind the world's lock."""

    def __init__(self, server: ActionServer, outbox: Outbox) -> None:
        self._server, self._outbox = server, outbox

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        with self._outbox.lock:
            self._server.accept(goal_id, goal, report)
        self._outbox.send()

    def cancel(self, goal_id: str) -> None:
        with self._outbox.lock:
            self._server.cancel(goal_id)
        self._outbox.send()

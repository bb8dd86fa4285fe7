# SPDX-License-Identifier: Apache-2.0
"""A connector that loses, delays, repeats, reorders, backdates and garbles what passes through it.

Rule: what it does follows from its seed. A reply that it loses comes as `timed_out` where a time was set, as from any
connector; where none was set it never comes.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Data, Message, OnMessage, OnReply, OnReport, Reply
from rai_missions.connectors.wrapper import ConnectorWrapper

__all__ = ("ChaosConnector", "Rates")

Later = Callable[[float, Callable[[], None]], None]
"""Has something done after so many seconds."""
GARBAGE: tuple[Any, ...] = (math.nan, math.inf, -math.inf, None, "", "nan", [], {}, b"\xff", -(2**70), object())


@dataclass(frozen=True)
class Rates:
    """The probability, 0 to 1, of each fault of a `ChaosConnector`."""

    lose: float = 0.05
    delay: float = 0.2
    """By up to `longest_s`; whatever is delayed may be overtaken."""
    repeat: float = 0.05
    backdate: float = 0.05
    """A message on a topic comes with a stamp of up to `longest_s` ago."""
    garble: float = 0.05
    """A field of a message on a topic is NaN, infinite, missing, or of another type."""
    silence: float = 0.0
    """The last message of a topic has come."""
    longest_s: float = 1.0


def by_thread(seconds: float, do: Callable[[], None]) -> None:
    """Later on the wall's clock."""
    timer = threading.Timer(seconds, do)
    timer.daemon = True
    timer.start()


class ChaosConnector(ConnectorWrapper):
    """A `Connector` that loses, delays, repeats and spoils what goes through another one, for drills without a robot.

    Args:
        connector: The other one.
        seed: The same seed and the same traffic have the same faults.
        incoming: How often what of messages received, replies and reports.
        outgoing: How often what of messages sent, calls, goals and cancels.
        later: Has something done after so many seconds; on the wall's clock by default.
    """

    def __init__(
        self,
        connector: Connector,
        seed: object,
        *,
        incoming: Rates | None = None,
        outgoing: Rates | None = None,
        later: Later = by_thread,
    ) -> None:
        super().__init__(connector)
        self._random, self._later = Random(f"chaos {seed}"), later
        self._incoming, self._outgoing = incoming or Rates(), outgoing or Rates()
        self._lock = threading.Lock()
        self._silent: set[str] = set()
        self._sent: set[str] = set()

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        def disturbed(message: Message) -> None:
            if self._befalls(self._incoming.silence):
                self._silent.add(topic)
            if topic not in self._silent:
                self._pass(self._incoming, lambda: on_message(self._spoiled(message)))

        return self.inner.subscribe(topic, type_name, disturbed)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        self._pass(self._outgoing, lambda: self.inner.publish(topic, type_name, message))

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        is_over = threading.Event()

        def replied(reply: Reply) -> None:
            is_over.set()
            on_reply(reply)

        def give_up() -> None:
            if not is_over.is_set():
                replied(Reply("timed_out", {}, f"{service} did not answer within {timeout_s:g} s"))

        def ask() -> None:
            self.inner.call(
                service,
                type_name,
                request,
                timeout_s=timeout_s,
                on_reply=lambda reply: self._pass(self._incoming, lambda: replied(reply)),
            )

        if timeout_s is not None:
            self._later(timeout_s, give_up)
        self._pass(self._outgoing, ask)

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        def send() -> None:
            with self._lock:
                is_known = goal_id in self._sent
                self._sent.add(goal_id)
            if not is_known:  # servers know a goal by its id, and take it once
                self.inner.send_goal(action, type_name, goal, goal_id=goal_id, on_report=self._reporting(on_report))

        self._pass(self._outgoing, send)

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        found = self._reporting(on_report)
        self._pass(self._outgoing, lambda: self.inner.find_goal(action, type_name, goal_id=goal_id, on_report=found))

    def cancel_goal(self, goal_id: str) -> None:
        self._pass(self._outgoing, lambda: self.inner.cancel_goal(goal_id))

    def _reporting(self, on_report: OnReport) -> OnReport:
        return lambda one: self._pass(self._incoming, lambda: on_report(one))

    def _pass(self, rates: Rates, do: Callable[[], None]) -> None:
        """Do it, or not, or later, or twice."""
        if self._befalls(rates.lose):
            return
        for _ in range(2 if self._befalls(rates.repeat) else 1):
            if self._befalls(rates.delay):
                self._later(self._between(0.0, rates.longest_s), lambda: do() if self.running else None)
            else:
                do()

    def _spoiled(self, message: Message) -> Message:
        if self._befalls(self._incoming.backdate):
            message = message._replace(at=message.at - self._between(0.0, self._incoming.longest_s))
        if not self._befalls(self._incoming.garble) or not message.data:
            return message
        with self._lock:
            name, value = self._random.choice(sorted(message.data)), self._random.choice(GARBAGE)
        return message._replace(data={**message.data, name: value})

    def _befalls(self, rate: float) -> bool:
        with self._lock:
            return self._random.random() < rate

    def _between(self, least: float, most: float) -> float:
        with self._lock:
            return self._random.uniform(least, most)

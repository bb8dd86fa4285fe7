# SPDX-License-Identifier: Apache-2.0
"""A world in a process of its own: its robot on a connector that other processes reach, its time on `/clock`.

Rule: what this machine has no types for is left out, and reported; the rest of the robot is there.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from rai_missions.connectors.connector import (
    ActionServer,
    Answer,
    Close,
    Connector,
    ConnectorMode,
    Data,
    SupportsDiscoveryCount,
    SupportsPreconnect,
)
from rai_missions.connectors.wrapper import ConnectorWrapper
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut, logger
from rai_missions.worlds.messages import stamp
from rai_missions.worlds.world import World

__all__ = ("CLOCK", "PublishedWorld", "TrackedConnector", "taken_names")

log = logger(__name__)

CLOCK, CLOCK_TYPE = "/clock", "rosgraph_msgs/msg/Clock"
FLUSH = 20
"""Steps between two waits for what was published to have left: a world that goes faster would be received ever
later."""
LONGEST = 60
"""Characters of a fact that is reported."""


class TrackedConnector(ConnectorWrapper):
    """What a world has on a connector, remembered by name.

    Args:
        connector: Where it is; the front passes everything on to it.
        on_fact: Is notified of each plain fact (a number, a truth, a word on a topic) that is not what it was: name
            and fact.
        taken: Mode → names that someone else has there, as `taken_names` found them; to open one of them is refused.
    """

    def __init__(
        self,
        connector: Connector,
        on_fact: Callable[[str, Any], None] = lambda _name, _fact: None,
        taken: Mapping[ConnectorMode, Collection[str]] | None = None,
    ) -> None:
        super().__init__(connector)
        self._on_fact, self._taken = on_fact, taken or {}
        self.topics: dict[str, str] = {}
        self.services: dict[str, str] = {}
        self.actions: dict[str, str] = {}
        """Name → type of what is there."""
        self.left_out: dict[str, str] = {}
        """Name → why it is not there."""
        self._facts: dict[str, Any] = {}

    def expect(self, mode: ConnectorMode, name: str, type_name: str) -> None:
        """Have a topic seen before anything is published on it."""
        if mode == "topics":
            _refuse_taken(mode, name, self._taken)
        if isinstance(self.inner, SupportsPreconnect):
            try:
                self.inner.expect(mode, name, type_name)
            except ConnectorError as fault:
                self._leave_out(name, fault)
            else:
                if mode == "topics":
                    self.topics[name] = type_name

    def refuse_rivals(self) -> None:
        """See that no one else has by now what is here.

        Raises:
            UsageError: Someone has.
        """
        ours: Mapping[ConnectorMode, Collection[str]] = {
            "topics": self.topics,
            "services": self.services,
            "actions": self.actions,
        }
        for mode, counts in _counted(self.inner).items():
            for name, count in counts.items():
                if count > 1 and name in ours[mode]:
                    _refuse_taken(mode, name, ours)

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        _refuse_taken("services", service, self._taken)
        return self._add(self.services, service, type_name, lambda: self.inner.serve(service, type_name, answer))

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        _refuse_taken("actions", action, self._taken)
        return self._add(self.actions, action, type_name, lambda: self.inner.offer(action, type_name, server))

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        if topic in self.left_out:
            return
        try:
            self.inner.publish(topic, type_name, message)
        except ConnectorError as fault:
            self._leave_out(topic, fault)
            return
        self.topics[topic] = type_name
        self._publish(topic, message)

    def _add(self, names: dict[str, str], name: str, type_name: str, open_it: Callable[[], Close]) -> Close:
        try:
            close = open_it()
        except ConnectorError as fault:
            self._leave_out(name, fault)
            return lambda: None
        names[name] = type_name
        return close

    def _leave_out(self, name: str, fault: ConnectorError) -> None:
        self.left_out[name] = str(fault)
        log.info("%s is left out: %s", name, fault)

    def _publish(self, topic: str, message: Mapping[str, Any]) -> None:
        fact = message.get("data")
        is_plain = isinstance(fact, bool | int) or (isinstance(fact, str) and fact[:1] not in ("{", "["))
        if is_plain and len(message) == 1 and (topic not in self._facts or self._facts[topic] != fact):
            self._facts[topic] = fact
            self._on_fact(topic, fact if not isinstance(fact, str) else cut(fact, LONGEST))


def taken_names(connector: Connector) -> Mapping[ConnectorMode, Collection[str]]:
    """What others have on a connector, by mode, as far as it can determine who is there."""
    return {mode: frozenset(counts) for mode, counts in _counted(connector).items()}


def _counted(connector: Connector) -> Mapping[ConnectorMode, Mapping[str, int]]:
    return (
        {mode: connector.offered(mode) for mode in connector.modes}
        if isinstance(connector, SupportsDiscoveryCount)
        else {}
    )


def _refuse_taken(mode: ConnectorMode, name: str, taken: Mapping[ConnectorMode, Collection[str]]) -> None:
    if name in taken.get(mode, ()):
        does = "publishes" if mode == "topics" else "serves"
        raise UsageError(
            f"another world or robot is there and {does} {name}: the two would fight over it; end the other one, or "
            "keep them apart: --domain N here, and ROS_DOMAIN_ID=N for what shall meet this one"
        )


class PublishedWorld:
    """A world that reports after each step what time it is, so that anyone who reaches it can live by its time.

    Args:
        world: Opened on the connector.
        connector: Where its time is reported.
    """

    def __init__(self, world: World, connector: Connector) -> None:
        self._world, self._connector = world, connector
        if isinstance(connector, SupportsPreconnect):
            connector.expect("topics", CLOCK, CLOCK_TYPE)
        self.period_s = world.period_s
        self._steps = 0

    @property
    def at(self) -> float:
        return self._world.at

    def step(self) -> None:
        self._world.step()
        self._steps += 1
        if self._steps % FLUSH == 0:
            self._connector.listed("topics")  # answered after all that was asked before
        self._connector.publish(CLOCK, CLOCK_TYPE, {"clock": stamp(self._world.at)})

# SPDX-License-Identifier: Apache-2.0
"""Anyone who publishes to the actuators past the gate is notified of, once for each time that it comes."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import pytest

from rai_missions.connectors.connector import ConnectorMode
from rai_missions.connectors.local import LocalConnector
from rai_missions.gate import bypass_monitor
from rai_missions.gate.bypass_monitor import BypassMonitor


class Counted(LocalConnector):
    """A connector on which so many publish."""

    def __init__(self) -> None:
        super().__init__()
        self.topics: dict[str, int] = {}

    def offered(self, mode: ConnectorMode) -> Mapping[str, int]:
        return self.topics if mode == "topics" else {}


def test_others_on_an_actuator_s_topic_are_notified_of_once_until_they_have_gone() -> None:
    results: list[tuple[str, int]] = []
    connector = Counted()
    neighbours = BypassMonitor(connector, ["/cmd_vel", "/arm"], lambda topic, count: results.append((topic, count)))
    for count in (0, 1, 1):
        connector.topics = {"/cmd_vel": count, "/status": 5}
        neighbours.look()
    assert results == [], "the gate itself is no other"
    for count in (3, 3, 1, 2):
        connector.topics = {"/cmd_vel": count}
        neighbours.look()
    assert results == [("/cmd_vel", 2), ("/cmd_vel", 1)]


def test_a_connector_that_cannot_determine_finds_no_one_and_the_watch_ends_when_asked_to() -> None:
    results: list[tuple[str, int]] = []
    neighbours = BypassMonitor(LocalConnector(), ["/cmd_vel"], lambda topic, count: results.append((topic, count)))
    neighbours.run()
    neighbours.run()
    neighbours.look()
    neighbours.stop()
    neighbours.stop()
    assert results == []


def test_it_looks_by_itself_until_it_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bypass_monitor, "LOOK_S", 0.001)
    found = threading.Event()
    connector = Counted()
    connector.topics = {"/cmd_vel": 2}
    neighbours = BypassMonitor(connector, ["/cmd_vel"], lambda topic, count: found.set())
    threads = set(threading.enumerate())
    neighbours.run()
    assert found.wait(10)
    neighbours.stop()
    assert set(threading.enumerate()) <= threads

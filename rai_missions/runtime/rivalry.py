# SPDX-License-Identifier: Apache-2.0
"""Whether each action of a mission has one server before the mission starts; two would both move the robot.

Rule: it only asks the connector. One that cannot have two servers on a name is not asked.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

from rai_missions.connectors.connector import Connector, Surveyor
from rai_missions.profile import Robot

__all__ = ("Rivalry",)


class Rivalry:
    """A survey of the servers of a mission's actions.

    Args:
        robot: The profile.
        connector: How the robot is reached.
        wake: Called, from any thread, once all is known.
    """

    def __init__(self, robot: Robot, connector: Connector | None, wake: Callable[[], None]) -> None:
        self._robot, self._connector, self._wake = robot, connector, wake
        self._lock = threading.Lock()
        self._asked = 0
        self._found: list[str] = []

    def ask(self, actions: Iterable[str], within_s: float) -> None:
        """Find out who serves these actions.

        Args:
            actions: Their names in the mission.
            within_s: How long a second server may take to go.
        """
        connector: object = self._connector
        if not isinstance(connector, Surveyor):
            return
        entries = (self._robot.actions.get(name) for name in actions)
        servers = {(entry.action, entry.type) for entry in entries if entry is not None and entry.action is not None}
        self._asked += len(servers)
        for action, type_name in sorted(servers):
            connector.survey(action, type_name, within_s=within_s, on_result=self._receive)

    @property
    def is_known(self) -> bool:
        """Every answer has come."""
        return len(self._found) >= self._asked

    @property
    def contests(self) -> tuple[str, ...]:
        """The actions that more than one server serves, a sentence each."""
        return tuple(each for each in self._found if each)

    def _receive(self, contest: str) -> None:
        with self._lock:
            self._found.append(contest)
        if self.is_known:
            self._wake()

# SPDX-License-Identifier: Apache-2.0
"""What runs command over one connector: each program reports its own run, and warns of others that command the same.

Rule: a warning is written down once a pair of runs, in the log and in the journal; it stops nothing.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress

from rai_missions.agents.other_missions import RUNS_TOPIC, OtherMissions, RunClaim, warning_of
from rai_missions.connectors.connector import Close, Connector, Message
from rai_missions.connectors.registry import connector_offer
from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError
from rai_missions.plain_data import carried
from rai_missions.profile import Robot, commanded_names
from rai_missions.redaction import logger
from rai_missions.runtime.runner import Runner

__all__ = ("RunClaims", "claiming", "full_name")

log = logger(__name__)
STRING = "std_msgs/msg/String"
EXCHANGE_S = 1.0
"""How often a run without a node reports what it commands."""
FAREWELL_S = 1.0


class RunClaims:
    """The claims of one program, whose runs come one after the other.

    Args:
        connector: Carries them.
        namespace: In which a relative name is, without slashes at its ends.
        instance: The instance of the program; one of its own by default.
        node: The full name of its node; empty where it has none.
    """

    def __init__(self, connector: Connector, namespace: str, *, instance: str = "", node: str = "") -> None:
        self._connector, self._others = connector, OtherMissions()
        self._namespace = namespace
        self._own = RunClaim(instance or uuid.uuid4().hex[:12], node, "", "")

    def receive(self, message: Message) -> None:
        """A program has reported what its run commands."""
        self._others.receive(str(message.data.get("data", "")), time.monotonic())

    def exchange(self, runner: Runner | None, commands: Iterable[str]) -> tuple[str, ...]:
        """Report what the run commands; a sentence of each other run that commands it too, written down once.

        Args:
            runner: The run; None where there is none.
            commands: The robot's names for what it has the robot do.
        """
        claim = self._own
        if runner is not None:  # its own names: a status that was published may be of the run before
            names = frozenset(full_name(each, self._namespace) for each in commands)
            claim = claim._replace(mission=runner.mission.name, run=runner.run_id, commands=names)
        self._connector.publish(RUNS_TOPIC, STRING, carried({"data": claim.text()}))
        rivals = self._others.rivals(claim, time.monotonic())
        if runner is not None:
            for each in self._others.news(claim, rivals):
                log.warning("%s", warning_of(each))
                runner.note(warning_of(each))
        return tuple(map(warning_of, rivals))


@contextmanager
def claiming(runner: Runner, robot: Robot | None, connector: Connector | None, instance: str = "") -> Iterator[None]:
    """Claim what a run commands that has no node, and warn of others that command it too, while it lasts.

    A robot in this process is shared with no one, and is not claimed.

    Args:
        runner: The run.
        robot: Its profile.
        connector: How the robot is reached; nothing is exchanged before it runs.
        instance: The instance of this program; one of its own by default.
    """
    if robot is None or connector is None or connector_offer(robot.connector["kind"]) is None:
        yield
        return
    claims = RunClaims(connector, str(robot.connector.get("namespace") or "").strip("/"), instance=instance)
    commands = commanded_names(runner.mission, robot)
    closes = list[Close]()

    def exchange() -> None:
        # A broker that is away is the connector's to report; the claim is made again once it is back.
        with suppress(ConnectorError):
            if not connector.running:
                return
            if not closes:
                closes.append(connector.subscribe(RUNS_TOPIC, STRING, claims.receive))
            claims.exchange(runner, commands)

    worker = Worker("claims of a run", keep="newest", limit=4)
    worker.start()
    worker.every(EXCHANGE_S, exchange)
    try:
        yield
    finally:
        worker.close(FAREWELL_S)
        while closes:
            closes.pop()()


def full_name(name: str, namespace: str) -> str:
    """The full name of an action, a service or a topic.

    Args:
        name: A relative one is in the namespace.
        namespace: Without slashes at its ends; empty for the root.
    """
    return name if name.startswith("/") else f"/{namespace}/{name}" if namespace else f"/{name}"

# SPDX-License-Identifier: Apache-2.0
"""What runs command over one connector: each program reports its own run, and warns of others that command the same.

Rule: a warning is written down once a pair of runs, in the log and in the journal; it stops nothing.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from rai_missions.connectors.connector import Close, Connector, Message
from rai_missions.connectors.worker import Worker
from rai_missions.node.names import NodeName
from rai_missions.node.other_missions import RUNS_TOPIC, OtherMissions, RunClaim, warning_of
from rai_missions.node.services import STRING
from rai_missions.plain_data import carried
from rai_missions.profile import Robot, commanded_names
from rai_missions.redaction import logger
from rai_missions.runtime.runner import Runner

__all__ = ("RunClaims", "claimed")

log = logger(__name__)
EXCHANGE_S = 1.0
"""How often a run without a node reports what it commands."""
FAREWELL_S = 1.0


class RunClaims:
    """The claims of one program, whose runs come one after the other.

    Args:
        connector: Carries them.
        name: Of the node, whose namespace a relative name is in.
        instance: Of the program; one of its own by default.
        is_node: There is a node of that name.
    """

    def __init__(self, connector: Connector, name: NodeName, *, instance: str = "", is_node: bool = True) -> None:
        self._connector, self._name, self._others = connector, name, OtherMissions()
        self._own = RunClaim(instance or uuid.uuid4().hex[:12], name.path if is_node else "", "", "")

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
            names = frozenset(map(self._name.resolved, commands))
            claim = claim._replace(mission=runner.mission.name, run=runner.run_id, commands=names)
        self._connector.publish(RUNS_TOPIC, STRING, carried({"data": claim.text()}))
        rivals = self._others.rivals(claim, time.monotonic())
        if runner is not None:
            for each in self._others.news(claim, rivals):
                log.warning("%s", warning_of(each))
                runner.note(warning_of(each))
        return tuple(map(warning_of, rivals))


@contextmanager
def claimed(runner: Runner, robot: Robot, connector: Connector, *, instance: str) -> Iterator[None]:
    """Claim what a run commands that has no node, while it lasts.

    Args:
        runner: The run.
        robot: Its profile.
        connector: How the robot is reached; nothing is exchanged before it runs.
        instance: Of this program.
    """
    name = NodeName("run", str(robot.connector.get("namespace") or "").strip("/"))
    claims = RunClaims(connector, name, instance=instance, is_node=False)
    commands = commanded_names(runner.mission, robot)
    closes = list[Close]()

    def exchange() -> None:
        if connector.running:
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

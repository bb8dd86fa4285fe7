# SPDX-License-Identifier: Apache-2.0
"""The law of branches: a branch, a replay from the start and the world itself have the same bits and messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.local import LocalConnector

__all__ = ("Client", "Deed", "Plan", "assert_a_replay")


class Deed(NamedTuple):
    """What a client does."""

    what: Literal["call", "goal", "cancel", "publish"]
    name: str
    """Of the service, the action, the goal or the topic."""
    data: Mapping[str, Any] = {}
    kind: str = ""
    """The type of a topic."""


Plan = dict[int, Deed]
"""Step → what is done before it."""


class Client:
    """A client of a world: what it does at which step, and all that comes back.

    Args:
        world: The world.
        plan: What it does; a goal sent at step 7 has the id `<action>@7`.
        topics: What it listens to.
    """

    def __init__(self, world: Any, plan: Plan, topics: tuple[str, ...]) -> None:
        self.world, self.plan = world, plan
        self.received: list[tuple[Any, ...]] = []
        self.connector = LocalConnector(now=lambda: world.at)
        for topic in topics:
            self.connector.subscribe(topic, "", self._receive)
        world.open(self.connector)
        self.connector.start()

    def _receive(self, message: Message) -> None:
        self.received.append((self.world.at, message.topic, message.at, repr(message.data)))

    def _report(self, report: Report) -> None:
        self.received.append((self.world.at, report.goal_id, report.status, repr(report.data), report.why))

    def _reply(self, reply: Reply) -> None:
        self.received.append((self.world.at, "reply", *reply))

    def do(self, deed: Deed, step: int) -> None:
        if deed.what == "goal":
            name = f"{deed.name}@{step}"
            self.connector.send_goal(deed.name, "", deed.data, goal_id=name, on_report=self._report)
        elif deed.what == "cancel":
            self.connector.cancel_goal(deed.name)
        elif deed.what == "publish":
            self.connector.publish(deed.name, deed.kind, deed.data)
        else:
            self.connector.call(deed.name, "", deed.data, on_reply=self._reply)

    def go(self, start: int, end: int) -> None:
        for step in range(start, end):
            if step in self.plan:
                self.do(self.plan[step], step)
            self.world.step()

    def branch(self, at: int, topics: tuple[str, ...]) -> Client:
        """A client of a branch, which is notified of the goals that are under way in it."""
        made = Client(self.world.branch(), self.plan, topics)
        for step, deed in self.plan.items():
            if step < at and deed.what == "goal":
                name = f"{deed.name}@{step}"
                made.connector.find_goal(deed.name, "", goal_id=name, on_report=made._report)
        made.received = [each for each in made.received if each[2] not in ("accepted", "lost")]
        return made


def assert_a_replay(make: Callable[[], Any], plan: Plan, topics: tuple[str, ...], *, at: int, more: int) -> Client:
    """Hold a world to the law; gives the replay.

    Args:
        make: Gives the same world each time.
        plan: What its client does.
        topics: What is compared.
        at: The step at which it is branched.
        more: How many steps are compared.
    """
    replay, origin = Client(make(), plan, topics), Client(make(), plan, topics)
    replay.go(0, at)
    known = len(replay.received)
    replay.go(at, at + more)
    origin.go(0, at)
    branch = origin.branch(at, topics)
    before = everything(origin.world)
    branch.go(at, at + more)
    assert everything(origin.world) == before, "the branch moves nothing in the world"
    assert everything(branch.world) == everything(replay.world) != before
    assert branch.received == replay.received[known:]
    origin.go(at, at + more)
    assert everything(origin.world) == everything(replay.world)
    assert origin.received == replay.received
    for client in (replay, origin, branch):
        client.world.close()
    return replay


def everything(world: Any) -> bytes:
    """All numbers of the physics, the solver's warm start and the contacts included."""
    data = world.data
    size = mujoco.mj_stateSize(world.model, mujoco.mjtState.mjSTATE_INTEGRATION)
    state = np.zeros(size)
    mujoco.mj_getState(world.model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    parts = (state, data.xpos, data.xmat, data.contact.geom, data.contact.dist, data.efc_force, data.actuator_force)
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)

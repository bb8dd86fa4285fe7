# SPDX-License-Identifier: Apache-2.0
"""What every agent with a life of its own is: something that can be started and stopped, and may report how it fares.

Rule: what an agent talks through it has as `connectors`, each a `Connector`; who stops an agent that hangs stops those.
"""

from __future__ import annotations

from collections.abc import Mapping
from inspect import getattr_static
from typing import Literal, NamedTuple, Protocol, TypeGuard, runtime_checkable

from rai_missions.connectors.connector import Connector

__all__ = (
    "Agent", "AgentHealth", "HasConnectors", "ReportsHealth", "StopsSlowly", "lacks", "reports_health", "why_no_agent",
)  # fmt: skip

NOTHING: Mapping[str, str] = {}


class AgentHealth(NamedTuple):
    """The state of an agent, as its runner publishes it on `/diagnostics`."""

    state: Literal["ready", "running", "ended", "failed", "died", "stopped", "hangs"]
    """`ready` to be run; `ended` by itself, its work done; `failed`: it ended by itself, its work undone; `died`;
    `stopped`, by its runner or another; `hangs`: it does not do as it was asked.
    """
    why: str = ""
    """The reason of a fault; a remark elsewhere."""
    values: Mapping[str, str] = NOTHING
    """What else a person may want to know, by name."""

    @property
    def lives(self) -> bool:
        """Whether the agent works, or is about to."""
        return self.state in ("ready", "running")

    @property
    def is_fault(self) -> bool:
        """Something is wrong with it."""
        return self.state in ("failed", "died", "hangs")


@runtime_checkable
class Agent(Protocol):
    """The paper's Agent: what works from `run` to `stop`, next to other agents and independently of them."""

    def run(self) -> None:
        """Begin, and return; running already, nothing happens."""

    def stop(self) -> None:
        """End what was begun, and return within seconds, even where something hangs; stopped already, nothing happens.

        A stopped agent may be run again.
        """


def lacks(given: object, name: str) -> bool:
    """Whether something has no such member; a property that it has is not evaluated."""
    return getattr_static(given, name, None) is None and not hasattr(given, name)


def why_no_agent(given: object) -> str:
    """Why something cannot be run and stopped; empty where it can. No property of it is evaluated, if it has one."""
    if isinstance(given, type):
        return f"{given.__name__} is a class; give an agent of it, {given.__name__}(…)"
    absent = [name for name in ("run", "stop") if lacks(given, name)]
    return f"{type(given).__name__} has no '{absent[0]}'; an agent has run() and stop()" if absent else ""


class ReportsHealth(Protocol):
    """An agent that knows how it fares."""

    @property
    def health(self) -> AgentHealth:
        """How it fares now; from any thread, at once."""


def reports_health(agent: object) -> TypeGuard[ReportsHealth]:
    """Whether an agent knows how it fares; it is not asked, since one that hangs may not answer."""
    return getattr_static(agent, "health", None) is not None


@runtime_checkable
class HasConnectors(Protocol):
    """An agent whose ways to robots and people are known."""

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """What each is for → the connector. The agent starts and stops what is its own."""


@runtime_checkable
class StopsSlowly(Protocol):
    """An agent whose end takes its time: a mission that brings the robot to rest first."""

    @property
    def stop_s(self) -> float:
        """How long `stop` may take, in seconds."""

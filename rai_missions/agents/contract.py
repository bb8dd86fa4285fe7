# SPDX-License-Identifier: Apache-2.0
"""What every agent must do, as a function that its tests call."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.agents.agent import Agent, AgentHealth, HasConnectors, reports_health, why_no_agent
from rai_missions.answerers.contract import at_once
from rai_missions.connectors.connector import Connector
from rai_missions.given import check_function

__all__ = ("check_agent",)

HEALTH_S = 1.0


def check_agent(make: Callable[[], Agent], *, within_s: float = 5.0) -> None:
    """Hold an agent to the contract of `Agent`: it runs and stops as often as it is asked to, and leaves no thread.

    One that reports its health does so at once: it lives or has ended while it is run, lives no more once it is
    stopped, and gives a reason where it died. What it names as connectors are such, and none that it has started runs
    on.

    Args:
        make: Gives a fresh agent, not running.
        within_s: How long `run` and `stop` may take each.

    Raises:
        AssertionError: A promise is broken; the text names it.
        UsageError: An agent was given, not what makes one.
    """
    check_function(make, "check_agent", "what makes an agent", "give its class, or a function")
    before = set(threading.enumerate())
    agent = make()
    assert not (why := why_no_agent(agent)), why
    connectors = agent.connectors.values() if isinstance(agent, HasConnectors) else ()
    assert all(isinstance(each, Connector) for each in connectors), "what an agent names as a connector is one"
    opened = [each for each in connectors if each.running]
    for act, times in (("stop", 1), ("run", 2), ("stop", 2), ("run", 1), ("stop", 1)):
        for _ in range(times):
            at_once(act, getattr(agent, act), within_s)
            _check_health(agent, act)
    left = [each for each in connectors if each.running and each not in opened]
    assert not left, "stop closes the connectors that run has opened"
    for thread in set(threading.enumerate()) - before:
        thread.join(within_s)
        assert not thread.is_alive(), f"stop leaves the thread '{thread.name}' behind"


def _check_health(agent: Agent, act: str) -> None:
    if not reports_health(agent):
        return
    found: list[AgentHealth] = []
    at_once("health", lambda: found.append(agent.health), HEALTH_S)
    (health,) = found
    assert health.why or not health.is_fault, f"an agent that {health.state} states why"
    assert health.state != "hangs", f"after {act}: {health.why}"
    assert act == "run" or health.state != "running", "an agent that was stopped runs no more"
    assert act == "stop" or health.state != "stopped", "an agent that was run is not stopped"

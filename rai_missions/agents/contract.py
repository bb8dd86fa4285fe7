# SPDX-License-Identifier: Apache-2.0
"""What every agent must do, as a function that its tests call."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.agents.agent import Agent
from rai_missions.answerers.contract import at_once

__all__ = ("check_agent",)


def check_agent(make: Callable[[], Agent], *, within_s: float = 5.0) -> None:
    """Hold an agent to the contract of `Agent`: it runs and stops as often as it is asked to, and leaves no thread.

    Args:
        make: Gives a fresh agent, not running.
        within_s: How long `run` and `stop` may take each.

    Raises:
        AssertionError: A promise is broken; the text names it.
    """
    before = set(threading.enumerate())
    agent = make()
    for act, times in (("stop", 1), ("run", 2), ("stop", 2), ("run", 1), ("stop", 1)):
        for _ in range(times):
            at_once(act, getattr(agent, act), within_s)
    for thread in set(threading.enumerate()) - before:
        thread.join(within_s)
        assert not thread.is_alive(), f"stop leaves the thread '{thread.name}' behind"

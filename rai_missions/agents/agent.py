# SPDX-License-Identifier: Apache-2.0
"""What every agent with a life of its own is: something that can be started and stopped."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

__all__ = ("Agent",)


@runtime_checkable
class Agent(Protocol):
    """The paper's Agent: it lives between `run` and `stop`, whatever happens around it."""

    def run(self) -> None:
        """Begin, and return; running already, nothing happens."""

    def stop(self) -> None:
        """End what was begun, and return within seconds, even where something hangs; stopped already, nothing happens.

        A stopped agent may be run again.
        """

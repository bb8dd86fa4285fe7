# SPDX-License-Identifier: Apache-2.0
"""A simulated robot and its surroundings, as a connector's peer.

Rule: a world keeps no clock but its own simulated time, and the same seed and the same calls give the same run, to the bit.
"""

from __future__ import annotations

from typing import Protocol

from rai_missions.connectors.connector import Connector

__all__ = ("World",)


class World(Protocol):
    """What the simulated clock steps and the robot profile names."""

    at: float
    """Simulated seconds since the start."""
    period_s: float
    """How far one step goes: messages, services and control happen at this grain."""

    def open(self, connector: Connector) -> None:
        """Put the robot's topics, services and actions on a connector."""

    def step(self) -> None:
        """Go one period on, publishing what happened."""

    def close(self) -> None:
        """Free what is held (renderers, windows)."""

# SPDX-License-Identifier: Apache-2.0
"""A world: a greenhouse whose humidity falls, until its bell has been struck so often that a person waters it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.connector import Connector

__all__ = ("Greenhouse",)


class Greenhouse:
    """A humidity that falls by 1 % a second from a start, and a bell; the second strike waters."""

    period_s = 0.5

    def __init__(self, humidity: float = 0.5, seed: int = 0, start_s: float = 0.0) -> None:
        self._humidity, self._steps, self._start_s, self._strikes = humidity, 0, start_s, 0
        self._connector: Connector | None = None

    @property
    def at(self) -> float:
        return self._start_s + self._steps * self.period_s

    def open(self, connector: Connector) -> None:
        self._connector = connector
        connector.serve("/bell", "", self._struck)

    def _struck(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        self._strikes += 1
        if self._strikes % 2 == 0:
            self._humidity = 0.55
        return {"success": True, "message": ""}

    def step(self) -> None:
        self._steps += 1
        self._humidity -= 0.005
        if self._connector is not None:
            self._connector.publish("/humidity", "", {"data": round(self._humidity, 6)})

    def close(self) -> None:
        self._connector = None

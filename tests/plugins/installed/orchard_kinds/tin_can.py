# SPDX-License-Identifier: Apache-2.0
"""A connector of the kind `tin_can`: everything in this process, over a greenhouse that is watered at once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError

__all__ = ("open_connector",)


class TinCan(LocalConnector):
    """Sends a humidity as soon as there is a subscriber, and again after each strike of its bell."""

    def __init__(self, humidity: float, now: Callable[[], float] | None) -> None:
        super().__init__(**({"now": now} if now is not None else {}))
        self._humidity, self._over = humidity, threading.Event()

    def start(self) -> None:
        super().start()
        self.serve("/bell", "", self._struck)
        self._over.clear()
        threading.Thread(target=self._send, daemon=True).start()

    def stop(self) -> None:
        self._over.set()
        super().stop()

    def _send(self) -> None:
        while not self._over.wait(0.02):
            self.publish("/humidity", "", {"data": self._humidity})

    def _struck(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        self._humidity = 0.55
        return {"success": True, "message": ""}


def open_connector(options: Mapping[str, Any], *, now: Callable[[], float] | None = None) -> TinCan:
    """A connector, not started; `humidity` is what it sends first."""
    if unknown := sorted(set(options) - {"humidity"}):
        raise UsageError(f"a tin can takes no '{unknown[0]}'")
    return TinCan(float(options.get("humidity", 0.5)), now)

# SPDX-License-Identifier: Apache-2.0
"""A connection that is cut off where no request comes: a client that sends nothing holds no place that is needed.

Rule: a request that has begun is not hurried here: who sends it is asked for the token before its body is read, and
`posts` bounds how long the body may take.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ("MOST_CONNECTIONS", "Impatient")

SPEAKS_WITHIN_S = 10.0
MOST_CONNECTIONS = 128
"""With one more the oldest that has no request under way is cut off: strangers take neither all files of the process
nor the room of an order."""


class Impatient(H11Protocol):
    """HTTP/1.1 that waits for the head of the first request, and not for ever."""

    _due: asyncio.TimerHandle | None = None
    began = 0.0
    """When it was made, on the clock of its loop."""

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        loop = asyncio.get_running_loop()
        self.began, self._due = loop.time(), loop.call_later(SPEAKS_WITHIN_S, self._hang_up)
        if len(self.connections) > MOST_CONNECTIONS:
            others = (each for each in self.connections if isinstance(each, Impatient) and each is not self)
            oldest = min((each for each in others if each.is_idle), key=lambda each: each.began, default=None)
            if oldest is not None:
                oldest.transport.abort()

    @property
    def is_idle(self) -> bool:
        """No request is under way, and it is not about to close."""
        cycle = getattr(self, "cycle", None)
        return (cycle is None or cycle.response_complete) and not self.transport.is_closing()

    def connection_lost(self, exc: Exception | None) -> None:
        if self._due is not None:
            self._due.cancel()
        super().connection_lost(exc)

    def _hang_up(self) -> None:
        if getattr(self, "cycle", None) is None and not self.transport.is_closing():
            self.transport.abort()

# SPDX-License-Identifier: Apache-2.0
"""A connection that is cut off where no request comes: a client that sends nothing holds no place for long.

Rule: a request that has begun is not hurried here: who sends it is asked for the token before its body is read, and
`posts` bounds how long the body may take.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ("Impatient",)

SPEAKS_WITHIN_S = 10.0


class Impatient(H11Protocol):
    """HTTP/1.1 that waits for the head of the first request, and not for ever."""

    _due: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self._due = asyncio.get_running_loop().call_later(SPEAKS_WITHIN_S, self._hang_up)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._due is not None:
            self._due.cancel()
        super().connection_lost(exc)

    def _hang_up(self) -> None:
        if getattr(self, "cycle", None) is None and not self.transport.is_closing():
            self.transport.abort()

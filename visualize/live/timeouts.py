# SPDX-License-Identifier: Apache-2.0
"""A connection that is cut off where no request comes: a client that sends nothing holds no place that is needed.

Rule: a request that has begun is not hurried here: who sends it is asked for the token before its body is read, and
`posts` bounds how long the body may take.
"""

from __future__ import annotations

import asyncio
import ssl
from contextlib import suppress
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ("MOST_CONNECTIONS", "Impatient", "TLSHandshake")

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
        _make_room(self.connections, self)

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


class TLSHandshake(asyncio.Protocol):
    """A connection that has yet to begin TLS: one of all that are counted, where asyncio would not show it until then.

    Args:
        context: With the certificate.
        given: What an `Impatient` is made with, which has the connection from the handshake on.
    """

    def __init__(self, context: ssl.SSLContext, **given: Any) -> None:
        self._context, self._given = context, given
        self._connections: set[Any] = given["server_state"].connections
        self._early, self._is_lost = b"", False

    def connection_made(self, transport: Any) -> None:
        loop = asyncio.get_running_loop()
        transport.pause_reading()
        self.transport, self.began = transport, loop.time()
        self._connections.add(self)
        _make_room(self._connections, self)
        self._work = loop.create_task(self._begin(loop))

    @property
    def is_idle(self) -> bool:
        """Whether the connection may be used on: it is not about to close."""
        return not self.transport.is_closing()

    async def _begin(self, loop: asyncio.AbstractEventLoop) -> None:
        secure = None
        with suppress(OSError):  # no TLS, none in time, or no connection any more
            secure = await loop.start_tls(
                self.transport, self, self._context, server_side=True, ssl_handshake_timeout=SPEAKS_WITHIN_S
            )
        self._connections.discard(self)
        if secure is None or self._is_lost:
            return
        http = Impatient(**self._given)
        secure.set_protocol(http)
        http.connection_made(secure)
        if self._early:
            http.data_received(self._early)

    def data_received(self, data: bytes) -> None:
        """A request may come with the end of the handshake."""
        self._early += data

    def connection_lost(self, exc: Exception | None) -> None:
        self._is_lost = True

    def shutdown(self) -> None:
        """The server ends."""
        self.transport.abort()


def _make_room(connections: set[Any], newest: Impatient | TLSHandshake) -> None:
    """Cut off the oldest that does nothing, where there are too many."""
    if len(connections) > MOST_CONNECTIONS:
        idle = (each for each in connections if each is not newest and each.is_idle)
        oldest = min(idle, key=lambda each: each.began, default=None)
        if oldest is not None:
            oldest.transport.abort()

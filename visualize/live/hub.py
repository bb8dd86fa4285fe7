# SPDX-License-Identifier: Apache-2.0
"""Passes a run on to its viewers: each message is made once, numbered, and kept for those who come back.

Rule: a viewer that does not keep up is dropped and no one waits for it; with no viewer nothing is made.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rai_missions.errors import UsageError
from visualize.live.feed import Feed
from visualize.live.scene import RunScene

__all__ = ("Hub", "Viewer")

MOST_VIEWERS = 32
MOST_WAITING = 256
"""Messages that a viewer may be behind."""
RING = 512
"""Messages that are kept for viewers who come back."""
BEAT_S = 1.0
"""A viewer that has received nothing for some of these knows that the line is dead."""
PACE_S = 0.015
BOARD_S = 0.1
"""How often values of the blackboard alone are passed on."""


class Viewer:
    """One stream to one browser: messages wait here until it has taken those before.

    Args:
        is_operator: It came with the operator's token.
    """

    def __init__(self, *, is_operator: bool = False) -> None:
        self.is_operator = is_operator
        self._waiting: asyncio.Queue[bytes | None] = asyncio.Queue(MOST_WAITING)
        self.dropped = False

    def put(self, message: bytes) -> None:
        """A message for it; one too many and it is dropped."""
        try:
            self._waiting.put_nowait(message)
        except asyncio.QueueFull:
            self.drop()

    def drop(self) -> None:
        """Nothing more goes to it."""
        self.dropped = True
        while not self._waiting.empty():
            self._waiting.get_nowait()
        self._waiting.put_nowait(None)

    def end(self) -> None:
        """Nothing more comes; what waits is still taken."""
        if self._waiting.full():
            self.drop()
        else:
            self._waiting.put_nowait(None)

    async def next(self) -> bytes | None:
        """The next message; None once it was dropped."""
        return None if self.dropped else await self._waiting.get()


class Hub:
    """The viewers of one run. All of it is called on the server's loop.

    Args:
        feed: What is passed on.
        on_viewers: Called where a viewer has come or gone; never waits.
    """

    def __init__(self, feed: Feed, on_viewers: Callable[[], object] = lambda: None) -> None:
        self._feed, self._on_viewers = feed, on_viewers
        self._boot, self._number = secrets.token_hex(4), 0
        self._ring: deque[tuple[int, bytes]] = deque(maxlen=RING)
        self._viewers: set[Viewer] = set()
        self._news, self._opening = asyncio.Event(), asyncio.Lock()
        self._pump: asyncio.Task[None] | None = None
        self._board_at = self._sent_at = 0.0
        self._is_closed = False
        self.scene = RunScene()

    @property
    def viewers(self) -> int:
        return len(self._viewers)

    @property
    def operators(self) -> int:
        """How many of them are the operator."""
        return sum(viewer.is_operator for viewer in self._viewers)

    async def join(self, last: str = "", *, is_operator: bool = False) -> Viewer:
        """A viewer comes, or comes back with the number of the last message that it has.

        Args:
            last: That number, as the stream gave it.
            is_operator: It comes with the operator's token: where there is no room, another makes room.

        Raises:
            UsageError: There are too many already, or the server ends.
        """
        async with self._opening:
            if self._is_closed:
                raise UsageError("this page is closing; the run may continue")
            if len(self._viewers) >= MOST_VIEWERS and not (is_operator and self._make_room()):
                raise UsageError(f"{MOST_VIEWERS} viewers watch already; close one")
            if self._pump is None or self._pump.done():
                await self._begin()
            viewer = Viewer(is_operator=is_operator)
            self._viewers.add(viewer)
            for message in self._missed(last):
                viewer.put(message)
        self._on_viewers()
        return viewer

    def _make_room(self) -> bool:
        """Drop one who may only look; whether there was one."""
        other = next((viewer for viewer in self._viewers if not viewer.is_operator), None)
        if other is not None:
            other.drop()
            self._viewers.discard(other)
        return other is not None

    def leave(self, viewer: Viewer) -> None:
        """A viewer has gone."""
        self._viewers.discard(viewer)
        self._on_viewers()
        if not self._viewers:
            self._news.set()

    async def close(self) -> None:
        """The server ends: what is left is sent, and every stream with it; who comes later is turned away."""
        self._is_closed = True
        if self._pump is not None and not self._pump.done():
            await self._pass_on(board=True)
            self._pump.cancel()
        self._send_new("end", {})
        for viewer in tuple(self._viewers):
            viewer.end()

    # -- passing on -----------------------------------------------------------------------------------------------

    async def _begin(self) -> None:
        loop, news = asyncio.get_running_loop(), self._news

        def wake() -> None:
            try:
                loop.call_soon_threadsafe(news.set)
            except RuntimeError:  # the server has ended
                return

        self.scene = await self._feed.begin(wake)
        self.scene.set_closed_options(self._feed.closed())
        self._keep("state", self.scene.whole())
        self._pump = asyncio.create_task(self._run())

    async def _run(self) -> None:
        try:
            while self._viewers:
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._news.wait(), self._patience())
                if self._news.is_set() or self.scene.written or self.scene.questions:  # a guard may fall by time alone
                    self._news.clear()
                    await self._pass_on(board=time.monotonic() >= self._board_at)
                if time.monotonic() - self._sent_at >= BEAT_S:  # also where there was news that changes nothing
                    self._send(self._text("beat", {}))
                await asyncio.sleep(PACE_S)
        finally:
            self._feed.end()

    def _patience(self) -> float:
        due = self._board_at if self.scene.written else self._sent_at + BEAT_S
        return max(0.0, due - time.monotonic())

    async def _pass_on(self, *, board: bool) -> None:
        scene = await self._feed.take(self.scene)
        scene.set_closed_options(self._feed.closed() if scene.questions else {})
        if scene is not self.scene:
            self.scene = scene
            self._send_new("state", scene.whole())
            return
        if change := scene.change(board=board):
            self._send_new("change", change)
        if board:
            self._board_at = time.monotonic() + BOARD_S

    def _missed(self, last: str) -> list[bytes]:
        """What a viewer has to receive to be where the others are."""
        boot, _, number = last.partition("-")
        had = int(number) if number.isascii() and number.isdigit() and len(number) < 18 else -1
        if boot == self._boot and self._ring and self._ring[0][0] - 1 <= had <= self._number:
            return [message for each, message in self._ring if each > had]
        return [self._text("state", self.scene.whole(), self._number)]

    def _send_new(self, kind: str, what: dict[str, Any]) -> None:
        self._send(self._keep(kind, what))

    def _keep(self, kind: str, what: dict[str, Any]) -> bytes:
        self._number += 1
        message = self._text(kind, what, self._number)
        self._ring.append((self._number, message))
        return message

    def _send(self, message: bytes) -> None:
        self._sent_at = time.monotonic()
        for viewer in tuple(self._viewers):
            viewer.put(message)
            if viewer.dropped:
                self.leave(viewer)

    def _text(self, kind: str, what: dict[str, Any], number: int = 0) -> bytes:
        """A server-sent event (WHATWG HTML, section 9.2)."""
        data = json.dumps({"now": self._feed.now(), "sent": round(time.monotonic(), 3), **what}, separators=(",", ":"))
        named = f"id: {self._boot}-{number}\n" if number else ""
        return f"{named}event: {kind}\ndata: {data}\n\n".encode()

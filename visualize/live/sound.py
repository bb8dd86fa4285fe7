# SPDX-License-Identifier: Apache-2.0
"""What a page's microphone picks up: taken in pieces, bounded in size and rate, and passed on.

Rule: the page's token sets the role; nothing that comes with the sound does. Nothing of it is kept here.
"""

from __future__ import annotations

from typing import Protocol, get_args

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rai_missions.event import Role
from visualize.live.auth import ROLE, Allowance
from visualize.live.posts import PostRefusal, body_of, refused

__all__ = ("LARGEST_PIECE", "SoundPages", "SoundSink")

LARGEST_PIECE = 32_768
"""Bytes of a piece: a second at 16 kHz, mono, 16 bits, and a little more."""
KIND = "audio/l16"
"""RFC 2586's name for such samples; here they are little-endian, as browsers have them."""
PART = 4096
"""Bytes of 128 ms, in which sound is counted; a piece has one part at least."""
EVERY_S, MOST = 0.08, 40
"""A part comes back after so long: half as much again as there is sound."""
LAST = 8
"""Parts that count where a microphone is shut: a second of silence follows."""


class SoundSink(Protocol):
    """Takes what is spoken into a page; called on the server's loop, and never waits."""

    @property
    def deaf(self) -> str:
        """Why nothing can be recognised; empty if it can."""

    def listen(self, sound: bytes, *, key: str, author: str, role: Role, is_last: bool = False) -> str:
        """Take a piece of sound; why it is not taken, or empty.

        Args:
            sound: 16 kHz, mono, 16 bits.
            key: Which microphone it is.
            author: A free name.
            role: That of the token.
            is_last: The microphone is shut with it.
        """


class SoundPages:
    """The route of sound.

    Args:
        sink: Who listens.
    """

    def __init__(self, sink: SoundSink) -> None:
        self._sink = sink
        self._parts = {role: Allowance(EVERY_S, MOST) for role in get_args(Role)}
        """By role: no viewer uses up what the operator may send."""

    def routes(self) -> list[Route]:
        """By path."""
        return [Route("/sound", self.sound, methods=["POST"])]

    async def sound(self, request: Request) -> Response:
        body = await body_of(request, LARGEST_PIECE, "a piece", KIND)
        if isinstance(body, PostRefusal):
            return refused(*body)
        if len(body) % 2:
            return refused(400, "a piece has whole samples of 2 bytes")
        given, role = request.query_params, request.scope[ROLE]
        is_last = given.get("last", "") == "1"
        if not self._parts[role].take(max(1, -(-len(body) // PART)) + is_last * LAST):
            return refused(429, "more sound than time has passed; wait a second")
        why = self._sink.listen(
            body,
            key=given.get("key", "")[:64],
            author=given.get("by", "")[:64],
            role=role,
            is_last=is_last,
        )
        return refused(409, why) if why else JSONResponse({"success": True, "why": ""})

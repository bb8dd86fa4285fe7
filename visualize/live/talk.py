# SPDX-License-Identifier: Apache-2.0
"""What a person writes to the robot on its page: taken as text, bounded in size and rate, and passed on.

Rule: the page's token sets the role; nothing in the message does. What is written is never markup, here or on a page.
"""

from __future__ import annotations

from typing import Any, Protocol, get_args

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rai_missions.event import Role
from rai_missions.plain_data import json_object
from visualize.live.auth import ROLE, Allowance
from visualize.live.posts import PostRefusal, body_of, refused
from visualize.live.sound import SoundSink

__all__ = ("TalkPages", "TalkSink")

LARGEST_TALK = 16_384
"""Bytes of a message; of a longer one nothing is kept."""


class TalkSink(Protocol):
    """Takes what is written on a page; called on the server's loop, and never waits."""

    def receive(self, text: str, author: str, role: Role) -> str:
        """Take a sentence; why it is not taken, or empty.

        Args:
            text: As it was written.
            author: A free name.
            role: That of the token.
        """

    @property
    def ear(self) -> SoundSink | None:
        """Who listens to the page's microphone; None: it has none."""

    def is_stop(self, text: str) -> bool:
        """Whether it is an order to stop, which finds its way however much is written."""


class TalkPages:
    """The route of talk.

    Args:
        sink: Who is talked to.
    """

    def __init__(self, sink: TalkSink) -> None:
        self._sink = sink
        self._sentences = {role: Allowance(1.0, 8) for role in get_args(Role)}
        self._stops = {role: Allowance(0.5, 10) for role in get_args(Role)}
        """By role: no viewer uses up what the operator may send."""

    def routes(self) -> list[Route]:
        """By path."""
        return [Route("/talk", self.talk, methods=["POST"])]

    async def talk(self, request: Request) -> Response:
        body = await body_of(request, LARGEST_TALK, "a message")
        if isinstance(body, PostRefusal):
            return refused(*body)
        given = _sentence(body)
        if given is None:
            return refused(400, 'a message is a JSON object: {"text": …, "by": …}')
        text, author, role = given["text"], given.get("by", ""), request.scope[ROLE]
        if not (self._stops if self._sink.is_stop(text) else self._sentences)[role].take():
            return refused(429, "too many messages at once; wait a second")
        why = self._sink.receive(text, author[:64], role)
        return refused(409, why) if why else JSONResponse({"success": True, "why": ""})


def _sentence(body: bytes) -> dict[str, Any] | None:
    found = json_object(body)
    if found is None or not isinstance(found.get("text"), str):
        return None
    return found if isinstance(found.get("by", ""), str) else None

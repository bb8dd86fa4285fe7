# SPDX-License-Identifier: Apache-2.0
"""The page on which a mission is played: the graph, what can happen now, and the way back.

Rule: the page shows what the play reports, and orders by name; what an order means is decided where the play is.
"""

from __future__ import annotations

import asyncio
from typing import Any, Protocol

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rai_missions.errors import MissionError
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import json_object
from rai_missions.states.control import CONTROLLERS
from visualize.build import picture
from visualize.live.auth import ASGI, Allowance
from visualize.live.page_files import PageFiles
from visualize.live.posts import LARGEST_ORDER, PostRefusal, body_of
from visualize.page.chart_data import chart_data

__all__ = ("PagePlay", "play_application")

SCRIPTS = ("entry.js", "line.js", "play_fields.js", "play_choices.js", "play.js")
FILES = PageFiles("play.html", SCRIPTS, ("live.css", "play.css"))


class PagePlay(Protocol):
    """A play; called from any thread."""

    def look(self) -> dict[str, Any]:
        """All that the page shows of the present."""

    def act(self, order: dict[str, Any]) -> dict[str, Any]:
        """Carry out an order; returns what the page shows then.

        Raises:
            MissionError: It makes no sense now, and nothing has changed.
        """


class PlayPages:
    """The routes.

    Args:
        mission: What is played.
        play: The play.
    """

    def __init__(self, mission: Mission, play: PagePlay) -> None:
        self._mission = {"chart": chart_data(picture(mission), mission), "holders": dict(CONTROLLERS)}
        self._play = play
        self._orders = Allowance(0.05, 40)

    def routes(self) -> list[Route]:
        """By path."""
        return [
            *FILES.routes(),
            Route("/mission", self.mission),
            Route("/play", self.look),
            Route("/play", self.act, methods=["POST"]),
        ]

    async def mission(self, request: Request) -> Response:
        return JSONResponse(self._mission)

    async def look(self, request: Request) -> Response:
        return JSONResponse(await asyncio.to_thread(self._play.look))

    async def act(self, request: Request) -> Response:
        body = await body_of(request, LARGEST_ORDER, "an order")
        if isinstance(body, PostRefusal):
            return await self._refused(*body)
        if not self._orders.take():
            return await self._refused(429, "too many orders at once; wait a second")
        order = json_object(body)
        if order is None:
            return await self._refused(400, "an order is a JSON object")
        try:
            return JSONResponse(await asyncio.to_thread(self._play.act, order))
        except (MissionError, OSError) as error:
            return await self._refused(409, str(error))

    async def _refused(self, status: int, why: str) -> Response:
        """Why not, and where the play is all the same."""
        return JSONResponse({**await asyncio.to_thread(self._play.look), "why_not": why}, status)


def play_application(mission: Mission, play: PagePlay) -> ASGI:
    """What is behind the door."""
    return Starlette(routes=PlayPages(mission, play).routes())

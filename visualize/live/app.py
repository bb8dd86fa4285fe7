# SPDX-License-Identifier: Apache-2.0
"""What the page asks of its server: the mission, the stream, pictures, and orders.

Rule: an order is passed on as it came to what carries it out; here only its size and its rate are judged.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import json_object
from rai_missions.states.control import CONTROLLERS
from visualize.build import picture
from visualize.live.auth import ASGI, ROLE, Allowance, Receive, Scope, Send
from visualize.live.hub import Hub, Viewer
from visualize.live.images import ImageStream
from visualize.live.page_files import PageFiles
from visualize.live.posts import LARGEST_ORDER, PostRefusal, body_of, refused
from visualize.live.sound import SoundPages
from visualize.live.talk import TalkPages, TalkSink
from visualize.page.as_json import Json
from visualize.page.chart_data import chart_data

__all__ = ("OrderSink", "application")

PATIENCE_S = 1.5
"""How long an order's reply waits for the run to take it; a page waits for 2 s."""
OLDEST_S = 5.0
"""An order that was on its way for longer is not carried out: its author has continued meanwhile."""
SENT_HEADER = "x-mission-sent"
"""When an order was given, by the clock that each message of the stream reports as `sent`."""
ALWAYS = frozenset({"e_stop", "cancel"})
"""Orders that are carried out however late they come."""
STALLED_S = 10.0
"""A viewer that takes nothing for so long is gone."""
MOST_CAMERAS = 32
SCRIPTS = (
    "entry.js", "line.js", "acts.js", "announcer.js", "state.js", "follow.js", "evidence.js", "question.js", "panel.js",
    "chat.js", "speak.js", "live_keys.js", "live.js",
)  # fmt: skip
FILES = PageFiles("live.html", SCRIPTS, ("live.css",), worklet="microphone.js")


class OrderSink(Protocol):
    """Takes the operator's orders."""

    def submit(self, text: str, on_reply: Callable[[bool, str], None]) -> None:
        """Take an order, as JSON; never waits.

        Args:
            text: The order.
            on_reply: Receives once, from any thread, whether it succeeded, and why.
        """


class Stream(Response):
    """Messages to one viewer until either side is gone."""

    def __init__(self, hub: Hub, viewer: Viewer) -> None:
        super().__init__()
        self._hub, self._viewer = hub, viewer

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        gone = asyncio.create_task(_gone(receive))
        gone.add_done_callback(lambda _: self._viewer.drop())
        try:
            headers = [(b"content-type", b"text/event-stream"), (b"x-accel-buffering", b"no")]
            await send({"type": "http.response.start", "status": 200, "headers": headers})
            while (message := await self._viewer.next()) is not None:
                body = {"type": "http.response.body", "body": message, "more_body": True}
                await asyncio.wait_for(send(body), STALLED_S)
            with suppress(TimeoutError):
                await asyncio.wait_for(send({"type": "http.response.body", "body": b""}), 1.0)
        finally:
            gone.cancel()
            self._hub.leave(self._viewer)


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


class Pages:
    """The routes.

    Args:
        mission: Whose run is shown.
        hub: Its viewers.
        sink: Who takes orders; None: the page may look and do nothing.
        about: What the page shows of the run next to what happens: `run`, `journal`, `answers`, `played`.
    """

    def __init__(self, mission: Mission, hub: Hub, sink: OrderSink | None, about: Json) -> None:
        self._hub, self._sink = hub, sink
        self._mission = {
            "chart": chart_data(picture(mission), mission),
            "acts": sink is not None,
            "holders": dict(CONTROLLERS),
            **about,
        }
        self._cameras: OrderedDict[tuple[str, int], ImageStream] = OrderedDict()
        self._orders, self._stops = Allowance(0.2, 20), Allowance(0.5, 10)

    def routes(self) -> list[Route]:
        """By path."""
        return [
            *FILES.routes(),
            Route("/mission", self.mission),
            Route("/events", self.events),
            Route("/picture", self.picture),
            Route("/orders", self.orders, methods=["POST"]),
        ]

    async def mission(self, request: Request) -> Response:
        acts = self._mission["acts"] and request.scope[ROLE] == "operator"
        return JSONResponse({**self._mission, "acts": acts})

    async def events(self, request: Request) -> Response:
        try:
            is_operator = request.scope[ROLE] == "operator"
            viewer = await self._hub.join(request.headers.get("last-event-id", ""), is_operator=is_operator)
        except UsageError as error:
            return refused(503, str(error))
        return Stream(self._hub, viewer)

    async def picture(self, request: Request) -> Response:
        key, number = request.query_params.get("key", ""), request.query_params.get("question", "0")
        question = int(number) if number.isascii() and number.isdigit() and len(number) < 10 else -1
        if self._hub.scene.picture(key, question) is None:
            return refused(404, "there is no such picture now")
        camera = self._cameras.setdefault((key, question), ImageStream())
        self._cameras.move_to_end((key, question))
        while len(self._cameras) > MOST_CAMERAS:
            self._cameras.popitem(last=False)
        kind, data = await camera.show(lambda: self._hub.scene.picture(key, question))
        return Response(data, media_type=kind) if kind else refused(404, data.decode("utf-8", "replace"))

    async def orders(self, request: Request) -> Response:
        if self._sink is None:
            return refused(403, "this page only looks on; orders go to the page that the run itself serves")
        body = await body_of(request, LARGEST_ORDER, "an order")
        if isinstance(body, PostRefusal):
            return refused(*body)
        text = body.decode("utf-8", "replace")  # what is no UTF-8 is judged with the rest of the order
        command = _command(text)
        allowance = self._stops if command == "e_stop" else self._orders
        if not allowance.take():
            return refused(429, "too many orders at once; wait a second")
        if command not in ALWAYS and (why := _is_late(request.headers.get(SENT_HEADER))):
            return refused(409, why)
        return await self._carry(self._sink, text, command)

    async def _carry(self, sink: OrderSink, text: str, command: str) -> Response:
        loop = asyncio.get_running_loop()
        reply: asyncio.Future[tuple[bool, str]] = loop.create_future()

        def settle(success: bool, why: str) -> None:
            if not reply.done():
                reply.set_result((success, why))

        def on_result(success: bool, why: str) -> None:
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(settle, success, why)

        sink.submit(text, on_result)
        try:
            success, why = await asyncio.wait_for(reply, PATIENCE_S)
        except TimeoutError:
            then = (
                "it will as soon as it can"
                if command in ALWAYS
                else f"unless it does within {OLDEST_S:.0f} s, it is dropped"
            )
            return refused(202, f"the run has not taken it yet; {then}, and the journal will state it")
        return JSONResponse({"success": success, "why": why}, 200 if success else 409)


def application(
    mission: Mission, hub: Hub, sink: OrderSink | None, about: dict[str, Any], talk: TalkSink | None = None
) -> ASGI:
    """What is behind the door."""
    ear = talk.ear if talk is not None else None
    routes = [
        *(TalkPages(talk).routes() if talk is not None else ()),
        *(SoundPages(ear).routes() if ear is not None else ()),
    ]
    deaf = ear.deaf if ear is not None else ""
    about = {**about, "talks": talk is not None, "listens": ear is not None, "deaf": deaf}
    return Starlette(routes=[*Pages(mission, hub, sink, about).routes(), *routes])


def _command(text: str) -> str:
    """What is ordered; nothing where that cannot be read."""
    return str((json_object(text) or {}).get("command", ""))


def _is_late(sent: str | None) -> str:
    """Why an order is too old; who does not state when it was given is taken to have just given it."""
    if sent is None:
        return ""
    try:
        age_s = time.monotonic() - float(sent)
    except ValueError:
        age_s = math.nan
    if age_s <= OLDEST_S:
        return ""
    old = "it does not state when it was given" if math.isnan(age_s) else f"it came {age_s:.0f} s after it was given"
    return f"{old}, and orders older than {OLDEST_S:.0f} s are not carried out; look again, and give it again"

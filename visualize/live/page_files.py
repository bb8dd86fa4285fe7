# SPDX-License-Identifier: Apache-2.0
"""The files of a page that is served: its HTML, all its scripts as one, its style; read once a process."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from visualize.page.html import CHART_SCRIPTS, asset, bundle

__all__ = ("PageFiles",)

ASSETS = Path(__file__).parent / "assets"
SHARED = (*CHART_SCRIPTS, "plan.js", "details.js", "legend.js")
"""Scripts of the review page that every served page has."""


class PageFiles:
    """The routes of a page's files.

    Args:
        html: The file of the page itself.
        scripts: What is behind the scripts shared with the review page.
        styles: What is behind the style shared with it.
        worklet: A script that the browser runs on its thread of sound; empty: none.
    """

    def __init__(self, html: str, scripts: tuple[str, ...], styles: tuple[str, ...], *, worklet: str = "") -> None:
        self._html, self._scripts, self._styles, self._worklet = html, scripts, styles, worklet

    def routes(self) -> list[Route]:
        worklet = [Route(f"/{self._worklet}", self._sound)] if self._worklet else []
        return [
            *worklet,
            Route("/", self._shell),
            Route("/live.js", self._script),
            Route("/live.css", self._style),
            Route("/favicon.ico", self._icon),
        ]

    async def _shell(self, request: Request) -> Response:
        return Response(self._page_bytes, media_type="text/html")

    async def _script(self, request: Request) -> Response:
        return Response(self._script_bytes, media_type="text/javascript")

    async def _sound(self, request: Request) -> Response:
        return Response(asset(self._worklet, ASSETS).encode(), media_type="text/javascript")

    async def _style(self, request: Request) -> Response:
        return Response(self._style_bytes, media_type="text/css")

    async def _icon(self, request: Request) -> Response:
        return Response(status_code=204)

    @cached_property
    def _page_bytes(self) -> bytes:
        return (ASSETS / self._html).read_bytes()

    @cached_property
    def _script_bytes(self) -> bytes:
        return bundle(SHARED, (asset(each, ASSETS) for each in self._scripts)).encode()

    @cached_property
    def _style_bytes(self) -> bytes:
        return "".join((asset("page.css"), *(asset(each, ASSETS) for each in self._styles))).encode()

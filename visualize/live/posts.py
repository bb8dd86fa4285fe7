# SPDX-License-Identifier: Apache-2.0
"""What is posted to a page: its kind, its body within a bound, and the refusal of either."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

__all__ = ("body_within", "kind_of", "refused")


def kind_of(request: Request) -> str:
    """The media type of what is posted, without its parameters; empty where none is stated."""
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


async def body_within(request: Request, most: int) -> bytes | None:
    """The body; None as soon as it is longer than `most` bytes, of which no more is read."""
    found = bytearray()
    async for piece in request.stream():
        found += piece
        if len(found) > most:
            return None
    return bytes(found)


def refused(status: int, why: str) -> Response:
    """The answer to what is not taken."""
    return JSONResponse({"success": False, "why": why}, status)

# SPDX-License-Identifier: Apache-2.0
"""What is posted to a page: its kind, its body within a bound, and the refusal of either."""

from __future__ import annotations

import asyncio
from typing import NamedTuple

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

__all__ = ("LARGEST_ORDER", "PostRefusal", "body_of", "refused")

LARGEST_ORDER = 65_536
"""Bytes of an order."""
COMES_WITHIN_S = 10.0
"""From the head of a request to the end of its body."""


class PostRefusal(NamedTuple):
    """Why a body is not taken."""

    status: int
    why: str


async def body_of(request: Request, most: int, what: str, kind: str = "application/json") -> bytes | PostRefusal:
    """The body; or why it is not taken.

    It is of another kind, is too long, or does not come to its end. What is refused is read to its end too and kept
    nowhere: a connection that is closed while its client sends resets, and the client gets no answer.

    Args:
        request: What is posted.
        most: Bytes that it may have.
        what: What it is, for the refusal: `a message`.
        kind: Its media type.
    """
    is_kind = request.headers.get("content-type", "").partition(";")[0].strip().lower() == kind
    found = bytearray()
    try:
        async with asyncio.timeout(COMES_WITHIN_S):
            async for piece in request.stream():
                if is_kind and len(found) <= most:
                    found += piece
    except TimeoutError:
        return PostRefusal(408, f"{what} comes within {COMES_WITHIN_S:g} s; post it again")
    except ClientDisconnect:
        return PostRefusal(400, f"{what} did not come to its end")  # for the form: its client is gone
    if not is_kind:
        return PostRefusal(415, f"{what} is {kind}")
    if len(found) > most:
        return PostRefusal(413, f"{what} has at most {most} bytes")
    return bytes(found)


def refused(status: int, why: str) -> Response:
    """The answer to what is not taken."""
    return JSONResponse({"success": False, "why": why}, status)

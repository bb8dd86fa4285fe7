# SPDX-License-Identifier: Apache-2.0
"""Whether what a model's package raised comes of a server that is none of its kind: a wrong path, a proxy's page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlsplit

from rai_missions.errors import raised_text
from rai_missions.redaction import cut, first_line

__all__ = ("address_of", "foreign_reply")

CLIENTS = ("root_client", "_client", "client")
"""Where the packages of providers keep what speaks to the server; it knows the URL that a variable gave."""
ADDRESSES = ("base_url", "_base_url", "api_base", "api_url", "endpoint")
"""How the field ends that holds a server's URL."""
UNREADABLE = (AssertionError, AttributeError, LookupError, TypeError, ValueError)
"""What a package raises that reads a page, or JSON of another form, as its own protocol's reply."""
BUSY = frozenset({408, 425, 429})
"""HTTP statuses of a server that is to be asked again, whatever its text is written in."""
LONGEST_URL = 100


def address_of(model: object) -> str:
    """The URL of the server that a chat model asks, without a password; empty where none is known."""
    try:
        return next(_addresses(model), "")
    except Exception:  # noqa: BLE001 - a package's own attributes may raise anything
        return ""


def foreign_reply(error: BaseException, address: str) -> str:
    """Why no reply of a chat model could be read, and what would be right; empty where the error is another one.

    Args:
        error: What the provider's package raised.
        address: The server's URL.
    """
    if not address or not (isinstance(error, UNREADABLE) or _is_page(error)):
        return ""
    return (
        f"'{address}' gave no reply of a chat model; name the URL of its API, which in OpenAI's protocol ends in /v1"
        f" ({first_line(raised_text(error), 80)})"
    )


def _is_page(error: BaseException) -> bool:
    """Whether a refusal is written for a browser, or leads there, and no server of models has written it."""
    response: Any = getattr(error, "response", None)
    status, headers = getattr(response, "status_code", None), getattr(response, "headers", None)
    if not isinstance(status, int) or not isinstance(headers, Mapping) or status >= 500 or status in BUSY:
        return False
    return "json" not in str(headers.get("content-type", ""))


def _addresses(model: object) -> Iterator[str]:
    """The URLs that a model, or what it asks with, has as an attribute."""
    for holder in (model, *(getattr(model, name, None) for name in CLIENTS)):
        for name in (name for name in getattr(holder, "__dict__", {}) if name.endswith(ADDRESSES)):
            url = urlsplit(str(getattr(holder, name)))
            if url.scheme in ("http", "https") and url.hostname:
                plain = url._replace(netloc=url.netloc.rpartition("@")[2], query="", fragment="")
                yield cut(plain.geturl().rstrip("/"), LONGEST_URL)

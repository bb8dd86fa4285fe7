# SPDX-License-Identifier: Apache-2.0
"""Who may come in: asked by the right name, from the page itself, and with the token where there is anything to see.

Rule: what is not known to be ours is refused, and the refusal has the reason. Nothing here trusts an address to be
private. A client's role is that of its token, whatever it sends.
"""

from __future__ import annotations

import hmac
import ipaddress
import json
import socket
import time
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from typing import Any

from rai_missions.event import Role

__all__ = ("ASGI", "ROLE", "Allowance", "Door")

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
ASGI = Callable[[Scope, Receive, Send], Awaitable[None]]

TOKEN_HEADER = b"x-mission-token"
"""A header of our own: a page of another site may not send it, and no browser adds it by itself."""
ROLE = "rai_missions.role"
"""Where the door leaves a client's role in the scope of its request."""
OPEN = frozenset({"/", "/live.js", "/live.css", "/microphone.js", "/favicon.ico"})
"""What any client on this machine may read: the page without anything of the mission."""
MAY_ASK = frozenset({"/talk", "/sound"})
"""Where a viewer may write: a question; what it may order there, its role decides."""
HEADERS: Mapping[bytes, bytes] = {
    b"content-security-policy": b"default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    b"base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    b"require-trusted-types-for 'script'; trusted-types 'none'",
    b"x-frame-options": b"DENY",
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"permissions-policy": b"camera=(), microphone=(self), geolocation=()",
    b"cache-control": b"no-store",
}


class Allowance:
    """A rate limit: so many acts a second, and so many at once.

    Args:
        every_s: An act comes back after so long.
        most: Acts that may be saved up.
    """

    def __init__(self, every_s: float, most: int) -> None:
        self._every_s, self._most = every_s, most
        self._left, self._at = float(most), time.monotonic()

    def take(self, acts: int = 1) -> bool:
        """Whether there were so many left."""
        now = time.monotonic()
        self._left = min(float(self._most), self._left + (now - self._at) / self._every_s)
        self._at = now
        if self._left < acts:
            return False
        self._left -= acts
        return True


class Door:
    """Comes before the application.

    Args:
        inside: The application.
        token: What everybody must show who wants to do anything.
        viewer_token: What suffices to see; empty where the token alone does.
        host: The address that is listened on, as it was given.
        port: The port.
        scheme: `http` or `https`.
    """

    def __init__(self, inside: ASGI, *, token: str, host: str, port: int, scheme: str, viewer_token: str = "") -> None:
        self._inside = inside
        self._roles: Mapping[bytes, Role] = {
            token.encode(): "operator",
            **({viewer_token.encode(): "viewer"} if viewer_token else {}),
        }
        self._port, self._scheme = port, scheme
        self._is_loopback = is_loopback(host)
        own = {socket.gethostname().lower(), socket.getfqdn().lower()}
        self._names = {"localhost"} | (set() if self._is_loopback else {host.lower(), *own})

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = [each for each in message.get("headers", ()) if each[0].lower() not in HEADERS]
                message = {**message, "headers": [*given, *HEADERS.items()]}
            await send(message)

        status, why = self._refuses(scope)
        if why:
            await refuse(sent, status, why)
        else:
            await self._inside(scope, receive, sent)

    def _refuses(self, scope: Scope) -> tuple[int, str]:
        headers: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.lower(), []).append(value)
        hosts = headers.get(b"host", [])
        host = hosts[0].decode("latin-1").lower() if len(hosts) == 1 else ""
        if not self._is_ours(host):
            return 421, f"this page is not called '{host[:100]}'; use the address that the run printed"
        origins = headers.get(b"origin", [])
        if any(origin.decode("latin-1").lower() != f"{self._scheme}://{host}" for origin in origins):
            return 403, "another site may not use this page"
        is_open = scope["method"] in ("GET", "HEAD") and scope["path"] in OPEN
        sites = headers.get(b"sec-fetch-site", [])
        if not is_open and any(site not in (b"same-origin", b"none") for site in sites):
            return 403, "another site may not use this page"
        role = self._role(headers.get(TOKEN_HEADER, []))
        if not is_open and role is None:
            return 401, "the token is missing or wrong; use the address that the run printed"
        is_asking = scope["path"] in MAY_ASK
        if not is_open and role != "operator" and scope["method"] not in ("GET", "HEAD") and not is_asking:
            return 403, "a viewer looks, and orders nothing; the operator's address is another one"
        scope[ROLE] = role
        return 200, ""

    def _role(self, given: list[bytes]) -> Role | None:
        """Whose token it is; each is compared, so that time reveals nothing of them."""
        found = [
            role for token, role in self._roles.items() if len(given) == 1 and hmac.compare_digest(given[0], token)
        ]
        return found[0] if found else None

    def _is_ours(self, host: str) -> bool:
        """No name that someone else's DNS can point here is ours; an address that was typed is."""
        name, port = _split(host)
        if port != (self._port or (443 if self._scheme == "https" else 80)):
            return False
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return name in self._names
        return address.is_loopback or not self._is_loopback


def _split(host: str) -> tuple[str, int]:
    name, mark, port = host.rpartition(":")
    if not mark or name.endswith(":") or (name.startswith("[") and not name.endswith("]")):
        return host.strip("[]"), 0
    return name.strip("[]"), int(port) if port.isascii() and port.isdigit() and len(port) <= 5 else -1


def is_loopback(host: str) -> bool:
    """Whether no one but this machine can reach an address."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


async def refuse(send: Send, status: int, why: str) -> None:
    """State no, and why."""
    body = json.dumps({"success": False, "why": why}).encode()
    kind = (b"content-type", b"application/json")
    length = (b"content-length", str(len(body)).encode())
    await send({"type": "http.response.start", "status": status, "headers": [kind, length]})
    await send({"type": "http.response.body", "body": body})

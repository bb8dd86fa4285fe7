# SPDX-License-Identifier: Apache-2.0
"""The server next to a run: an address of its own, a thread of its own, and an end with the run.

Rule: whatever is wrong with the address is reported before anything moves; what goes wrong later harms no run.
"""

from __future__ import annotations

import asyncio
import errno
import secrets
import socket
import ssl
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from visualize.live.app import OrderSink, application
from visualize.live.auth import ASGI, Door, is_loopback
from visualize.live.feed import Feed
from visualize.live.hub import Hub
from visualize.live.play import PagePlay, play_application
from visualize.live.talk import TalkSink

__all__ = ("LivePage", "PageAddress")

PORT = 8765
STALLED_MS = 10_000
"""A browser that takes nothing for so long is cut off."""


class PageAddress(NamedTuple):
    """Where the page is served."""

    host: str = "127.0.0.1"
    port: int = PORT
    """0 for any that is free."""
    certificate: str | Path = ""
    """PEM file of the TLS certificate; needed anywhere but on loopback."""
    key: str | Path = ""
    """PEM file of its private key."""


class LivePage:
    """Serves a run. Made in two steps, so that the address is known to be free before a run begins.

    Args:
        place: Where.
        tokens: The operator's and the viewers', where a page continues; new ones by default.

    Raises:
        UsageError: Nothing can be served there, or only unprotected.
    """

    def __init__(self, place: PageAddress | None = None, tokens: tuple[str, str] | None = None) -> None:
        self.place = place or PageAddress()
        self.token, self.viewer_token = tokens or (secrets.token_urlsafe(32), secrets.token_urlsafe(32))
        """What a client must show to order anything, and what a viewer must show."""
        self._tls = bool(self.place.certificate or self.place.key)
        _check(self.place)
        self._config_tls = _context(self.place) if self._tls else None
        self._socket = _bound(self.place)
        self.port = int(self._socket.getsockname()[1])
        """The port that is listened on."""
        self._server: Any = None
        self._thread: threading.Thread | None = None
        self._hub: Hub | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def url(self) -> str:
        """The address, with the token behind `#`, where no server and no log sees it."""
        return f"{self.address}#token={self.token}"

    @property
    def viewer_url(self) -> str:
        """The address for those who only look on."""
        return f"{self.address}#token={self.viewer_token}"

    @property
    def address(self) -> str:
        """The address alone."""
        host = self.place.host
        shown = socket.gethostname() if host in ("0.0.0.0", "::") else f"[{host}]" if ":" in host else host
        return f"{self._scheme}://{shown}:{self.port}/"

    @property
    def viewers(self) -> int:
        """How many look on now."""
        return self._hub.viewers if self._hub is not None else 0

    @property
    def operators(self) -> int:
        """How many of them came with the operator's token."""
        return self._hub.operators if self._hub is not None else 0

    @property
    def serves(self) -> bool:
        """Whether the server runs."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def _scheme(self) -> str:
        return "https" if self._tls else "http"

    def start(
        self,
        mission: Mission,
        feed: Feed,
        sink: OrderSink | None = None,
        about: dict[str, Any] | None = None,
        talk: TalkSink | None = None,
        on_viewers: Callable[[], object] = lambda: None,
    ) -> None:
        """Serve a run from now on.

        Args:
            mission: Whose run it is.
            feed: Where its steps come from.
            sink: Who takes orders; None: the page only looks on.
            about: What the page shows of the run: `run`, `journal`, `answers`, `played`.
            talk: Who takes what a person writes to the robot; None: the page shows talk and takes none.
            on_viewers: Called where a viewer has come or gone, on the server's thread; never waits.
        """

        def inside() -> ASGI:
            self._hub = Hub(feed, on_viewers)
            return application(mission, self._hub, sink, about or {}, talk)

        self._begin(inside, viewer_token=self.viewer_token)

    def start_play(self, mission: Mission, play: PagePlay) -> None:
        """Serve a play from now on.

        Args:
            mission: What is played.
            play: The play.
        """
        self._begin(lambda: play_application(mission, play))

    def _begin(self, inside: Callable[[], ASGI], *, viewer_token: str = "") -> None:
        """Serve what is made on the server's loop; without a token of theirs viewers do not come in."""
        ready = threading.Event()
        errors: list[BaseException] = []

        def work() -> None:
            try:
                asyncio.run(self._serve(inside, ready, viewer_token))
            except BaseException as error:  # noqa: BLE001 - reported to the one that starts it, or it ends the page alone
                errors.append(error)
            finally:
                ready.set()

        self._thread = threading.Thread(target=work, name="live page", daemon=True)
        self._thread.start()
        ready.wait()
        if errors:
            self.stop()
            raise UsageError(f"the page cannot be served: {errors[0]}")

    async def _serve(self, inside: Callable[[], ASGI], ready: threading.Event, viewer_token: str) -> None:
        import uvicorn  # an extra, and needed by no one who does not watch

        from visualize.live.timeouts import Impatient, TLSHandshake

        self._loop = asyncio.get_running_loop()
        door = Door(
            inside(),
            token=self.token,
            viewer_token=viewer_token,
            host=self.place.host,
            port=self.port,
            scheme=self._scheme,
        )
        http: Any = Impatient if self._config_tls is None else partial(TLSHandshake, self._config_tls)
        config = uvicorn.Config(
            door,
            http=http,
            ws="none",
            lifespan="off",
            log_config=None,
            log_level="error",
            access_log=False,
            server_header=False,
            limit_concurrency=256,
            timeout_graceful_shutdown=1,
            h11_max_incomplete_event_size=16_384,
        )
        self._server = uvicorn.Server(config)
        self._loop.call_soon(ready.set)
        await self._server.serve(sockets=[self._socket])

    def stop(self, within_s: float = 3.0) -> None:
        """Notify the viewers how it ended, and serve no more."""
        thread, loop, hub = self._thread, self._loop, self._hub
        if thread is not None and thread.is_alive() and loop is not None:

            async def end() -> None:
                if hub is not None:
                    await hub.close()
                    await asyncio.sleep(0.05)
                if self._server is not None:
                    self._server.should_exit = True

            asyncio.run_coroutine_threadsafe(end(), loop)
            thread.join(within_s)
        self._socket.close()


def _check(place: PageAddress) -> None:
    if bool(place.certificate) != bool(place.key):
        raise UsageError("TLS takes both a certificate and its key: --tls-cert FILE --tls-key FILE")
    if not place.certificate and not is_loopback(place.host):
        raise UsageError(
            f"on '{place.host}' others on the network could read the token and stop the robot; give --tls-cert FILE "
            "and --tls-key FILE, or stay on loopback and reach it through a tunnel: ssh -L 8765:127.0.0.1:8765 ROBOT"
        )
    if not 0 <= place.port <= 65_535:
        raise UsageError(f"there is no port {place.port}; give one from 1 to 65535, or 0 for any that is free")


def _context(place: PageAddress) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    for file in (place.certificate, place.key):
        if Path(file).exists() and not Path(file).is_file():  # a pipe would never end
            raise UsageError(f"TLS cannot use {file}: that is no regular file; give PEM files")
    try:
        context.load_cert_chain(place.certificate, place.key)
    except (OSError, ssl.SSLError) as error:
        why = error.strerror or str(error)
        raise UsageError(f"TLS cannot use {place.certificate} and {place.key}: {why}; give PEM files") from None
    return context


def _bound(place: PageAddress) -> socket.socket:
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            place.host.strip("[]"), place.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except OSError as error:
        raise UsageError(f"there is no address '{place.host}' here: {error.strerror or error}") from None
    made = socket.socket(family, kind)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "TCP_USER_TIMEOUT"):  # inherited by every connection: the kernel cuts off who takes nothing
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, STALLED_MS)
        made.bind(address)
        made.listen(64)
    except OSError as error:
        made.close()
        if error.errno == errno.EADDRINUSE:
            raise UsageError(
                f"port {place.port} is in use on {place.host}, perhaps by the page of another run; give another with "
                "--watch PORT (or watch --port PORT), or 0 for any that is free"
            ) from None
        raise UsageError(f"{place.host} port {place.port} cannot be listened on: {error.strerror}") from None
    return made

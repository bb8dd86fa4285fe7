# SPDX-License-Identifier: Apache-2.0
"""The way to a broker, opened again whenever it is lost.

Rule: each connection has a client of its own. What one could not deliver ends with it, so that no request and no
command is carried out long after those who gave it have received that it failed.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError, UsageError, install_command
from rai_missions.redaction import logger

__all__ = ("BrokerLink",)

log = logger(__name__)

PATIENCE_S = 5.0
"""How long a broker may take to let a client in."""
AGAIN_S, LONGEST_S = 0.5, 8.0
"""Seconds between two attempts to reach a broker that is gone: at first, and at most."""
KEEPALIVE_S = 10
"""How often the way is tried where nothing is sent: one that has become silent counts as lost within twice that."""


class BrokerLink:
    """One way to a broker, from `open` to `close`.

    Args:
        host: Where the broker is.
        port: Its port.
        on_open: Called with the client of each new connection.
        on_lost: Called when a connection is lost.
        on_message: Paho's `on_message`.
        on_publish: Paho's `on_publish`.
    """

    def __init__(
        self, host: str, port: int, *, on_open: Callable[[Any], object], on_lost: Callable[[], object],
        on_message: Callable[..., object], on_publish: Callable[..., object],
    ) -> None:  # fmt: skip
        self._host, self._port = host, port
        self._on_open, self._on_lost = on_open, on_lost
        self._on_message, self._on_publish = on_message, on_publish
        self._lock = threading.Lock()
        self._worker = Worker("way to the MQTT broker")
        self._made: Any = None
        self._client: Any = None
        self._is_open = False
        self._again_s = AGAIN_S

    @property
    def is_open(self) -> bool:
        """It was opened and not closed since, whether or not the broker is there at the moment."""
        return self._is_open

    @property
    def client(self) -> Any:
        """The client that is connected; None while the broker is away."""
        return self._client

    def open(self) -> None:
        """Connect.

        Raises:
            UsageError: paho is not installed.
            ConnectorError: No broker answers, or it refuses.
        """
        answers: list[Any] = []
        is_answered = threading.Event()

        def on_answer(code: Any) -> None:
            answers.append(code)
            is_answered.set()

        with self._lock:
            self._is_open = True
        try:
            self._connect(on_answer)
        except OSError as fault:
            self.close()
            raise ConnectorError(f"no MQTT broker answers at {self._host}:{self._port} ({fault}); start one") from fault
        except UsageError:
            self.close()
            raise
        if not is_answered.wait(PATIENCE_S) or answers[0].is_failure:
            why = answers[0] if answers else "it states nothing"
            self.close()
            raise ConnectorError(f"the MQTT broker at {self._host}:{self._port} does not let us in: {why}")

    def close(self) -> None:
        """Disconnect; closed already, nothing happens."""
        with self._lock:
            self._is_open = False
            made, self._made, self._client = self._made, None, None
        self._worker.close(0.0)
        _end(made)

    def _connect(self, on_answer: Callable[[Any], object] = lambda code: None) -> None:
        client = _client()

        def connected(_client: Any, _data: Any, _flags: Any, code: Any, _properties: Any) -> None:
            with self._lock:
                is_ours = self._made is client and not code.is_failure
                self._client = client if is_ours else self._client
            if is_ours:
                self._again_s = AGAIN_S
                self._on_open(client)
            on_answer(code)

        client.on_connect, client.on_message, client.on_publish = connected, self._on_message, self._on_publish
        client.on_disconnect = lambda *_: self._lost(client)
        client.on_socket_open = _hurry
        client.connect(self._host, self._port, keepalive=KEEPALIVE_S)
        with self._lock:
            is_wanted = self._is_open
            self._made = client if is_wanted else None
        if is_wanted:
            client.loop_start()
        else:
            _end(client)

    def _lost(self, client: Any) -> None:
        with self._lock:
            if self._made is not client:
                return
            was, self._client, self._made = self._client, None, None
            is_wanted = self._is_open
        if was is not None:
            log.warning("the MQTT broker at %s:%s is gone", self._host, self._port)
            self._on_lost()
        if is_wanted:
            self._try_later()

    def _try_later(self) -> None:
        seconds, self._again_s = self._again_s, min(2 * self._again_s, LONGEST_S)
        self._worker.after(seconds, self._try)

    def _try(self) -> None:
        try:
            if self._is_open:
                self._connect()
        except OSError:
            self._try_later()


def _client() -> Any:
    try:
        import paho.mqtt.client as mqtt
    except ImportError as fault:
        raise UsageError(f"a connector of kind 'mqtt' needs paho-mqtt ({fault}): {install_command('mqtt')}") from fault
    return mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5, reconnect_on_failure=False)


def _end(client: Any) -> None:
    if client is not None:
        client.disconnect()
        client.loop_stop()


def _hurry(_client: Any, _data: Any, opened: socket.socket) -> None:
    """Without this a message of quality 1 waits some 40 ms for the acknowledgement of the one before."""
    opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

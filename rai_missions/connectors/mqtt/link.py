# SPDX-License-Identifier: Apache-2.0
"""The way to a broker, opened again whenever it is lost.

Rule: each connection has a client of its own. What one could not deliver ends with it, so that no request and no
command is carried out long after those who gave it have received that it failed. What was sent before the end is
acknowledged before the way is closed: a socket that closes with unread words in it drops what it was about to send.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable, Sequence
from typing import Any

from rai_missions.connectors.mqtt.acknowledgements import Acknowledgements
from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError, UsageError, install_command
from rai_missions.redaction import logger

__all__ = ("BrokerLink",)

log = logger(__name__)

PATIENCE_S = 5.0
"""How long a broker may take to let a client in."""
AGAIN_S, LONGEST_S = 0.5, 8.0
"""Seconds between two attempts to reach a broker that is gone: at first, and at most."""
UNANSWERED = "it ends the connection without an answer, as one that wants TLS does"
FAREWELL_S = 1.0
"""How long a broker may take at the end to acknowledge what was sent."""
FRAME = 10
"""Bytes of a message at the most that are no topic, property or content."""
KEEPALIVE_S = 10
"""How often the way is tried where nothing is sent: one that has become silent counts as lost within twice that."""


class BrokerLink:
    """One way to a broker, from `open` to `close`.

    Args:
        host: Where the broker is.
        port: Its port.
        on_open: Called for each new connection.
        on_lost: Called when a connection is lost, with the reason that the broker gave, empty where it gave none.
        on_message: Paho's `on_message`.
    """

    def __init__(
        self,
        host: str,
        port: int,
        *,
        on_open: Callable[[], object],
        on_lost: Callable[[str], object],
        on_message: Callable[..., object],
    ) -> None:
        self._host, self._port = host, port
        self._on_open, self._on_lost = on_open, on_lost
        self._on_message = on_message
        self._lock = threading.Lock()
        self._worker = Worker("way to the MQTT broker")
        self._made: Any = None
        self._client: Any = None
        self._acknowledgements = Acknowledgements()
        self._largest: int | None = None
        self._sent_last: Any = None
        self._reader: int | None = None
        self._is_open = False
        self._again_s = AGAIN_S

    @property
    def is_open(self) -> bool:
        """Whether the link was opened, and not closed since; the broker may be absent at the moment."""
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
        answers: list[str] = []
        is_answered = threading.Event()

        def on_answer(why: str) -> None:
            answers.append(why)
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
        if not is_answered.wait(PATIENCE_S) or answers[0]:
            why = answers[0] if answers else "it gives no reason"
            self.close()
            raise ConnectorError(f"the MQTT broker at {self._host}:{self._port} does not let us in: {why}")

    def subscribe(self, topics: Sequence[str], on_refused: Callable[[str, str], object]) -> None:
        """Receive topics with quality 1; nothing happens while the broker is away.

        Args:
            topics: Their names.
            on_refused: Called on paho's thread with each topic that the broker does not let us receive, and the reason.
        """
        client = self._client
        if client is None:
            return

        def on_codes(codes: Sequence[Any]) -> None:
            for topic, code in zip(topics, codes, strict=False):
                if code.is_failure:
                    on_refused(topic, str(code).lower())

        self._acknowledgements.track(lambda: client.subscribe([(topic, _quality()) for topic in topics]), on_codes)

    def publish(
        self,
        topic: str,
        payload: bytes,
        properties: Any = None,
        *,
        on_code: Callable[[Any], object] = lambda code: None,
    ) -> Any:
        """Send a message with quality 1.

        Args:
            topic: Where to.
            payload: What it is.
            properties: Paho's, of MQTT 5.
            on_code: Called on paho's thread with the reason code of the broker's acknowledgement, unless the connection
                is lost before.

        Returns:
            Paho's word on what becomes of it; None while the broker is away.

        Raises:
            ConnectorError: It is larger than what the broker takes, which would end the way for all others.
        """
        client, largest = self._client, self._largest
        if client is None:
            return None
        size = len(payload) + len(topic.encode()) + (0 if properties is None else len(properties.pack())) + FRAME
        if largest is not None and size > largest:
            raise ConnectorError(f"{topic}: a message of {size} bytes; the MQTT broker takes {largest} at most")
        sent: Any = None

        def send() -> tuple[Any, int]:
            nonlocal sent
            self._sent_last = sent = client.publish(topic, payload, qos=1, properties=properties)
            return sent.rc, sent.mid

        self._acknowledgements.track(send, lambda codes: on_code(codes[0]))
        return sent

    def close(self) -> None:
        """Disconnect, once the broker has what was sent; closed already, nothing happens."""
        self._await_broker()
        with self._lock:
            self._is_open = False
            made, self._made, self._client = self._made, None, None
        self._worker.close(0.0)
        _end(made)

    def _await_broker(self) -> None:
        """Wait until the broker has the message sent last, and so all before it; not on the thread that would read."""
        last, self._sent_last = self._sent_last, None
        if last is not None and self._client is not None and threading.get_ident() != self._reader:
            with contextlib.suppress(RuntimeError, ValueError):  # it never left
                last.wait_for_publish(FAREWELL_S)

    def _connect(self, on_answer: Callable[[str], object] = lambda why: None) -> None:
        client, acknowledgements = _client(), Acknowledgements()

        def connected(_client: Any, _data: Any, _flags: Any, code: Any, properties: Any) -> None:
            with self._lock:
                self._largest = getattr(properties, "MaximumPacketSize", None)
                self._reader = threading.get_ident()
                is_ours = self._made is client and not code.is_failure
                if is_ours:
                    self._client, self._acknowledgements = client, acknowledgements
            if is_ours:
                self._again_s = AGAIN_S
                self._on_open()
            on_answer(str(code) if code.is_failure else "")

        def disconnected(_client: Any, _data: Any, flags: Any, code: Any, _properties: Any) -> None:
            on_answer(UNANSWERED)
            self._lost(client, str(code).lower() if flags.is_disconnect_packet_from_server else "")

        client.on_connect, client.on_disconnect, client.on_message = connected, disconnected, self._on_message
        client.on_publish = lambda _client, _data, mid, code, _properties: acknowledgements.arrived(mid, (code,))
        client.on_subscribe = lambda _client, _data, mid, codes, _properties: acknowledgements.arrived(mid, codes)
        client.on_socket_open = _hurry
        client.connect(self._host, self._port, keepalive=KEEPALIVE_S)
        with self._lock:
            is_wanted = self._is_open
            self._made = client if is_wanted else None
        if is_wanted:
            client.loop_start()
        else:
            _end(client)

    def _lost(self, client: Any, why: str) -> None:
        with self._lock:
            if self._made is not client:
                return
            was, self._client, self._made = self._client, None, None
            is_wanted = self._is_open
        if was is not None:
            log.warning("the MQTT broker at %s:%s is gone%s", self._host, self._port, f": {why}" if why else "")
            self._on_lost(why)
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


def _quality() -> Any:
    from paho.mqtt.subscribeoptions import SubscribeOptions

    return SubscribeOptions(qos=1)

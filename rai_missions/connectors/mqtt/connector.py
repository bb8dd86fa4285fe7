# SPDX-License-Identifier: Apache-2.0
"""The connector to an MQTT 5 broker: messages as JSON, services as a request and its reply; no actions.

Rule: paho is loaded when a connector starts; its own thread runs every callback. It holds locks of its own meanwhile,
so no lock of ours is held while paho is called. What the broker keeps (retained messages) is of the past: it is no
request, and no news to one who has received it.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rai_missions.connectors.answers import ask_for, check_answer
from rai_missions.connectors.connector import (
    ActionServer,
    Answer,
    Close,
    ConnectorMode,
    Data,
    Message,
    OnMessage,
    OnReply,
    OnReport,
    Reply,
    Report,
)
from rai_missions.connectors.mqtt.calls import PendingCalls
from rai_missions.connectors.mqtt.codec import decode, encode
from rai_missions.connectors.mqtt.link import BrokerLink
from rai_missions.connectors.mqtt.names import REQUEST, check_name, why_no_name
from rai_missions.connectors.mqtt.properties import (
    key_of,
    late_s,
    reply_properties,
    reply_topic,
    request_properties,
)
from rai_missions.connectors.stamps import ReadingDate, dated, stamp_of
from rai_missions.errors import ConnectorError, UsageError, raised_text
from rai_missions.redaction import cut, logger, shown

__all__ = ("MqttConnector",)

log = logger(__name__)

OPTIONS = ("host", "port")
NO_SUBSCRIBERS = 0x10
"""MQTT 5, 3.4.2.1: no matching subscribers."""
GONE = "the MQTT broker is gone"


def read_options(given: Mapping[str, Any]) -> tuple[str, int]:
    """A broker's host and port, from a profile's `connector`.

    Raises:
        UsageError: An option is not known, or has a value that it cannot have.
    """
    for word in (each for each in given if each not in OPTIONS):
        raise UsageError(f"connector: no option {shown(word)}; there is: {', '.join(OPTIONS)}")
    host, port = given.get("host", "127.0.0.1"), given.get("port", 1883)
    if not isinstance(host, str) or not _is_host(host):
        raise UsageError(f"connector/host: {shown(host)} is no host; give a name or an address, as '192.168.1.20'")
    if not isinstance(port, int) or isinstance(port, bool) or not 1 <= port <= 65_535:
        raise UsageError(f"connector/port: {shown(port)} is no port; give a whole number from 1 to 65535")
    return host, port


def _is_host(name: str) -> bool:
    try:
        return bool(name.encode("idna")) and "/" not in name
    except UnicodeError:  # a label without letters, as in `robot..local`, or with more than 63
        return False


class MqttConnector:
    """Topics and services over a broker; a `Connector` without actions.

    A topic's name is MQTT's; requests of a service travel on `NAME/request`. Types are not checked: MQTT has none.

    Args:
        options: What a profile's `connector` has besides its `kind`: `host` (127.0.0.1), `port` (1883).
        now: Seconds on the run's clock; stamps what is received. Left out, the time of day.

    Raises:
        UsageError: An option is not known, or has a value that it cannot have.
    """

    modes: frozenset[ConnectorMode] = frozenset({"topics", "services"})
    lists_itself = True

    def __init__(self, options: Mapping[str, Any] | None = None, *, now: Callable[[], float] | None = None) -> None:
        self._host, self._port = read_options(options or {})
        self._now = now or time.time
        self._lock = threading.Lock()
        self._link = BrokerLink(
            self._host, self._port, on_open=self._subscribe_all, on_lost=self._lost, on_message=self._arrived
        )
        self._replies_to = ""
        self._listeners: defaultdict[str, dict[object, _Listener]] = defaultdict(dict)
        self._services: dict[str, tuple[str, Answer]] = {}
        self._calls = PendingCalls()
        self._types: dict[tuple[ConnectorMode, str], str] = {}
        self._unread: set[str] = set()
        self._denied: set[str] = set()
        self._why_unanswered = ""

    @property
    def running(self) -> bool:
        """Whether the connector was started, and not stopped since; the broker may be absent at the moment."""
        return self._link.is_open

    def start(self) -> None:
        """Connect; a connection that is lost later is opened again.

        Raises:
            UsageError: paho is not installed.
            ConnectorError: No broker answers, or it refuses.
        """
        with self._lock:
            if self._link.is_open:
                return
            self._replies_to = f"rai_missions/reply/{uuid.uuid4().hex}"
        self._link.open()

    def stop(self) -> None:
        with self._lock:
            self._listeners.clear()
            self._services.clear()
            self._types.clear()
        if self._link.is_open:
            self._link.close()
            self._calls.give_up("the connector was stopped")

    def listed(self, mode: ConnectorMode) -> Mapping[str, str]:
        """What this connector itself listens to, publishes on and serves: a broker does not report what others do."""
        with self._lock:
            served = {service for service, _ in self._services.values()}
            known = dict(self._types)
            there = {
                "topics": {*self._listeners, *(name for kind, name in known if kind == "topics")},
                "services": served,
            }
            return {name: known.get((mode, name), "") for name in sorted(there.get(mode, ()))} if self.running else {}

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        key = object()
        check_name(topic)
        self._check_open()
        with self._lock:
            self._listeners[topic][key] = _Listener(on_message)
            self._types["topics", topic] = type_name
        self._subscribe(topic)
        return lambda: self._unsubscribe(topic, key)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        """Publish; what cannot be sent now is not sent later.

        Raises:
            ConnectorError: The message is no plain data, larger than the broker takes, or the broker is gone; MQTT does
                not take the name.
        """
        check_name(topic)
        payload = encode(message)
        if not self.running:
            return
        self._types["topics", topic] = type_name
        sent = self._link.publish(topic, payload, on_code=lambda code: self._published(topic, code))
        if sent is None or sent.rc:
            raise ConnectorError(f"nothing can be published on {topic}: {GONE}")

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        try:
            check_name(service)
            payload = encode(request)
        except ConnectorError as fault:
            on_reply(Reply("failed", {}, str(fault)))
            return
        if self._link.client is None:
            why = GONE if self.running else "the connector is not started"
            on_reply(Reply("unavailable", {}, f"no server offers {service}: {why}"))
            return
        if self._why_unanswered:
            on_reply(Reply("unavailable", {}, self._why_unanswered))
            return
        key = uuid.uuid4().bytes
        words = request_properties(key, self._replies_to, timeout_s)
        self._calls.begin(key, service, on_reply, timeout_s)
        sent, end = None, Reply("unavailable", {}, GONE)
        try:
            sent = self._link.publish(
                f"{service}{REQUEST}", payload, words, on_code=lambda code: self._taken(key, service, code)
            )
        except ConnectorError as fault:
            end = Reply("failed", {}, str(fault))
        if sent is None or sent.rc:  # it never left
            self._calls.end(key, end)

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        topic = f"{service}{REQUEST}"
        check_name(service)
        check_answer(answer, service)
        self._check_open()
        with self._lock:
            if topic in self._services:
                raise UsageError(f"{service} is served already; close the first server before another")
            self._services[topic] = (service, answer)
            self._types["services", service] = type_name
        self._subscribe(topic)
        return lambda: self._close_service(topic, answer)

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        """MQTT has no actions: rejected."""
        on_report(Report(goal_id, "rejected", {}, why_no_name(action, "action")))

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        """MQTT has no actions: lost."""
        on_report(Report(goal_id, "lost", {}, why_no_name(action, "action")))

    def cancel_goal(self, goal_id: str) -> None:
        """MQTT has no actions: nothing happens."""

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        """MQTT has no actions; raises `UsageError`."""
        raise UsageError(f"MQTT carries no actions, and so not {action}; serve it as services")

    # -- what comes back -------------------------------------------------------------------------------------------

    def _check_open(self) -> None:
        if not self.running:
            raise UsageError("the MQTT connector is not started: call start() first")

    def _subscribe(self, topic: str) -> None:
        self._link.subscribe((topic,), self._kept_back)  # else with all others, once there is a broker again

    def _subscribe_all(self) -> None:
        with self._lock:
            topics = (self._replies_to, *self._listeners, *self._services)
            self._why_unanswered = ""
        self._link.subscribe(topics, self._kept_back)

    def _arrived(self, _client: Any, _data: Any, message: Any) -> None:
        """Nothing that a message brings ends paho's thread, which would not be replaced."""
        try:
            self._take(message)
        except Exception:
            log.exception("a message on %s was not understood", message.topic)

    def _take(self, message: Any) -> None:
        topic = message.topic
        try:
            data = decode(message.payload)
        except ConnectorError as fault:
            self._misread(message, str(fault))
            return
        self._unread.discard(topic)
        if topic == self._replies_to:
            self._calls.answered(key_of(message), self._reply(data))
        if (served := self._services.get(topic)) is not None:
            self._serve_one(*served, message, data)
        self._deliver(message, data)

    def _misread(self, message: Any, why: str) -> None:
        """Report a message that is no JSON: in the log, once until a good one comes, and to a caller as its answer."""
        if message.topic not in self._unread:
            self._unread.add(message.topic)
            log.warning("%s: %s", message.topic, cut(why, 200))
        if message.topic in self._services and not message.retain:
            self._send(message, {"why": why})
        if message.topic == self._replies_to:
            self._calls.answered(key_of(message), Reply("failed", {}, f"the reply cannot be read: {why}"))

    def _deliver(self, message: Any, data: Data) -> None:
        """Pass a message on; one that the broker keeps, but for those who have received just that."""
        topic, is_kept, content = message.topic, bool(message.retain), hash(message.payload)
        received = Message(topic, data, *self._date(data), is_kept)
        for key in tuple(self._listeners.get(topic, ())):
            listener = self._listeners.get(topic, {}).get(key)
            if listener is None or (is_kept and listener.last == content):
                continue
            listener.last = content
            try:
                listener.on_message(received)
            except Exception:
                log.exception("a subscriber of %s failed", topic)

    def _date(self, data: Data) -> ReadingDate:
        """A stamp is a time of day."""
        return dated(stamp_of(data), now=self._now(), sender_now=time.time())

    def _serve_one(self, service: str, answer: Answer, message: Any, request: Data) -> None:
        if message.retain:
            log.warning("a request to %s that the broker keeps is of the past, and is not served", service)
            return
        if (late := late_s(message)) > 0:
            why = "this program hung, or the clocks of the two machines differ"
            log.warning("a request to %s expired %.1f s ago, and is not served; %s", service, late, why)
            return
        ask_for(answer, request, service, partial(self._send_answer, message, service))

    def _send_answer(self, message: Any, service: str, data: Data, why: str) -> None:
        try:
            answer = {"why": why} if why else {"data": data}
            encode(answer)
        except Exception as fault:
            log.exception("%s failed", service)
            answer = {"why": raised_text(fault)}
        self._send(message, answer)

    def _send(self, request: Any, answer: Data) -> None:
        """Answer a request, where its sender states where, and the way that it came is still there."""
        to = reply_topic(request)
        if to:
            words = reply_properties(request)
            try:
                self._link.publish(to, encode(answer), words)
            except ConnectorError as fault:
                log.warning("%s", fault)
                self._link.publish(to, encode({"why": str(fault)}), words)

    def _reply(self, answer: Data) -> Reply:
        """What a server sent back: `data` where it has done it, `why` where it has not."""
        data = answer.get("data")
        if isinstance(data, Mapping):
            return Reply("succeeded", data, age_s=self._date(data).age_s)
        return Reply("failed", {}, str(answer.get("why", "")))

    def _taken(self, key: bytes, service: str, code: Any) -> None:
        """The broker has a request, or refuses it with a reason; a code of it means that no client listens."""
        if code.is_failure:
            why = f"the MQTT broker takes no request to {service} from us: {str(code).lower()}"
            self._calls.end(key, Reply("unavailable", {}, why))
        elif code.value == NO_SUBSCRIBERS:
            self._calls.end(key, Reply("unavailable", {}, f"no server offers {service}"))

    def _published(self, topic: str, code: Any) -> None:
        if code.is_failure:
            self._deny(f"the MQTT broker takes no message on {topic} from us: {str(code).lower()}")

    def _kept_back(self, topic: str, why: str) -> None:
        """The broker keeps a topic from us; where that is the one of replies, no call is answered."""
        denied = f"the MQTT broker does not let us receive {topic}: {why}"
        self._deny(denied)
        if topic == self._replies_to:
            self._why_unanswered = denied
            self._calls.give_up(denied)

    def _deny(self, sentence: str) -> None:
        """Logged once: each connection asks for it again."""
        if sentence not in self._denied:
            self._denied.add(sentence)
            log.warning("%s", sentence)

    def _lost(self, why: str) -> None:
        self._calls.give_up(f"{GONE}: {why}" if why else GONE)

    def _unsubscribe(self, topic: str, key: object) -> None:
        with self._lock:
            is_last = self._listeners.get(topic, {}).pop(key, None) is not None and not self._listeners[topic]
            if is_last:
                del self._listeners[topic]
        if is_last:
            self._leave(topic)

    def _close_service(self, topic: str, answer: Answer) -> None:
        with self._lock:
            is_ours = self._services.get(topic, (None, None))[1] is answer
            if is_ours:
                del self._services[topic]
        if is_ours:
            self._leave(topic)

    def _leave(self, topic: str) -> None:
        """Receive a topic no more that no one here wants; one who comes meanwhile receives it all the same."""
        client = self._link.client
        if client is None or self._is_wanted(topic):
            return
        client.unsubscribe(topic)
        if self._is_wanted(topic):
            self._subscribe(topic)

    def _is_wanted(self, topic: str) -> bool:
        with self._lock:
            return topic in self._listeners or topic in self._services


class _Listener:
    """Who receives a topic, and what it received last."""

    def __init__(self, on_message: OnMessage) -> None:
        self.on_message = on_message
        self.last: int | None = None

# SPDX-License-Identifier: Apache-2.0
"""Services: calls that end exactly once, whatever becomes of their server, and services that are served.

Rule: no more requests are on their way to one service than its queue holds; the others wait here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.qos import QoSProfile

from rai_missions.connectors.answers import ask
from rai_missions.connectors.connector import Answer, Data, OnReply, Reply
from rai_missions.connectors.ros2.endpoints import Peers, are_gone, servers_of_service, types_of_service, why_unserved
from rai_missions.connectors.ros2.messages import name_of, to_data, to_message
from rai_missions.connectors.ros2.node_thread import Runtime, guarded
from rai_missions.connectors.stamps import ReadingDate
from rai_missions.connectors.worker import Work
from rai_missions.errors import raised_text
from rai_missions.redaction import logger

__all__ = ("MANY", "Client", "InFlightLimit", "Service")

AT_ONCE = 10
"""The default depth of a ROS service's queue."""
Leave = Callable[[], None]


class InFlightLimit:
    """Lets ten in at once; the others wait in order. On the runtime's thread only."""

    def __init__(self) -> None:
        self._inside: set[object] = set()
        self._waiting: deque[Callable[[Leave], None]] = deque()

    def enter(self, work: Callable[[Leave], None]) -> None:
        """Do something as soon as there is room; it is given what makes the room free again, once."""
        self._waiting.append(work)
        self._let_in()

    def _let_in(self) -> None:
        while self._waiting and len(self._inside) < AT_ONCE:
            key = object()
            self._inside.add(key)
            self._waiting.popleft()(partial(self._leave, key))

    def _leave(self, key: object) -> None:
        if key in self._inside:
            self._inside.discard(key)
            self._let_in()


log = logger(__name__)

MANY = QoSProfile(depth=100)
WATCH_S = 0.5
"""How often a server that is awaited is looked after."""
FAILED = "failed: "
"""Begins the `message` of a reply whose `success` is false because the server raised; ROS has no other word for it."""


@dataclass(eq=False)
class _Call:
    request: Any
    answered: OnReply
    peers: Peers = field(default_factory=dict)
    future: Any = None
    is_over: bool = False
    call_off: Work = field(default=lambda: None)


class Client:
    """One service that is called. On the runtime's thread only.

    Args:
        runtime: Where it lives.
        service: Its name.
        cls: The service's class.
        patience_s: How long a server may take to be found, counted from now.
        date: Dates a response that is received now.
    """

    def __init__(
        self, runtime: Runtime, service: str, cls: Any, patience_s: float, date: Callable[[Any], ReadingDate]
    ) -> None:
        self._runtime, self._service, self._type, self._date = runtime, service, name_of(cls), date
        self._client = runtime.node.create_client(cls, service, qos_profile=MANY, callback_group=runtime.group)
        self._peers = servers_of_service(runtime.node, service)
        self._waiting: deque[_Call] = deque()
        self._sent: set[_Call] = set()
        self._is_sought = self._is_watched = False
        self._patience_s = patience_s
        runtime.later(patience_s, self._grow_impatient)

    def call(self, request: Any, on_reply: OnReply, timeout_s: float | None) -> None:
        """Send a request as soon as there is a server and room."""
        call = _Call(request, on_reply)
        if timeout_s is not None:
            late = Reply("timed_out", {}, f"{self._service} has not answered within {timeout_s:g} s")
            call.call_off = self._runtime.later(timeout_s, lambda: self._end(call, self._absent() or late))
        self._waiting.append(call)
        self._send()

    def _grow_impatient(self) -> None:
        self._patience_s = 0.0

    def _absent(self) -> Reply | None:
        if self._client.service_is_ready():
            return None
        return self._no_server()

    def _no_server(self) -> Reply:
        types = types_of_service(self._runtime.node, self._service)
        return Reply("unavailable", {}, why_unserved(self._service, self._type, types))

    def _send(self) -> None:
        if not self._client.service_is_ready():
            self._seek()
            return
        while self._waiting and len(self._sent) < AT_ONCE:
            self._send_one(self._waiting.popleft())
        self._watch()

    def _seek(self) -> None:
        if not self._is_sought and self._waiting:
            self._is_sought = True
            self._runtime.when(
                lambda: not self._waiting or self._client.service_is_ready(), self._patience_s, self._found
            )

    def _found(self, is_there: bool) -> None:
        self._is_sought = False
        if is_there:
            self._send()
        else:
            for call in list(self._waiting):
                self._end(call, self._no_server())

    def _send_one(self, call: _Call) -> None:
        call.future = self._client.call_async(call.request)
        call.peers = self._peers()  # the request is under way meanwhile
        self._sent.add(call)
        call.future.add_done_callback(lambda future: self._answered(call, future))

    def _answered(self, call: _Call, future: Any) -> None:
        if call.is_over or future.cancelled():
            return
        response = future.result()
        data, age_s = to_data(response), self._date(response).age_s
        why = data.get("message", "")
        if data.get("success") is False and isinstance(why, str) and why.startswith(FAILED):
            self._end(call, Reply("failed", data, why.removeprefix(FAILED)))
        else:
            self._end(call, Reply("succeeded", data, age_s=age_s))

    def _end(self, call: _Call, reply: Reply) -> None:
        if call.is_over:
            return
        call.is_over = True
        call.call_off()
        if call in self._sent:
            self._sent.discard(call)
            self._client.remove_pending_request(call.future)  # else an answer that never comes is awaited for ever
        else:
            self._waiting.remove(call)
        guarded(lambda: call.answered(reply))
        if self._waiting:
            self._runtime.post(self._send)

    def _watch(self) -> None:
        if self._sent and not self._is_watched:
            self._is_watched = True
            self._runtime.later(WATCH_S, self._look)

    def _look(self) -> None:
        self._is_watched = False
        now = self._peers()
        for call in list(self._sent):
            if are_gone(call.peers, now) or not (call.peers or self._client.service_is_ready()):
                why = f"the server of {self._service} vanished before it answered"
                self._end(call, Reply("unavailable", {}, why, may_have_arrived=True))
        self._watch()


class Service:
    """One service that is served. Made and destroyed on the runtime's thread; closed from any."""

    def __init__(self, runtime: Runtime, service: str, cls: Any, answer: Answer) -> None:
        self._runtime, self._service, self._class, self._answer = runtime, service, cls, answer
        self._is_open = True
        self._entity: Any = None
        runtime.post(self._open)

    def close(self) -> None:
        self._is_open = False
        self._runtime.post(self._leave)

    def _open(self) -> None:
        if self._is_open:
            self._entity = self._runtime.node.create_service(
                self._class, self._service, self._respond, qos_profile=MANY, callback_group=self._runtime.group
            )

    def _leave(self) -> None:
        if self._entity is not None:
            self._runtime.node.destroy_service(self._entity)
            self._entity = None

    def _respond(self, request: Any, response: Any) -> Any:
        if not self._is_open:
            raise RuntimeError(f"{self._service} is closed; its last request is not answered")
        answered = ask(lambda data: self._answer(to_data(data)), request, self._service)
        if answered.done():
            return self._response(answered, response)
        later: Future[Any] = Future()
        answered.add_done_callback(
            lambda ended: self._runtime.post(lambda: later.set_result(self._response(ended, response)))
        )
        return later

    def _response(self, answered: Future[Data], response: Any) -> Any:
        """The response of an answer that is there; it raises where ROS has no word for its failure."""
        try:
            return to_message(self._class.Response, answered.result(), self._service)
        except Exception as fault:
            known = response.get_fields_and_field_types()
            if known.get("success") != "boolean" or known.get("message") != "string":
                raise  # no word for failure: the client is left to its timeout, and the log reports why
            log.exception("%s has no answer", self._service)
            response.success, response.message = False, f"{FAILED}{raised_text(fault)}"
            return response

# SPDX-License-Identifier: Apache-2.0
"""An executor for one thread that takes what is ready in rounds.

Rule: in each round everybody who has something to be received has one turn, so that no one who is loud silences
another.

rclpy's own executors collect every entity again each time they wait, and wait two or three times for each message: with
hundreds of subscriptions that takes 15 ms. Here the entities are collected when they change.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any

from rclpy.context import Context
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, ExternalShutdownException, ShutdownException
from rclpy.impl.implementation_singleton import rclpy_implementation as rcl
from rclpy.subscription import Subscription
from rclpy.task import Task
from rclpy.waitable import NumberOfEntities, Waitable

__all__ = ("SingleThreadExecutor",)

Work = Callable[[], None]
Turn = Callable[[], None]
LONGEST_S = 1e6
CLOCK = "/clock"
"""Is received last: time shall not continue before what was reported until then is received, however long no one
listened."""
A_TURN = 10
"""How many messages one turn may bring, as many as a queue holds by default."""
EVENTS_S = 0.1
"""How soon someone is notified that a publisher does not fit: each subscription has such an event, and none is
urgent."""


class SingleThreadExecutor(Executor):  # type: ignore[misc]
    """Spins on one thread; entities are made and destroyed on that thread alone.

    Its nodes have subscriptions, clients, services and waitables (which actions are); timers and guard conditions of
    their own are not looked at. Callbacks run to their end; a coroutine that waits is looked after in every round.

    Args:
        context: Of its nodes.
        run: Runs one piece of work, and sees to it that what it raises stops no one else.
    """

    def __init__(self, context: Context, run: Callable[[Work], None]) -> None:
        self._is_stale, self._thread = True, 0
        self._to_do: deque[Work] = deque()
        self._run = run
        super().__init__(context=context)
        self._subscriptions: Mapping[int, Any] = {}
        self._clients: Mapping[int, Any] = {}
        self._services: Mapping[int, Any] = {}
        self._waitables: tuple[Waitable, ...] = ()
        self._events: tuple[Waitable, ...] = ()
        self._are_events_due_at = 0.0
        self._wait_set: Any = None
        self._handles: tuple[tuple[Callable[[Any], object], tuple[Any, ...]], ...] = ()

    def wake(self) -> None:
        """Something was made or destroyed, or ROS shuts down."""
        self._is_stale = True
        super().wake()

    def nudge(self) -> None:
        """End the wait of the thread that spins; from any other."""
        guard = self._guard
        if guard is not None:
            guard.trigger()

    def create_task(self, callback: Any, *args: Any, **kwargs: Any) -> Task:
        """Have a callback or a coroutine run by the thread that spins."""
        task = Task(callback, args, kwargs, executor=self)
        self._to_do.append(lambda: self._resume(task))
        if threading.get_ident() != self._thread:
            self.nudge()
        return task

    def _resume(self, task: Task) -> None:
        task()
        if not (task.done() or task.cancelled()):
            self._to_do.append(lambda: self._resume(task))
        elif task.done() and task.exception() is not None:
            raise task.exception()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """One round: wait until someone is ready, and let everybody who is have one turn.

        Raises:
            ShutdownException: The executor was shut down.
            ExternalShutdownException: ROS was.
        """
        self._thread = threading.get_ident()
        self._work_off()
        for turn in self._wait(0.0 if self._to_do else timeout_sec):
            self._run(turn)
        self._work_off()

    def _work_off(self) -> None:
        for _ in range(len(self._to_do)):
            self._run(self._to_do.popleft())

    # -- waiting ---------------------------------------------------------------------------------------------------

    def _wait(self, timeout_s: float | None) -> list[Turn]:
        try:
            if self._is_stale:
                self._gather()
            waitables, timeout_s = self._due(LONGEST_S if timeout_s is None else timeout_s)
            self._fill(waitables)
        except InvalidHandle:  # destroyed, and no one stated it
            self._is_stale = True
            return []
        with self._context.handle:
            self._wait_set.wait(int(timeout_s * 1e9))
        if self._is_shutdown:
            raise ShutdownException
        if not self._context.ok():
            raise ExternalShutdownException
        return self._ready(waitables)

    def _due(self, timeout_s: float) -> tuple[tuple[Waitable, ...], float]:
        """The waitables of this round, and how long it may wait for the sake of those that are left out."""
        now = time.monotonic()
        if now < self._are_events_due_at:
            return self._waitables, min(timeout_s, EVENTS_S)
        self._are_events_due_at = now + EVENTS_S
        return self._waitables + self._events, timeout_s

    def _gather(self) -> None:
        """Collect whom to wait for."""
        self._is_stale = False
        nodes = self.get_nodes()
        subscriptions = [each for node in nodes for each in node.subscriptions]
        subscriptions.sort(key=lambda each: each.topic_name == CLOCK)
        self._subscriptions = {each.handle.pointer: each for each in subscriptions}
        self._clients = {each.handle.pointer: each for node in nodes for each in node.clients}
        self._services = {each.handle.pointer: each for node in nodes for each in node.services}
        waitables = [each for node in nodes for each in node.waitables]
        self._waitables = tuple(each for each in waitables if not isinstance(each, EventHandler))
        self._events = tuple(each for each in waitables if isinstance(each, EventHandler))
        count = NumberOfEntities(len(self._subscriptions), 2, 0, len(self._clients), len(self._services))
        for waitable in waitables:
            count += waitable.get_num_entities()
        with self._context.handle:
            self._wait_set = rcl.WaitSet(
                count.num_subscriptions, count.num_guard_conditions, count.num_timers, count.num_clients,
                count.num_services, count.num_events, self._context.handle,
            )  # fmt: skip
        self._handles = (
            (self._wait_set.add_subscription, tuple(each.handle for each in self._subscriptions.values())),
            (self._wait_set.add_client, tuple(each.handle for each in self._clients.values())),
            (self._wait_set.add_service, tuple(each.handle for each in self._services.values())),
        )

    def _fill(self, waitables: tuple[Waitable, ...]) -> None:
        """Each wait leaves in the set only those who are ready."""
        wait_set = self._wait_set
        wait_set.clear_entities()
        for add, handles in self._handles:
            deque(map(add, handles), maxlen=0)
        for guard in (self._guard, self._sigint_gc):
            wait_set.add_guard_condition(guard.handle)
        for waitable in waitables:
            waitable.add_to_wait_set(wait_set)

    # -- turns -----------------------------------------------------------------------------------------------------

    def _ready(self, waitables: tuple[Waitable, ...]) -> list[Turn]:
        return [
            *(partial(self._attend, each) for each in waitables if each.is_ready(self._wait_set)),
            *(partial(_take_message, each) for each in self._found("subscription", self._subscriptions)),
            *(partial(_take_answer, each) for each in self._found("client", self._clients)),
            *(partial(_answer, each) for each in self._found("service", self._services)),
        ]

    def _found(self, kind: str, known: Mapping[int, Any]) -> list[Any]:
        """Those who are ready but for what belongs to a waitable."""
        return [known[each] for each in self._wait_set.get_ready_entities(kind) if each in known]

    def _attend(self, waitable: Waitable) -> None:
        with suppress(InvalidHandle):
            work = waitable.execute(waitable.take_data())
            try:
                work.send(None)
            except StopIteration:
                return
            self.create_task(work)


def _take_message(subscription: Any) -> None:
    with suppress(InvalidHandle):  # destroyed by someone whose turn came before, or by its own callback
        for _ in range(A_TURN):
            with subscription.handle:
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
            if taken is None:
                return
            with_info = subscription._callback_type is Subscription.CallbackType.WithMessageInfo  # noqa: SLF001
            subscription.callback(*(taken if with_info else taken[:1]))


def _take_answer(client: Any) -> None:
    with suppress(InvalidHandle):
        with client.handle:
            header, response = client.handle.take_response(client.srv_type.Response)
        if header is not None:
            with suppress(KeyError):  # no one waits for it any more
                client.get_pending_request(header.request_id.sequence_number).set_result(response)


def _answer(service: Any) -> None:
    with suppress(InvalidHandle):
        with service.handle:
            request, header = service.handle.service_take_request(service.srv_type.Request)
        if header is None:
            return
        response = service.callback(request, service.srv_type.Response())
        if isinstance(response, Future):  # it is set on this thread
            response.add_done_callback(lambda later: _send_later(service, later, header))
        else:
            service.send_response(response, header)


def _send_later(service: Any, response: Future[Any], header: Any) -> None:
    with suppress(InvalidHandle):
        if response.exception() is None:
            service.send_response(response.result(), header)

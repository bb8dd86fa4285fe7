# SPDX-License-Identifier: Apache-2.0
"""An executor for one thread that takes what is ready in rounds.

Rule: in each round everybody who has something to be received has one turn, so that no one who is loud silences
another.

rclpy's own executors collect every entity again each time they wait, and wait two or three times for each message: with
hundreds of subscriptions that takes 15 ms. Here the entities are collected when they change, and the middleware
notifies of what arrives. Where it cannot, all entities are waited for in one wait set.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from typing import Any

from rclpy.context import Context
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, ExternalShutdownException, ShutdownException
from rclpy.impl.implementation_singleton import rclpy_implementation as rcl
from rclpy.task import Task
from rclpy.waitable import NumberOfEntities, Waitable

from rai_missions.connectors.ros2.notifications import Notifications, sources_of
from rai_missions.connectors.ros2.turns import answer_request, take_message, take_response
from rai_missions.connectors.worker import Work
from rai_missions.redaction import logger

__all__ = ("SingleThreadExecutor",)

log = logger(__name__)

Take = Callable[[Any], bool]
LONGEST_S = 1e6
CLOCK = "/clock"
"""Is received last: time shall not continue before what was reported until then is received, however long no one
listened."""
A_TURN = 10
"""How many messages one turn may bring, as many as a queue holds by default."""
ALL = 1 << 62
"""The count of someone who is found ready by a look: it is not known how much there is, so all of it is taken."""
EVENTS_S = 0.1
"""How often it is looked whether a publisher does not fit: each subscription has such an event, and none is urgent.
The middleware forgets one of these when it notifies of it, so they are asked. As often it is looked whether ROS was
shut down."""
SWEEP_S = 1.0
"""How often all are looked at in spite of the notifications: for what has only come of age, such as an old result."""


class SingleThreadExecutor(Executor):  # type: ignore[misc]
    """Spins on one thread; entities are made and destroyed on that thread alone.

    Its nodes have subscriptions, clients, services and waitables (which actions are); timers and guard conditions of
    their own are not looked at. Callbacks run to their end; a coroutine that waits is looked after in every round.

    Args:
        context: The context of its nodes.
        run: Runs one piece of work, and sees to it that what it raises stops no one else.
        notifications: Reports who has something to be received; closed at the end. None: all are waited for.
    """

    def __init__(
        self,
        context: Context,
        run: Callable[[Work], None],
        notifications: Notifications | None,
    ) -> None:
        self._is_stale, self._thread = True, 0
        self._to_do: deque[Work] = deque()
        self._run = run
        self._notifications: Notifications | None = None
        super().__init__(context=context)
        self._takes: dict[Any, Take] = {}
        self._ranks: dict[Any, int] = {}
        self._pointers: dict[str, dict[int, Any]] = {}
        self._waitables: tuple[Waitable, ...] = ()
        self._events: tuple[Waitable, ...] = ()
        self._counts: dict[Any, int] = {}
        self._are_events_due_at = self._is_sweep_due_at = 0.0
        self._wait_set: Any = None
        self._handles: tuple[tuple[Callable[[Any], object], tuple[Any, ...]], ...] = ()
        self._notifications = notifications

    def wake(self) -> None:
        """Something was made or destroyed, or ROS shuts down."""
        self._is_stale = True
        super().wake()
        if self._notifications is not None and threading.get_ident() != self._thread:
            self._notifications.ring()

    def nudge(self) -> None:
        """End the wait of the thread that spins; from any other."""
        notifications, guard = self._notifications, self._guard
        if notifications is not None:
            notifications.ring()
        elif guard is not None:
            guard.trigger()

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Take no more; by the thread that spins, before the nodes are destroyed."""
        self._do_without()
        return bool(super().shutdown(timeout_sec))

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
        self._wait(0.0 if self._to_do else LONGEST_S if timeout_sec is None else timeout_sec)
        for party in sorted(self._counts, key=self._ranks.__getitem__):
            self._run(partial(self._attend if isinstance(party, Waitable) else self._let_take, party))
        self._work_off()

    def _work_off(self) -> None:
        for _ in range(len(self._to_do)):
            self._run(self._to_do.popleft())

    def _let_take(self, party: Any) -> None:
        """One turn. What is taken is no longer counted, whatever its callback raises."""
        take = self._takes[party]
        for _ in range(A_TURN):
            left = self._counts.get(party, 0) - 1
            if left > 0:
                self._counts[party] = left
            elif self._counts.pop(party, 0) == 0:
                return
            try:
                is_more = take(party)
            except InvalidHandle:  # destroyed by someone whose turn came before, or by its own callback
                is_more = False
            if not is_more:
                self._counts.pop(party, None)
                return

    def _attend(self, waitable: Waitable) -> None:
        """One turn of a waitable: what was found ready. Whether there is more is found in the next round."""
        self._counts[waitable] = 1
        with suppress(InvalidHandle):
            work = waitable.execute(waitable.take_data())
            try:
                work.send(None)
            except StopIteration:
                return
            self.create_task(work)

    # -- waiting ---------------------------------------------------------------------------------------------------

    def _wait(self, timeout_s: float) -> None:
        """Count what there is to take."""
        try:
            if self._is_stale:
                self._gather()
            if self._notifications is None:
                self._wait_for_all(timeout_s)
            else:
                self._wait_for_notifications(self._notifications, timeout_s)
        except InvalidHandle:  # destroyed, and no one stated it
            self._is_stale = True
            self._counts.clear()
            self._is_sweep_due_at = 0.0
            return
        if self._is_shutdown:
            raise ShutdownException
        if not self._context.ok():
            raise ExternalShutdownException

    def _wait_for_notifications(self, notifications: Notifications, timeout_s: float) -> None:
        counts = self._counts
        for party, count in notifications.wait(0.0 if counts else min(timeout_s, EVENTS_S)).items():
            counts[party] = counts.get(party, 0) + count
        now = time.monotonic()
        events = self._events_due(now)
        if now >= self._is_sweep_due_at:
            self._is_sweep_due_at = now + SWEEP_S
            waitables = self._waitables + events
            ready = self._look(0.0, waitables, self._handles)
        else:
            waitables = tuple(each for each in counts if isinstance(each, Waitable)) + events
            ready = self._look(0.0, waitables) if waitables else []
        for waitable in waitables:
            counts.pop(waitable, None)
        for party in ready:
            counts[party] = ALL

    def _wait_for_all(self, timeout_s: float) -> None:
        waitables = self._waitables + self._events_due(time.monotonic())
        found = self._look(min(timeout_s, EVENTS_S), waitables, self._handles)
        self._counts = dict.fromkeys(found, A_TURN)

    def _events_due(self, now: float) -> tuple[Waitable, ...]:
        """The events, if it is time to look at them."""
        if now < self._are_events_due_at:
            return ()
        self._are_events_due_at = now + EVENTS_S
        return self._events

    def _look(
        self,
        timeout_s: float,
        waitables: Iterable[Waitable],
        handles: Iterable[tuple[Callable[[Any], object], tuple[Any, ...]]] = (),
    ) -> list[Any]:
        """Who has something to be received. A wait leaves only these in the set, so it is filled each time."""
        wait_set = self._wait_set
        wait_set.clear_entities()
        for add, added in handles:
            deque(map(add, added), maxlen=0)
        for guard in (self._guard, self._sigint_gc):
            wait_set.add_guard_condition(guard.handle)
        for waitable in waitables:
            waitable.add_to_wait_set(wait_set)
        with self._context.handle:
            wait_set.wait(int(timeout_s * 1e9))
        found = [each for each in waitables if each.is_ready(wait_set)]
        for kind, known in self._pointers.items() if handles else ():
            found += (known[each] for each in wait_set.get_ready_entities(kind) if each in known)
        return found

    # -- whom to wait for ------------------------------------------------------------------------------------------

    def _gather(self) -> None:
        """Collect whom to wait for."""
        self._is_stale = False
        nodes = self.get_nodes()
        subscriptions = [each for node in nodes for each in node.subscriptions]
        subscriptions.sort(key=lambda each: each.topic_name == CLOCK)
        clients = [each for node in nodes for each in node.clients]
        services = [each for node in nodes for each in node.services]
        waitables = [each for node in nodes for each in node.waitables]
        self._waitables = tuple(each for each in waitables if not isinstance(each, EventHandler))
        self._events = tuple(each for each in waitables if isinstance(each, EventHandler))
        self._takes = {
            **dict.fromkeys(subscriptions, take_message),
            **dict.fromkeys(clients, take_response),
            **dict.fromkeys(services, answer_request),
        }
        self._ranks = {party: rank for rank, party in enumerate((*waitables, *self._takes))}
        self._counts = {party: count for party, count in self._counts.items() if party in self._ranks}
        self._pointers = {
            kind: {each.handle.pointer: each for each in parties}
            for kind, parties in (("subscription", subscriptions), ("client", clients), ("service", services))
        }
        count = NumberOfEntities(len(subscriptions), 2, 0, len(clients), len(services))
        for waitable in waitables:
            count += waitable.get_num_entities()
        with self._context.handle:
            self._wait_set = rcl.WaitSet(
                count.num_subscriptions,
                count.num_guard_conditions,
                count.num_timers,
                count.num_clients,
                count.num_services,
                count.num_events,
                self._context.handle,
            )
        self._handles = (
            (self._wait_set.add_subscription, tuple(each.handle for each in subscriptions)),
            (self._wait_set.add_client, tuple(each.handle for each in clients)),
            (self._wait_set.add_service, tuple(each.handle for each in services)),
        )
        if self._notifications is not None:
            self._keep_notified(self._notifications)

    def _keep_notified(self, notifications: Notifications) -> None:
        """Be notified of those who are there, and of no one else."""
        for party in tuple(notifications):
            if party not in self._ranks:
                self._forget(notifications, party)
        for party in self._ranks:
            if party not in notifications and not isinstance(party, EventHandler):
                self._is_sweep_due_at = 0.0
                if not self._add(notifications, party):
                    log.info("the middleware does not notify of what arrives: all are waited for")
                    self._do_without()
                    return

    def _add(self, notifications: Notifications, party: Any) -> bool:
        if isinstance(party, Waitable):
            self._wait_set.clear_entities()
            party.add_to_wait_set(self._wait_set)
            return notifications.add(party, sources_of(self._wait_set))
        kind = next(kind for kind, known in self._pointers.items() if known.get(party.handle.pointer) is party)
        return notifications.add(party, [(kind, party.handle.pointer)])

    def _forget(self, notifications: Notifications, party: Any) -> None:
        try:
            with party if isinstance(party, Waitable) else party.handle:
                notifications.discard(party, is_alive=True)
        except InvalidHandle:
            notifications.discard(party, is_alive=False)

    def _do_without(self) -> None:
        """Be notified of nothing more."""
        notifications, self._notifications = self._notifications, None
        if notifications is not None:
            for party in tuple(notifications):
                self._forget(notifications, party)
            notifications.close()

# SPDX-License-Identifier: Apache-2.0
"""Everything that a ROS 2 connector has open between its start and its stop.

Rule: what is asked from any thread is registered at once and done on the runtime's thread; whatever breaks in between,
each call is answered once and each goal has an end.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from rai_missions.connectors.connector import (
    ActionServer,
    Answer,
    Close,
    ConnectorMode,
    OnMessage,
    OnReply,
    OnReport,
    RawMessage,
    Reply,
    Report,
)
from rai_missions.connectors.ros2.action_server import ServedAction
from rai_missions.connectors.ros2.config import Options
from rai_missions.connectors.ros2.goal_client import GoalClient
from rai_missions.connectors.ros2.node_thread import Runtime, guarded
from rai_missions.connectors.ros2.publishers import Publication
from rai_missions.connectors.ros2.recovered_goal import RecoveredGoal
from rai_missions.connectors.ros2.remote_goal import End, RemoteGoal
from rai_missions.connectors.ros2.services import Client, Service
from rai_missions.connectors.ros2.subscriptions import Listener, Subscriptions
from rai_missions.connectors.stamps import ReadingDate, dated, stamp_of
from rai_missions.connectors.worker import Work
from rai_missions.errors import UsageError, raised_text
from rai_missions.redaction import logger

__all__ = ("Session",)

Kind = TypeVar("Kind", bound=RemoteGoal)
Made = TypeVar("Made")

log = logger(__name__)

NAMESAKE_S = 1.5
"""After so long anyone who is there is known."""
FAREWELL_S = 3.0
"""How long a stop waits for a server of its goals to acknowledge it, from one answer to the next."""


class Session:
    """One node, and what it does.

    Args:
        options: The profile's.
        now: Seconds on the run's clock; None for ROS time.
    """

    def __init__(self, options: Options, now: Callable[[], float] | None) -> None:
        self._options, self._now = options, now
        self._lock = threading.Lock()
        self._publications: dict[str, Publication] = {}
        self._clients: dict[str, Client] = {}
        self._goal_clients: dict[str, GoalClient] = {}
        self._served: dict[str, Service | ServedAction] = {}
        self._calls: set[_Once] = set()
        self._goals: dict[str, Callable[[str], None]] = {}
        self._sent: dict[str, RemoteGoal] = {}
        self._is_silent = False
        self.runtime = Runtime(options, lambda: self._give_up("ROS was shut down"))
        self._subscriptions = Subscriptions(self.runtime, options.quality, self._date)
        if options.node:
            self.runtime.post(lambda: self.runtime.later(NAMESAKE_S, self._look_for_namesakes))

    def _look_for_namesakes(self) -> None:
        """Two nodes of one name both work, but tools and parameters reach either of them at random."""
        node = self.runtime.node
        name, found = node.get_fully_qualified_name(), node.get_node_names_and_namespaces()
        if [f"{space.rstrip('/')}/{each}" for each, space in found].count(name) > 1:
            log.warning("another node is called %s too: give connector/node another name, or leave it out", name)

    # -- topics ----------------------------------------------------------------------------------------------------

    def subscribe(
        self, topic: str, cls: Any, on_message: OnMessage, on_raw: Callable[[RawMessage], None] | None = None
    ) -> Close:
        return self._subscriptions.join(topic, cls, Listener(on_message, on_raw))

    def publish(self, topic: str, cls: Any, message: Any) -> None:
        self.runtime.post(lambda: self._publication(topic, cls).publish(message))

    def expect(self, mode: ConnectorMode, name: str, cls: Any) -> None:
        """Make what will be used, so that the other side has found it by then."""
        make = {"topics": self._publication, "services": self._client, "actions": self._goal_client}[mode]
        self.runtime.post(lambda: make(name, cls))

    def publish_later(self, topic: str, cls: Any, make: Callable[[], Any]) -> None:
        self.runtime.post(lambda: self._publication(topic, cls).publish_later(make))

    def _publication(self, topic: str, cls: Any) -> Publication:
        if topic not in self._publications:
            quality, patience_s = self._options.quality(topic), self._options.discovery_s
            self._publications[topic] = Publication(self.runtime, topic, cls, quality, patience_s)
        return self._publications[topic]

    def _date(self, message: Any) -> ReadingDate:
        """The date of a message, or of a service's response, that is received now; stamps are of ROS time."""
        ros_now = self.runtime.now()
        now = ros_now if self._now is None else self._now()
        stamp: Any = getattr(getattr(message, "header", message), "stamp", None)
        time = {"sec": stamp.sec, "nanosec": stamp.nanosec} if hasattr(stamp, "sec") else stamp
        is_known = not self._options.sim_time or ros_now > 0  # before the first `/clock` simulated time is none
        return dated(stamp_of({"stamp": time}) if is_known else None, now=now, sender_now=ros_now)

    # -- services --------------------------------------------------------------------------------------------------

    def call(self, service: str, cls: Any, request: Any, on_reply: OnReply, timeout_s: float | None) -> None:
        once = _Once(on_reply, self._calls, self._lock)
        self._use(
            lambda: self._client(service, cls),
            lambda client: client.call(request, once, timeout_s),
            lambda why: once(Reply("failed", {}, why)),
            lambda: once(Reply("unavailable", {}, "ROS was shut down")),
        )

    def _use(
        self,
        make: Callable[[], Made],
        use: Callable[[Made], object],
        refuse: Callable[[str], object],
        on_shutdown: Callable[[], object],
    ) -> None:
        """Have a client made and used on the runtime's thread.

        Args:
            make: Makes it; where ROS raises, such as for a type whose library is not here, `refuse` takes the reason.
            use: Takes it.
            refuse: Called instead of `use`.
            on_shutdown: Called instead of both where ROS was shut down, also while the client is made.
        """

        def work() -> None:
            try:
                made = make()
            except Exception as fault:
                if not self.runtime.is_open:  # in the midst of a shutdown rclpy raises whatever breaks first
                    on_shutdown()
                    return
                log.exception("ROS makes no client")
                refuse(f"ROS makes no client: {raised_text(fault)}")
            else:
                use(made)

        if not self.runtime.post(work):
            on_shutdown()

    def _client(self, service: str, cls: Any) -> Client:
        if service not in self._clients:
            self._clients[service] = Client(self.runtime, service, cls, self._options.discovery_s, self._date)
        return self._clients[service]

    def serve(self, service: str, cls: Any, answer: Answer) -> Close:
        return self._keep(service, lambda: Service(self.runtime, service, cls, answer))

    def _keep(self, name: str, make: Callable[[], Service | ServedAction]) -> Close:
        with self._lock:
            if name in self._served:
                raise UsageError(f"{name} is served already; close the first server before another")
            served = self._served[name] = make()

        def close() -> None:
            with self._lock:
                if self._served.get(name) is served:
                    del self._served[name]
            served.close()

        return close

    # -- actions ---------------------------------------------------------------------------------------------------

    def offer(self, action: str, cls: Any, server: ActionServer) -> Close:
        return self._keep(action, lambda: ServedAction(self.runtime, action, cls, server))

    def _goal_client(self, action: str, cls: Any) -> GoalClient:
        if action not in self._goal_clients:
            self._goal_clients[action] = GoalClient(self.runtime, action, cls, self._options.discovery_s)
        return self._goal_clients[action]

    def survey(self, action: str, cls: Any, within_s: float, on_result: Callable[[str], None]) -> None:
        """State who serves an action next to another; empty where at most one server answers, or ROS was shut down."""
        self._use(
            lambda: self._goal_client(action, cls),
            lambda client: client.survey(on_result, within_s),
            lambda _why: on_result(""),  # its first use reports it
            lambda: on_result(""),
        )

    def send_goal(self, action: str, cls: Any, goal: Any, goal_id: str, on_report: OnReport) -> None:
        make = partial(self._goal, action, cls, goal_id, on_report, RemoteGoal)
        self._pursue(goal_id, on_report, make, lambda sent: sent.send(goal), unmade="rejected")

    def find_goal(self, action: str, cls: Any, goal_id: str, on_report: OnReport) -> None:
        make = partial(self._goal, action, cls, goal_id, on_report, RecoveredGoal)
        self._pursue(goal_id, on_report, make, RecoveredGoal.find, unmade="lost")

    def _pursue(
        self,
        goal_id: str,
        on_report: OnReport,
        make: Callable[[], Made],
        begin: Callable[[Made], object],
        *,
        unmade: End,
    ) -> None:
        def lose(why: str, how: End = "lost") -> None:
            with self._lock:
                is_here = self._goals.pop(goal_id, None) is not None
            if is_here:
                guarded(lambda: on_report(Report(goal_id, how, {}, why)))

        with self._lock:
            if goal_id in self._goals:
                raise UsageError(f"goal {goal_id!r} is still running: every goal needs an id of its own")
            self._goals[goal_id] = lose
        self._use(make, begin, lambda why: lose(why, unmade), lambda: lose("ROS was shut down"))

    def _goal(self, action: str, cls: Any, goal_id: str, on_report: OnReport, kind: type[Kind]) -> Kind:
        sent = kind(self._goal_client(action, cls), goal_id, lambda one: self._report(on_report, one), self._forget)
        self._sent[goal_id] = sent
        return sent

    def _report(self, on_report: OnReport, one: Report) -> None:
        if not self._is_silent:
            on_report(one)

    def _forget(self, goal: RemoteGoal) -> None:
        self._sent.pop(goal.goal_id, None)
        with self._lock:
            self._goals.pop(goal.goal_id, None)

    def cancel_goal(self, goal_id: str) -> None:
        def cancel() -> None:
            if goal_id in self._sent:
                self._sent[goal_id].cancel()

        self.runtime.post(cancel)

    # -- the end ---------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Cancel the goals, notify the clients, then close; from a callback it continues after that has returned."""
        is_here, is_sent = self.runtime.is_here, threading.Event()
        if self.runtime.post(lambda: self._part(self._end if is_here else is_sent.set)) and not is_here:
            is_sent.wait(4 * FAREWELL_S)
        if not is_here:
            self._end()

    def _end(self) -> None:
        self.runtime.close()
        self._give_up("the connector was stopped")

    def _part(self, end: Work) -> None:
        """Cancel every goal; then, or when that has taken too long, abort those that are served; then end."""
        for goal in tuple(self._sent.values()):
            goal.cancel()

        def served_last(is_settled: bool) -> None:
            for goal in tuple(self._sent.values()):
                if not goal.is_settled:
                    goal.cancel_blindly()
            for client in self._goal_clients.values():
                client.hasten()
            self._is_silent = True
            with self._lock:
                served = tuple(each for each in self._served.values() if isinstance(each, ServedAction))
                self._goals.clear()
            for each in served:
                each.close()
            self.runtime.when(lambda: all(each.is_done for each in served), FAREWELL_S / 3, lambda _done: end())

        goals = tuple(self._sent.values())

        def unsettled() -> int:
            return sum(not goal.is_settled for goal in goals)

        def wait(before: int) -> None:
            """As long as answers continue coming there is hope."""
            self.runtime.when(
                lambda: not unsettled(),
                FAREWELL_S,
                lambda is_settled: wait(unsettled()) if 0 < unsettled() < before else served_last(is_settled),
            )

        wait(len(goals))

    def _give_up(self, why: str) -> None:
        """Nothing more will be received: end what has no end yet."""
        with self._lock:
            calls, goals = tuple(self._calls), tuple(self._goals.values())
        for goal in tuple(self._sent.values()):
            goal.abandon()
        for lose in goals:
            lose(why)
        for once in calls:
            guarded(partial(once, Reply("unavailable", {}, why)))


class _Once:
    """A callback of a call that is reported exactly once; it is in `unanswered` until then."""

    def __init__(self, on_reply: OnReply, unanswered: set[_Once], lock: threading.Lock) -> None:
        self._answered, self._unanswered, self._lock = on_reply, unanswered, lock
        with lock:
            unanswered.add(self)

    def __call__(self, reply: Reply) -> None:
        with self._lock:
            if self not in self._unanswered:
                return
            self._unanswered.discard(self)
        self._answered(reply)

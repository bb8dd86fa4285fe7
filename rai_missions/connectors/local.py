# SPDX-License-Identifier: Apache-2.0
"""The in-process connector: robot and mission meet in one object, on the caller's thread.

Rule: no lock is held while someone else's code runs, so a callback may use the connector freely.
"""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rai_missions.connectors.answers import ask_for, check_action_server, check_answer
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
from rai_missions.connectors.local_goals import LocalGoal
from rai_missions.connectors.stamps import ReadingDate, dated, stamp_of
from rai_missions.connectors.worker import SerialQueue
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import logger

__all__ = ("LocalConnector",)

log = logger(__name__)

MOST_ENDED = 1000


class LocalConnector:
    """Topics, services and actions inside one process; a `Connector`.

    Publishing calls the subscribers, in the order in which they subscribed, before it returns; a service answers
    before `call` returns, so its `timeout_s` never runs out. A connector that is stopped receives and reports nothing.
    An empty `type_name` represents whatever type the other side uses.

    Args:
        now: Seconds on the run's clock. Stamps are of that clock, or of the time of day where they are nearer to it.
    """

    modes: frozenset[ConnectorMode] = frozenset({"topics", "services", "actions"})

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._lock = threading.Lock()
        self._running = False
        self._types: dict[tuple[ConnectorMode, str], str] = {}
        """Of what was named since the start; empty while only given without its type."""
        self._subscribers: defaultdict[str, dict[object, OnMessage]] = defaultdict(dict)
        self._services: dict[str, Answer] = {}
        self._servers: dict[str, tuple[ActionServer, SerialQueue]] = {}
        self._goals: dict[str, LocalGoal] = {}
        self._ended: dict[str, LocalGoal] = {}
        """The last goals that have ended, for anyone who asks again."""

    @property
    def running(self) -> bool:
        """Whether the connector was started, and not stopped since."""
        return self._running

    def start(self) -> None:
        with self._lock:
            self._running = True

    def stop(self) -> None:
        for goal_id in tuple(self._goals):
            self.cancel_goal(goal_id)
        with self._lock:
            self._running = False
            goals = tuple(self._goals.values())
            for registry in (self._types, self._subscribers, self._services, self._servers, self._goals, self._ended):
                registry.clear()
        for goal in goals:
            goal.silence()

    def listed(self, mode: ConnectorMode) -> Mapping[str, str]:
        """What is served, and the topics that someone listens to or has spoken on since the start."""
        with self._lock:
            if mode == "topics":
                spoken = [name for kind, name in self._types if kind == "topics"]
                names = {*spoken, *(topic for topic, subscribers in self._subscribers.items() if subscribers)}
            else:
                names = {*(self._services if mode == "services" else self._servers)}
            return {name: self._types.get((mode, name), "") for name in sorted(names)} if self._running else {}

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        key = object()
        with self._lock:
            self._agree("topics", topic, type_name)
            self._subscribers[topic][key] = on_message
        return lambda: self._unsubscribe(topic, key)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        with self._lock:
            if not self._running:
                return
            self._agree("topics", topic, type_name)
            keys = tuple(self._subscribers.get(topic, ()))
        dated = Message(topic, message, *self._date(message))
        for key in keys:
            on_message = self._subscribers.get(topic, {}).get(key)
            if on_message is not None:
                _run(on_message, dated, topic)

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        with self._lock:
            answer = self._services.get(service) if self._running else None
            wrong = self._disagreement("services", service, type_name)
        if answer is None:
            on_reply(Reply("unavailable", {}, f"no server offers {service}"))
        elif wrong:
            on_reply(Reply("failed", {}, wrong))
        else:
            ask_for(answer, request, service, partial(self._reply, on_reply))

    def _reply(self, on_reply: OnReply, data: Data, why: str) -> None:
        if self._running:
            on_reply(Reply("failed" if why else "succeeded", data, why, age_s=self._date(data).age_s))

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        with self._lock:
            if goal_id in self._goals:
                raise UsageError(f"goal {goal_id!r} is still running: every goal needs an id of its own")
            found = self._servers.get(action) if self._running else None
            wrong = self._disagreement("actions", action, type_name)
            if found is not None and not wrong:
                sent = LocalGoal(goal_id, action, found[0], found[1], on_report, ended=self._forget)
                self._goals[goal_id] = sent
        if found is None:
            on_report(Report(goal_id, "rejected", {}, f"no server offers {action}"))
        elif wrong:
            on_report(Report(goal_id, "rejected", {}, wrong))
        else:
            sent.send(goal)

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        with self._lock:
            found = self._goals.get(goal_id) or self._ended.get(goal_id)
            is_served = action in self._servers
        if found is not None:
            found.deliver(on_report)
        else:
            why = f"the server of {action} knows nothing of the goal" if is_served else f"no server offers {action}"
            on_report(Report(goal_id, "lost", {}, why, may_run=not is_served))

    def adopt_goal(self, action: str, goal_id: str) -> OnReport:
        """Take note of a goal that its server, which is offered here, has accepted; `find_goal` finds it.

        Returns:
            What the server reports to from now on.
        """
        with self._lock:
            server, calls = self._servers[action]
            goal = LocalGoal.adopted(goal_id, action, server, calls, ended=self._forget)
            self._goals[goal_id] = goal
        return goal.on_report

    def cancel_goal(self, goal_id: str) -> None:
        goal = self._goals.get(goal_id)
        if goal is not None:
            goal.cancel()

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        check_answer(answer, service)
        with self._lock:
            if service in self._services:
                raise UsageError(f"{service} is served already; close the first server before another")
            self._agree("services", service, type_name)
            self._services[service] = answer
        return lambda: self._close_service(service, answer)

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        check_action_server(server, action)
        with self._lock:
            if action in self._servers:
                raise UsageError(f"{action} is served already; close the first server before another")
            self._agree("actions", action, type_name)
            self._servers[action] = (server, SerialQueue())
        return lambda: self._close_action(action, server)

    def _agree(self, mode: ConnectorMode, name: str, type_name: str) -> None:
        wrong = self._disagreement(mode, name, type_name)
        if wrong:
            raise ConnectorError(wrong)
        self._types[mode, name] = self._types.get((mode, name)) or type_name

    def _disagreement(self, mode: ConnectorMode, name: str, type_name: str) -> str:
        known = self._types.get((mode, name)) or type_name
        return f"{name} is a {known}, not a {type_name}" if type_name and known != type_name else ""

    def _date(self, data: Data) -> ReadingDate:
        """A stamp is of the run's clock, or of the time of day where it is nearer to that."""
        stamp, now, today = stamp_of(data), self._now(), time.time()
        is_of_day = stamp is not None and abs(stamp - today) < abs(stamp - now)
        return dated(stamp, now=now, sender_now=today if is_of_day else now)

    def _unsubscribe(self, topic: str, key: object) -> None:
        with self._lock:
            self._subscribers.get(topic, {}).pop(key, None)

    def _close_service(self, service: str, answer: Answer) -> None:
        with self._lock:
            if self._services.get(service) is answer:
                del self._services[service]

    def _close_action(self, action: str, server: ActionServer) -> None:
        with self._lock:
            if self._servers.get(action, (None,))[0] is not server:
                return
            del self._servers[action]
            left = tuple(goal for goal in self._goals.values() if goal.action == action)
        for goal in left:
            goal.on_report(Report(goal.goal_id, "lost", {}, f"{action} is no longer served"))

    def _forget(self, goal: LocalGoal) -> None:
        with self._lock:
            if self._goals.get(goal.goal_id) is not goal:
                return
            del self._goals[goal.goal_id]
            if goal.end is not None and goal.end.status != "rejected":  # of one that it did not take, a server forgets
                self._ended[goal.goal_id] = goal
                if len(self._ended) > MOST_ENDED:
                    del self._ended[next(iter(self._ended))]


def _run(on_message: OnMessage, message: Any, topic: str) -> None:
    """One subscriber's fault must not keep the message from the others."""
    try:
        on_message(message)
    except (Exception, SystemExit):
        log.exception("a subscriber of %s failed", topic)

# SPDX-License-Identifier: Apache-2.0
"""The connector to a robot in Python: facts and events as topics, its functions as services and actions.

Rule: no function of the robot runs on a thread of the mission's; one that hangs holds up itself alone.
"""

from __future__ import annotations

import copy
import inspect
import threading
import time
from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from rai_missions.connectors.connector import Close, Data, Message, OnMessage, OnReply, Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.python_robot.action import GoalRun, fault_of, response_of
from rai_missions.connectors.python_robot.fact_poll import FactPoll, refresh
from rai_missions.connectors.python_robot.function_server import FunctionServer
from rai_missions.connectors.python_robot.robot import (
    EVENTS,
    FACTS,
    MESSAGES,
    PythonRobot,
    ServiceFunction,
)
from rai_missions.connectors.python_robot.robot_time import PATIENCE_S, Execution, RobotTime
from rai_missions.connectors.worker import Worker
from rai_missions.connectors.wrapper import ConnectorWrapper
from rai_missions.errors import suggestion
from rai_missions.redaction import logger

if TYPE_CHECKING:
    from rai_missions.connectors.python_robot.tasks import EventLoop

__all__ = ("PythonRobotConnector",)

log = logger(__name__)

EXIT_S = 2.0
"""So long on the wall the end of a run waits for actions that were canceled."""


class PythonRobotConnector(ConnectorWrapper):
    """A robot's functions behind the three modes; a `Connector`.

    Args:
        robot: Whose functions.
        now: Seconds on the run's clock.
        robot_time: By which functions wait; as on the wall if left out.
        events: Those that the mission declares, if they are known.
        keys: Those whose source is the robot, if they are known.
    """

    def __init__(
        self,
        robot: PythonRobot,
        *,
        now: Callable[[], float] = time.monotonic,
        robot_time: RobotTime | None = None,
        events: Collection[str] | None = None,
        keys: Collection[str] | None = None,
    ) -> None:
        self._robot, self._now, self.time = robot, now, robot_time or RobotTime()
        self._events, self._keys = events, keys
        self._loop: EventLoop | None = None
        self._workers: dict[str, Worker] = {}
        self._changed = threading.Condition()
        self._goals: dict[str, GoalRun[Any]] = {}
        """The goals whose function has not returned."""
        self._polls: dict[str, FactPoll] = {}
        """The facts that are read, by their names."""
        self._listened: set[str] = set()
        """The events that the mission listens to by now."""
        self._puzzled: set[str] = set()
        self._on_end: Callable[[], None] | None = None
        """Called once no goal is executed any more; None until the run is over."""
        super().__init__(LocalConnector(now=now))

    # -- its life -----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        if self.inner.running:
            return
        self._robot.attach(self)
        self.time.open()
        self._on_end = None
        self.inner.start()
        for name in self._robot.written:
            self._look_for_key(name)
        for name, service in self._robot.service_functions.items():
            self.inner.serve(name, "", partial(self._response, name, service))
        for name, topic in self._robot.topic_functions.items():
            self.inner.subscribe(MESSAGES + name, "", partial(self._take_message, name, topic))
        for name, action in self._robot.action_functions.items():
            self.inner.offer(name, "", FunctionServer(self, name, action))

    def stop(self) -> None:
        must_wait = self.inner.running and self._on_end is None
        self._stop_polls()
        self.inner.stop()
        self._robot.detach(self)
        with self._changed:
            if must_wait:
                self._changed.wait_for(lambda: not self._goals, EXIT_S)
            workers, self._workers = list(self._workers.values()), {}
            self._listened.clear()
            loop, self._loop = self._loop, None
        self.time.close()
        if loop is not None:
            loop.close()
        for worker in workers:
            worker.close(within_s=0.0)

    def conclude(self, on_end: Callable[[], None]) -> None:
        """As `HostsActions` has it."""
        self._stop_polls()
        self._on_end = on_end
        self._worker("end").after(EXIT_S, lambda: self._give_up(on_end))
        self._look_for_end()

    def _give_up(self, on_end: Callable[[], None]) -> None:
        """Wait no longer for the goals of a run; once it has ended, those that execute are of one that follows it."""
        if self._on_end is not on_end:
            return
        for run in list(self._goals.values()):
            run.report("overdue", f"it has not ended {EXIT_S:g} s after the end of the run")
        self._look_for_end(anyway=True)

    def _look_for_end(self, *, anyway: bool = False) -> None:
        with self._changed:
            self._changed.notify_all()
            on_end = self._on_end
            if on_end is None or (self._goals and not anyway):
                return
            self._on_end = _nothing
        on_end()

    def _worker(self, name: str) -> Worker:
        with self._changed:
            if name not in self._workers:
                self._workers[name] = Worker(f"{self._robot.name}/{name}")
            return self._workers[name]

    # -- facts, events and messages -----------------------------------------------------------------------------------

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        close = self.inner.subscribe(topic, type_name, on_message)
        name = topic.removeprefix(FACTS)
        if topic.startswith(FACTS):
            if (written := self._robot.written.get(name)) is not None:
                age_s = time.monotonic() - written.written
                on_message(Message(topic, {"value": written.value}, self._now() - age_s, age_s, kept=True))
            if (fact := self._robot.fact_functions.get(name)) is not None and fact.read is not None:
                self._begin_poll(name, fact.read, fact.every_s)
        elif topic.startswith(EVENTS):
            self._listened.add(topic.removeprefix(EVENTS))
        return close

    def take_fact(self, name: str, value: Any) -> None:
        """A value was written; from any thread."""
        self._look_for_key(name)
        self.inner.publish(FACTS + name, "", {"value": value})

    def _look_for_key(self, name: str) -> None:
        """Report once what is written and means nothing to this mission; a fact that is declared may be of another."""
        keys, declared = self._keys, self._robot.fact_functions
        if keys is not None and not (name in keys or name in declared or FACTS + name in self._puzzled):
            self._puzzled.add(FACTS + name)
            why = f"the mission has no such key of the robot's{suggestion(name, keys)}"
            log.warning("the value of '%s' is dropped: %s", name, why)

    def take_event(self, name: str, data: Mapping[str, Any]) -> None:
        """Something has happened; from any thread."""
        if name in self._listened:
            self.inner.publish(EVENTS + name, "", data)
        elif name not in self._puzzled:
            self._puzzled.add(name)
            is_early = self._events is None or name in self._events
            why = (
                "came before the start" if is_early else f"is none of the mission{suggestion(name, self._events or ())}"
            )
            log.warning("the event '%s' is dropped: it %s", name, why)

    def refresh(self) -> None:
        """As `GoalHost` has it."""
        refresh(list(self._polls.values()))

    def _begin_poll(self, name: str, read: Callable[[], Any], every_s: float) -> None:
        if name not in self._polls:
            self._polls[name] = FactPoll(
                name,
                partial(self._called, read),
                every_s,
                robot_time=self.time,
                on_value=lambda value: self.take_fact(name, value),
            )
            if not self.time.is_steered:  # else the clock reports it
                self._worker("facts").after(PATIENCE_S, self._polls[name].report_first)

    def _stop_polls(self) -> None:
        polls, self._polls = self._polls, {}
        for poll in polls.values():
            poll.stop()

    def _take_message(self, name: str, topic: ServiceFunction, message: Message) -> None:
        def take() -> None:
            try:
                self._called(topic.answer, copy.copy(message.data))
            except BaseException as error:  # noqa: BLE001 - whatever a function raises, the next message comes
                log.warning("topic '%s' failed: %s", name, fault_of(error))

        self._later(f"topic '{name}'", take)

    def _later(self, name: str, work: Callable[[], None]) -> None:
        """Have something done on the thread of a name, one piece after the other."""
        execution = Execution(name, self.time)
        self.time.add(execution)

        def do() -> None:
            try:
                work()
            finally:
                self.time.remove(execution)

        self._worker(name).post(do)

    def _called(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """What a function returns, an `async def` too; on the thread that calls."""
        returned = function(*arguments)
        if inspect.iscoroutine(returned):
            return self.loop.result(returned)
        return returned

    @property
    def loop(self) -> EventLoop:
        """Where its `async def` functions execute."""
        from rai_missions.connectors.python_robot.tasks import EventLoop  # loads asyncio, for those who need it

        with self._changed:
            if self._loop is None:
                self._loop = EventLoop(self._robot.name)
            return self._loop

    # -- services -----------------------------------------------------------------------------------------------------

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        once = OneReply(on_reply, lambda: self.inner.running)
        own = self._robot.service_functions.get(service) if self.inner.running else None

        def work() -> None:
            if once.is_given:  # it has timed out while another call was answered
                return
            if own is None:
                self.inner.call(service, type_name, request, on_reply=once)
                return
            try:
                response = self._response(service, own, request)
                self.refresh()
                once(Reply("succeeded", response))
            except BaseException as error:  # noqa: BLE001 - whatever a function raises is the service's failure
                why = fault_of(error)
                log.warning("service '%s' failed: %s", service, why)
                once(Reply("failed", {}, why))

        if not self.inner.running:
            on_reply(Reply("unavailable", {}, f"no server offers {service}"))
            return
        if timeout_s is not None:
            late = Reply("timed_out", {}, f"{service} has not answered within {timeout_s:g} s")
            self._worker("timeouts").after(timeout_s, lambda: once(late))
        self._later(f"service '{service}'", work)

    def _response(self, name: str, service: ServiceFunction, request: Data) -> Data:
        return response_of(f"service '{name}'", "response", self._called(service.answer, dict(request)))

    # -- actions ------------------------------------------------------------------------------------------------------

    def begin(self, goal_id: str, run: GoalRun[Any]) -> None:
        """As `GoalHost` has it."""
        self._goals[goal_id] = run

    def end(self, goal_id: str) -> None:
        """As `GoalHost` has it."""
        with self._changed:
            self._goals.pop(goal_id, None)
        self._look_for_end()

    def find(self, goal_id: str) -> GoalRun[Any] | None:
        """As `GoalHost` has it."""
        return self._goals.get(goal_id)


class OneReply:
    """Passes the first reply on, and no other."""

    def __init__(self, on_reply: OnReply, is_wanted: Callable[[], bool]) -> None:
        self._on_reply, self._is_wanted = on_reply, is_wanted
        self._lock = threading.Lock()
        self.is_given = False

    def __call__(self, reply: Reply) -> None:
        with self._lock:
            if self.is_given:
                return
            self.is_given = True
        if self._is_wanted():
            self._on_reply(reply)


def _nothing() -> None:
    """The end was reported already."""

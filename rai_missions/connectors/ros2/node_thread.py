# SPDX-License-Identifier: Apache-2.0
"""One node in a context of its own, and the one thread that does everything with it.

Rule: entities are made, used and destroyed on this thread alone. rclpy breaks in many ways where they are not.
"""

from __future__ import annotations

import heapq
import itertools
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import ExternalShutdownException, ShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter

from rai_missions.connectors.ros2.config import Options
from rai_missions.connectors.ros2.executor import SingleThreadExecutor
from rai_missions.connectors.ros2.fastdds import carried
from rai_missions.connectors.ros2.notifications import open_notifications
from rai_missions.connectors.worker import Work
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import logger, shown

__all__ = ("Runtime", "guarded")

log = logger(__name__)

T = TypeVar("T")
LOOK_S = 0.02
"""How often someone who is awaited is looked for."""
IDLE_S = 1.0
USE_SIM_TIME = "use_sim_time"
ANSWER_S = 5.0
"""How long someone on another thread waits for what only this thread can state."""


class Runtime:
    """A node that spins on its own thread, whatever else the process does with rclpy.

    The context is its own: no signal handler is installed, and the user's own `rclpy.init` and executor are untouched.

    Args:
        options: Names, domain, arguments and parameters of the node.
        fell: Called on this thread if ROS was shut down from outside (such as by the user's Ctrl-C).

    Raises:
        UsageError: A name or an argument that ROS does not take.
    """

    def __init__(self, options: Options, fell: Work) -> None:
        self._fell = fell
        self._lock = threading.Lock()
        self._waiting: deque[Work] = deque()
        self._is_closing = False
        self._deadlines: list[tuple[float, int, list[Work]]] = []
        self._numbers = itertools.count()
        self._disposals: dict[object, Work] = {}
        self.group = ReentrantCallbackGroup()
        self.opened_at = time.monotonic()
        self._context = Context()
        with carried(pictures=options.pictures):
            self.node = _open_node(self._context, options)
        self._executor = SingleThreadExecutor(self._context, self._run, open_notifications())
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._work, name=f"ros2 {self.node.get_name()}", daemon=True)
        self._thread.start()

    @property
    def is_here(self) -> bool:
        """The caller is this runtime's own thread."""
        return threading.current_thread() is self._thread

    @property
    def is_open(self) -> bool:
        """Neither closed nor shut down from outside."""
        return not self._is_closing and bool(self._context.ok())

    def now(self) -> float:
        """ROS time in seconds; simulated where `/clock` rules."""
        return float(self.node.get_clock().now().nanoseconds / 1e9)

    def post(self, work: Work) -> bool:
        """Have something done on this thread, in the order posted; from any thread. False once it is closed."""
        with self._lock:
            if self._is_closing:
                return False
            self._waiting.append(work)
            if not self.is_here:
                self._nudge()
            return True

    def ask(self, question: Callable[[], T], if_closed: T) -> T:
        """Have something found out on this thread, and wait for it; from any thread.

        Args:
            question: What to find out.
            if_closed: The answer of a runtime that is closed, or closes meanwhile.

        Raises:
            ConnectorError: A callback does not return, and so there is no answer.
        """
        if self.is_here:
            return question()
        answer: Future[T] = Future()

        def find_out() -> None:
            try:
                answer.set_result(question())
            except Exception as fault:  # noqa: BLE001 - anyone who asks is reported
                answer.set_exception(fault)

        if not self.post(find_out):
            return if_closed
        until = time.monotonic() + ANSWER_S
        while self.is_open:
            try:
                return answer.result(LOOK_S)
            except TimeoutError:
                if time.monotonic() > until:
                    raise ConnectorError(f"{self._thread.name} gives no answer: a callback does not return") from None
        return if_closed

    def _nudge(self) -> None:
        """Have the thread look at what is waiting."""
        try:
            self._executor.nudge()
        except Exception:
            if self._context.ok():
                raise
            log.debug("ROS was shut down from outside", exc_info=True)

    def later(self, delay_s: float, work: Work) -> Work:
        """Have something done after a while; only on this thread.

        Returns:
            What calls it off.
        """
        entry = [work]
        heapq.heappush(self._deadlines, (time.monotonic() + delay_s, next(self._numbers), entry))
        return entry.clear

    def when(self, is_so: Callable[[], bool], within_s: float, then: Callable[[bool], object]) -> None:
        """Wait until something is so, and state whether it came; only on this thread."""
        until = time.monotonic() + within_s

        def look() -> None:
            so = is_so()
            if so or time.monotonic() >= until:
                then(so)
            else:
                self.later(LOOK_S, look)

        look()

    def keep(self, entity: object, dispose: Work) -> None:
        """Remember how an entity is destroyed, in case `close` comes first; only on this thread."""
        self._disposals[entity] = dispose

    def dispose(self, entity: object) -> None:
        """Destroy an entity that is kept; only on this thread."""
        dispose = self._disposals.pop(entity, None)
        if dispose is not None:
            dispose()

    def close(self, within_s: float = 5.0) -> None:
        """Destroy everything and end the thread; from its own callbacks it ends as soon as they have returned."""
        with self._lock:
            if not self._is_closing:
                self._is_closing = True
                self._nudge()
        if not self.is_here:
            self._thread.join(within_s)
            if self._thread.is_alive():
                log.error("%s does not end: one of its callbacks does not return", self._thread.name)

    # -- on the thread ---------------------------------------------------------------------------------------------

    def _work(self) -> None:
        while not self._is_closing:
            try:
                self._executor.spin_once(timeout_sec=self._patience())
            except (ShutdownException, ExternalShutdownException):
                break
            except Exception:
                if not self._context.ok():  # in the midst of a shutdown rclpy raises whatever breaks first
                    break
                log.exception("a callback failed")
            self._drain()
            self._run_due()
        with self._lock:
            has_fallen, self._is_closing = not self._is_closing, True
        if has_fallen:
            guarded(self._fell)
        self._destroy()

    def _patience(self) -> float:
        while self._deadlines and not self._deadlines[0][2]:  # called off: no reason to wake
            heapq.heappop(self._deadlines)
        if self._waiting:
            return 0.0
        return max(0.0, min(IDLE_S, self._deadlines[0][0] - time.monotonic())) if self._deadlines else IDLE_S

    def _run_due(self) -> None:
        now = time.monotonic()
        while self._deadlines and self._deadlines[0][0] <= now and not self._is_closing:
            for work in heapq.heappop(self._deadlines)[2]:
                self._run(work)

    def _drain(self) -> None:
        """Do what was posted until now: what that posts in turn waits until others were received."""
        for _ in range(len(self._waiting)):
            if self._is_closing or not self._context.ok():
                return
            self._run(self._waiting.popleft())

    def _run(self, work: Work) -> None:
        try:
            work()
        except Exception:
            if self._context.ok():
                log.exception("a callback failed")

    def _destroy(self) -> None:
        self._waiting.clear()
        self._deadlines.clear()
        # `destroy_node` forgets action clients: the participant would live on until a garbage collection.
        for entity in list(self._disposals):
            guarded(partial(self.dispose, entity))
        for work in (
            lambda: self._executor.remove_node(self.node),
            self._executor.shutdown,
            self.node.destroy_node,
            self._context.try_shutdown,
            self._context.destroy,
        ):
            guarded(work)


def guarded(work: Callable[[], Any]) -> None:
    """Run someone's code; what it raises is logged and stops no one else."""
    try:
        work()
    except Exception:
        log.exception("a callback failed")


def _open_node(context: Context, options: Options) -> Node:
    parameters = [Parameter(name, value=value) for name, value in options.parameters.items()]
    if options.sim_time:
        parameters.append(Parameter(USE_SIM_TIME, value=True))
    name = options.node or f"rai_missions_{uuid.uuid4().hex[:8]}"
    arguments = ["--ros-args", *options.arguments] if options.arguments else []
    try:
        rclpy.init(args=arguments, context=context, domain_id=options.domain_id)
        node = Node(
            name,
            context=context,
            namespace=options.namespace or None,
            parameter_overrides=parameters,
            automatically_declare_parameters_from_overrides=True,
        )
    except (InvalidNodeNameException, InvalidNamespaceException) as fault:
        context.try_shutdown()
        raise UsageError(f"connector: ROS takes no node {name!r} in {options.namespace or '/'!r}: {fault}") from fault
    except RuntimeError as fault:
        context.try_shutdown()
        raise UsageError(f"connector: ROS does not start with {list(options.arguments)!r}: {fault}") from fault
    given = node.get_parameter(USE_SIM_TIME).value
    if given is not options.sim_time:  # only --ros-args give another: the profile's were checked as they were read
        node.destroy_node()
        context.try_shutdown()
        remedy = 'add "sim_time": true to its connector for the time of /clock, or omit the parameter'
        raise UsageError(
            f"parameter '{USE_SIM_TIME}': {shown(given)} is given, and the run's timers follow the profile; {remedy}"
        )
    return node

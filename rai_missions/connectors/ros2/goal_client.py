# SPDX-License-Identifier: Apache-2.0
"""One action whose servers are asked: what of its goals is under way, lost, or executing at a server that no one meant.

Rule: where a second server may be on the name, what is executing is read from every server's status messages.
"""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, QoSProfile

from rai_missions.connectors.ros2.endpoints import NO_PEERS, are_gone, servers_of_action, types_of_action, why_unserved
from rai_missions.connectors.ros2.messages import name_of
from rai_missions.connectors.ros2.node_thread import Runtime
from rai_missions.connectors.ros2.rivals import ObservedClient
from rai_missions.connectors.ros2.services import MANY, WATCH_S, InFlightLimit
from rai_missions.connectors.worker import Work

if TYPE_CHECKING:
    from rai_missions.connectors.ros2.remote_goal import RemoteGoal

__all__ = ("PRESS_S", "QUIET_S", "STEP_S", "GoalClient")

STATUS = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""One server's status message must not push out another's: ROS's own reader keeps one for all of them."""
CHASE_S = 60.0
"""How long a lost goal is chased, counted while a server is there."""
PRESS_S = 2.0
"""How long an answer is awaited before a goal's end is asked for once more."""
SETTLE_S = 1.0
"""How long after the node's start the servers on its graph are known."""
PROBE_S = 1.0
"""How long servers may take to answer a probe."""
QUIET_S = 1.0
"""Where a second server was seen, a goal has ended once no server has been executing it for so long."""
STEP_S = 0.1
"""How often what is awaited of several servers is looked at."""
REMEMBERED = 1000
"""Goals of which a late status is understood."""


class GoalClient:
    """One action whose server is asked. On the runtime's thread only.

    Args:
        runtime: Where it lives.
        action: Its name.
        cls: The action's class.
        patience_s: How long a server may take to be found, counted from now.
    """

    def __init__(self, runtime: Runtime, action: str, cls: Any, patience_s: float) -> None:
        self.runtime, self.action, self.cls = runtime, action, cls
        self.peers = servers_of_action(runtime.node, action)
        self.client = ObservedClient(
            runtime.node,
            cls,
            action,
            on_status=self._sighted,
            on_second=self._answered_twice,
            servers=lambda: len(self.peers()),
            callback_group=runtime.group,
            goal_service_qos_profile=MANY,
            result_service_qos_profile=MANY,
            cancel_service_qos_profile=MANY,
            feedback_sub_qos_profile=MANY,
            status_sub_qos_profile=STATUS,
        )
        runtime.keep(self, self.client.destroy)
        self.patience_s = patience_s
        self.starts, self.cancels = InFlightLimit(), InFlightLimit()
        self._running: set[RemoteGoal] = set()
        self._lost: dict[RemoteGoal, float] = {}
        self._pressed: dict[RemoteGoal, float] = {}
        self._ours: OrderedDict[bytes, RemoteGoal] = OrderedDict()
        self._is_watched = self._is_probing = False
        runtime.later(patience_s, self._grow_impatient)

    def why_absent(self) -> str:
        """Why no server takes its goals."""
        types = types_of_action(self.runtime.node, self.action)
        return why_unserved(self.action, name_of(self.cls), types)

    def _grow_impatient(self) -> None:
        self.patience_s = 0.0

    def observe(self, topic: str, cls: Any, quality: Any, on_message: Callable[[Any], None]) -> Work:
        """Listen to what the server publishes: its `status` or `feedback`; returns what ends it."""
        node, name = self.runtime.node, f"{self.action}/_action/{topic}"
        ear = node.create_subscription(cls, name, on_message, quality, callback_group=self.runtime.group)
        self.runtime.keep(ear, lambda: node.destroy_subscription(ear))
        return lambda: self.runtime.dispose(ear)

    # -- more than one server --------------------------------------------------------------------------------------

    @property
    def is_shared(self) -> bool:
        """More than one server is on the graph; one that crashed may linger there."""
        return len(self.peers()) > 1

    def survey(self, on_result: Callable[[str], None], within_s: float = 0.0) -> None:
        """State who serves the action next to another, as soon as no one does, or after a while.

        Args:
            on_result: Takes the sentence, on this thread; empty where at most one server answers.
            within_s: How long a second server may take to go.
        """
        until = time.monotonic() + within_s

        def look(_is_known: bool) -> None:
            if self.is_shared:
                self._count(lambda count: decide(count > 1))
            else:
                on_result("")

        def decide(is_contested: bool) -> None:
            if is_contested and time.monotonic() < until:
                self.runtime.later(STEP_S, lambda: look(True))
            else:
                on_result(self.contest() if is_contested else "")

        opened_at = self.runtime.opened_at
        self.runtime.when(lambda: time.monotonic() >= opened_at + SETTLE_S, SETTLE_S, look)

    def contest(self) -> str:
        """Who serves the action, in a sentence."""
        names = sorted(name for name in self.peers().values() if name)
        by = f" ({', '.join(names)})" if names else ""
        return f"more than one server answers for {self.action}{by}; stop all but one"

    def _count(self, then: Callable[[int], None]) -> None:
        """Find out how many servers live: each of them answers, one that crashed does not."""
        count = self.client.probe()
        self.runtime.when(lambda: count() > 1, PROBE_S, lambda _are_more: then(count()))

    def _probe(self) -> None:
        """There may be a second server while goals are under way."""

        def found(count: int) -> None:
            self._is_probing = False
            for goal in tuple(self._running) if count > 1 else ():
                goal.share()

        if not self._is_probing and not all(goal.is_contested for goal in self._running):
            self._is_probing = True
            self._count(found)

    def _answered_twice(self, goal_id: bytes) -> None:
        if (goal := self._ours.get(goal_id)) is not None:
            goal.share()

    def _sighted(self, goal_id: bytes, stamp: int, status: int) -> None:
        if (goal := self._ours.get(goal_id)) is None:
            return
        goal.sight(stamp, status)
        if goal in self._lost and not goal.sightings.is_active:
            self.caught(goal)
        elif goal.is_over and goal.sightings.is_active:
            self.look_again(goal)

    def look_again(self, goal: RemoteGoal) -> None:
        """Find out after a while whether some server is executing a goal whose end was reported."""
        self.runtime.later(QUIET_S, lambda: self._find_stray(goal))

    def _find_stray(self, goal: RemoteGoal) -> None:
        if goal.sightings.is_active and goal not in self._lost and (goal.is_contested or self.is_shared):
            goal.stray()

    # -- until the end ---------------------------------------------------------------------------------------------

    def watch(self, goal: RemoteGoal) -> None:
        """Look after the server until the goal has ended."""
        self._running.add(goal)
        self._ours[goal.uuid] = goal
        while len(self._ours) > REMEMBERED:
            self._ours.popitem(last=False)
        self._look_later()

    def chase(self, goal: RemoteGoal) -> None:
        """No one owns a lost goal any more: if its server comes back with it, it is canceled."""
        self._lost[goal] = math.inf
        self._look_later()

    def caught(self, goal: RemoteGoal, *, is_replaced: bool = False) -> None:
        """A lost goal runs no more at a server that has answered; unless another is seen to execute it.

        Args:
            goal: Which.
            is_replaced: The server that had it is another one now, whatever it was seen to do.
        """
        if goal in self._lost and (is_replaced or not goal.sightings.is_active):
            self._let_go(goal)
            goal.be_over()

    def _let_go(self, goal: RemoteGoal) -> None:
        self._lost.pop(goal, None)
        self._pressed.pop(goal, None)

    def is_clear(self) -> bool:
        """No goal that was lost may still run."""
        return not self._lost

    def hasten(self) -> None:
        """Someone waits for the lost goals to end."""
        for goal in tuple(self._lost):
            self._press(goal)

    def _press(self, goal: RemoteGoal) -> None:
        """Ask for a lost goal's end, in one word at a time: another would end what is sent again under its id."""
        now = time.monotonic()
        if goal in self._lost and now >= self._pressed.get(goal, 0.0):
            self._pressed[goal] = now + PRESS_S
            goal.cancel_blindly()

    def answered(self, goal: RemoteGoal) -> None:
        """A lost goal's server has answered, and may be asked again."""
        self._pressed.pop(goal, None)

    def _look_later(self) -> None:
        if not self._is_watched:
            self._is_watched = True
            self.runtime.later(WATCH_S, self._look)

    def _look(self) -> None:
        self._is_watched = False
        running = {goal for goal in self._running if not goal.is_over}
        now = self.peers() if running else NO_PEERS
        is_there = self.client.server_is_ready()
        self._running.clear()
        if len(now) > 1:
            self.runtime.post(self._probe)
        for goal in running:
            if are_gone(goal.peers, now) or not (goal.peers or is_there):
                goal.end("lost", why=f"the server of {self.action} is gone")
            else:
                goal.look()
                self.watch(goal)
        at = time.monotonic()
        for goal, until in list(self._lost.items()):
            self._lost[goal] = min(until, at + CHASE_S) if is_there else math.inf
            if at > until:
                self._let_go(goal)
            elif is_there:
                self._press(goal)
        if self._lost:
            self._look_later()

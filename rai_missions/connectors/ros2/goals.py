# SPDX-License-Identifier: Apache-2.0
"""The goals that a mission pursues with action servers elsewhere, each until its end was heard or its server is gone.

Rule: a goal that has ended never reports again, a cancel is never lost, and what is accepted too late is canceled.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any, Literal

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from rai_missions.connectors.connector import Report
from rai_missions.connectors.ros2.goal_ids import to_bytes
from rai_missions.connectors.ros2.messages import to_data
from rai_missions.connectors.ros2.peers import NOBODY, Peers, are_gone, are_replaced, servers_of_action
from rai_missions.connectors.ros2.runtime import Runtime, Work, guarded
from rai_missions.connectors.ros2.services import MANY, WATCH_S
from rai_missions.connectors.ros2.window import Window

__all__ = ("End", "Goal", "GoalClient")

log = logging.getLogger(__name__)

CHASE_S = 60.0
"""How long a lost goal is chased."""
PRESS_S = 2.0
"""How long an answer is awaited before a lost goal's end is asked for once more."""
CLEAR_S = 5.0
"""How long a new goal waits until it is known of a lost one that it runs no more."""
End = Literal["rejected", "succeeded", "failed", "canceled", "lost"]
ENDS: dict[int, End] = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_ABORTED: "failed",
    GoalStatus.STATUS_CANCELED: "canceled",
}


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
        self.client = ActionClient(
            runtime.node, cls, action, callback_group=runtime.group, goal_service_qos_profile=MANY,
            result_service_qos_profile=MANY, cancel_service_qos_profile=MANY, feedback_sub_qos_profile=MANY,
        )  # fmt: skip
        runtime.keep(self, self.client.destroy)
        self.peers = servers_of_action(runtime.node, action)
        self.patience_s = patience_s
        self.starts, self.cancels = Window(), Window()
        self._running: set[Goal] = set()
        self._lost: dict[Goal, float] = {}
        self._pressed: dict[Goal, float] = {}
        self._is_watched = False
        runtime.later(patience_s, self._grow_impatient)

    def _grow_impatient(self) -> None:
        self.patience_s = 0.0

    def overhear(self, topic: str, cls: Any, quality: Any, hear: Callable[[Any], None]) -> Work:
        """Listen to what the server tells everybody: its `status` or `feedback`; returns what ends it."""
        node, name = self.runtime.node, f"{self.action}/_action/{topic}"
        ear = node.create_subscription(cls, name, hear, quality, callback_group=self.runtime.group)
        self.runtime.keep(ear, lambda: node.destroy_subscription(ear))
        return lambda: self.runtime.dispose(ear)

    def watch(self, goal: Goal) -> None:
        """Look after the server until the goal has ended."""
        self._running.add(goal)
        self._look_later()

    def chase(self, goal: Goal) -> None:
        """Nobody owns a lost goal any more: if its server comes back with it, it is canceled."""
        self._lost[goal] = time.monotonic() + CHASE_S
        self._look_later()

    def caught(self, goal: Goal) -> None:
        """A lost goal runs no more."""
        self._lost.pop(goal, None)
        self._pressed.pop(goal, None)

    def is_clear(self) -> bool:
        """No goal that was lost may still run."""
        return not self._lost

    def hasten(self) -> None:
        """Somebody waits for the lost goals to end."""
        for goal in tuple(self._lost):
            self._press(goal)

    def _press(self, goal: Goal) -> None:
        """Ask for a lost goal's end, in one word at a time: another would end what is sent anew under its id."""
        now = time.monotonic()
        if goal in self._lost and now >= self._pressed.get(goal, 0.0):
            self._pressed[goal] = now + PRESS_S
            goal.cancel_blindly()

    def answered(self, goal: Goal) -> None:
        """A lost goal's server has answered, and may be asked again."""
        self._pressed.pop(goal, None)

    def _look_later(self) -> None:
        if not self._is_watched:
            self._is_watched = True
            self.runtime.later(WATCH_S, self._look)

    def _look(self) -> None:
        self._is_watched = False
        running = {goal for goal in self._running if not goal.is_over}
        now = self.peers() if running else NOBODY
        is_there = self.client.server_is_ready()
        self._running.clear()
        for goal in running:
            if are_gone(goal.peers, now) or not is_there:
                goal.end("lost", why=f"the server of {self.action} is gone")
            else:
                goal.look()
                self.watch(goal)
        for goal, until in list(self._lost.items()):
            if time.monotonic() > until:
                self.caught(goal)
            elif is_there:
                self._press(goal)
        if self._lost:
            self._look_later()


class Goal:
    """One goal on its way. On its runtime's thread only.

    Args:
        client: The action that it is for.
        goal_id: As the mission calls it.
        report: Whom to tell.
        ended: Told once, before the end is reported.
    """

    def __init__(
        self, client: GoalClient, goal_id: str, report: Callable[[Report], None], ended: Callable[[Goal], None]
    ) -> None:
        self._client, self.goal_id, self._report, self._ended = client, goal_id, report, ended
        self._uuid = UUID(uuid=list(to_bytes(goal_id)))
        self._handle: Any = None
        self._early: list[Any] = []
        self._leaves: list[Work] = []
        self._is_unwanted = self._is_sent = self._is_asking = self._is_overdue = False
        self.is_over = self.is_settled = False
        """`is_settled`: its end is known, or its server has said what it thinks of a cancel."""
        self.peers: Peers = NOBODY

    def send(self, goal: Any) -> None:
        """Send it as soon as its server is found."""
        ready = self._client.client.server_is_ready
        self._client.runtime.when(
            lambda: self.is_over or ready(), self._client.patience_s, lambda is_there: self._clear(goal, is_there)
        )

    def _clear(self, goal: Any, is_there: bool) -> None:
        """A server that was away may have kept what it ran then: that has to end first."""
        if self.is_over:
            return
        if not is_there:
            self.end("rejected", why=f"nobody serves {self._client.action}")
            return
        self._client.hasten()
        self._client.runtime.when(
            lambda: self.is_over or self._client.is_clear(), CLEAR_S, lambda is_clear: self._send(goal, is_clear)
        )

    def _send(self, goal: Any, is_clear: bool) -> None:
        if self.is_over:
            return
        if not is_clear:
            self.end("rejected", why=f"an earlier goal, which was lost, may still run at {self._client.action}")
            return
        self._client.starts.enter(lambda leave: self._start(goal, leave))

    def _start(self, goal: Any, leave: Work) -> None:
        if self.is_over:
            leave()
            return
        self._leaves.append(leave)
        self.peers, self._is_sent = self._client.peers(), True
        future = self._client.client.send_goal_async(goal, feedback_callback=self._advance, goal_uuid=self._uuid)
        future.add_done_callback(self._answered)
        future.add_done_callback(lambda _future: leave())
        self._client.watch(self)

    def cancel(self) -> None:
        """Ask for its end; before the acceptance is heard the wish is kept, and asked for again then."""
        was_unwanted, self._is_unwanted = self._is_unwanted, True
        if self.is_over:
            return
        if not self._is_sent:
            self.end("canceled", why="it was not sent yet")
        elif self._handle is not None:
            self._ask_to_cancel(self._handle)
        elif not was_unwanted:
            self._client.cancels.enter(self._ask_early)

    def _ask_early(self, leave: Work) -> None:
        """It may run already: the word of its acceptance may be late. What the server says to this means nothing."""
        self._leaves.append(leave)
        early = ClientGoalHandle(self._client.client, self._uuid, None)
        early.cancel_goal_async().add_done_callback(lambda _future: leave())

    def cancel_blindly(self) -> None:
        """Ask for its end whether or not it was accepted, and although nobody hears of it."""
        if self._is_sent:
            self._ask(self._handle or ClientGoalHandle(self._client.client, self._uuid, None), lambda: None)

    def end(self, said: End, data: dict[str, Any] | None = None, why: str = "") -> None:
        """It is over; the first end counts."""
        if self.is_over:
            return
        self.is_over = self.is_settled = True
        for leave in self._leaves:  # an answer that never comes must not keep others waiting
            leave()
        self._is_asking = False
        self._ended(self)
        if said == "lost" and self._is_sent:
            self._client.chase(self)
        self._tell(Report(self.goal_id, said, data or {}, why))

    def _tell(self, report: Report) -> None:
        guarded(lambda: self._report(report))

    def _answered(self, future: Any) -> None:
        handle = _result_of(future)
        if handle is None:
            self.end("lost", why=f"{self._client.action} gave no answer to a goal")
        elif not handle.accepted:
            self.end("rejected", why=f"the server of {self._client.action} does not take the goal")
            self._client.caught(self)
        elif self.is_over:
            self._handle = handle
            self._ask_to_cancel(handle)  # nobody owns it any more
        else:
            self._handle = handle
            self._tell(Report(self.goal_id, "accepted", {}))
            for feedback in self._early:
                self._advance(feedback)
            self._ask_for_result()
            if self._is_unwanted:
                self._ask_to_cancel(handle)

    def _ask_for_result(self) -> None:
        self._handle.get_result_async().add_done_callback(self._finished)

    def look(self) -> None:
        """Ask once more for a result that should have come: a busy server forgets requests."""
        if self._handle is not None and self._handle.status in ENDS:
            if self._is_overdue:
                self._ask_for_result()
            self._is_overdue = True

    def _advance(self, feedback: Any) -> None:
        if self.is_over:
            return
        if self._handle is None:
            self._early.append(feedback)
        else:
            self._tell(Report(self.goal_id, "feedback", to_data(feedback.feedback)))

    def _finished(self, future: Any) -> None:
        response = _result_of(future)
        if response is not None and self.is_over:
            self._client.caught(self)
        elif response is not None:
            said = ENDS.get(response.status) or ENDS.get(self._handle.status)
            if said is None:
                self.end("lost", why=f"the server of {self._client.action} knows nothing of the goal")
            else:
                self.end(said, to_data(response.result))

    def _ask_to_cancel(self, handle: Any) -> None:
        if not self._is_asking:
            self._is_asking = True
            self._client.cancels.enter(lambda leave: self._ask(handle, leave))

    def _ask(self, handle: Any, leave: Work) -> None:
        self._leaves.append(leave)
        future = handle.cancel_goal_async()
        future.add_done_callback(self._cancel_answered)
        future.add_done_callback(lambda _future: leave())

    def _cancel_answered(self, future: Any) -> None:
        self._is_asking, self.is_settled = False, True
        self._client.answered(self)
        response, codes = _result_of(future), CancelGoal.Response
        if response is None:
            return
        is_ending = bool(response.goals_canceling) or response.return_code == codes.ERROR_GOAL_TERMINATED
        if self.is_over:
            self._chased(response, is_ending)
        elif self._handle is None or is_ending:
            return
        elif response.return_code == codes.ERROR_UNKNOWN_GOAL_ID:
            self.end("lost", why=f"the server of {self._client.action} knows nothing of the goal")
        else:
            self._is_unwanted = False
            self._tell(Report(self.goal_id, "cancel_rejected", {}, f"the server of {self._client.action} goes on"))

    def _chased(self, response: Any, is_ending: bool) -> None:
        """What the server says of a goal that was lost. That it is ending is not yet its end."""
        is_unknown = response.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
        if is_ending:
            handle = self._handle or ClientGoalHandle(self._client.client, self._uuid, None)
            handle.get_result_async().add_done_callback(self._finished)
        elif is_unknown and (self._handle is not None or are_replaced(self.peers, self._client.peers())):
            self._client.caught(self)  # else its server may still be about to accept it


def _result_of(future: Any) -> Any:
    """What a future brought; None if it was given up or failed."""
    if future.cancelled():
        return None
    fault = future.exception()
    if fault is not None:
        log.warning("an action's answer was lost: %s", fault)
        return None
    return future.result()

# SPDX-License-Identifier: Apache-2.0
"""One goal that a mission pursues at action servers elsewhere, until its end is known or its server is gone.

Rule: a goal that has ended reports only whether it is executing nevertheless, a cancel is never lost and goes to every
server, and what is accepted too late is canceled.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Literal

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from rai_missions.connectors.connector import OnReport, Report
from rai_missions.connectors.ros2.endpoints import NO_PEERS, Peers, are_replaced
from rai_missions.connectors.ros2.goal_client import PRESS_S, QUIET_S, STEP_S, GoalClient
from rai_missions.connectors.ros2.messages import goal_id_to_bytes, to_data
from rai_missions.connectors.ros2.node_thread import guarded
from rai_missions.connectors.ros2.rivals import Sightings
from rai_missions.connectors.worker import Work
from rai_missions.redaction import logger

__all__ = ("End", "RemoteGoal")

log = logger(__name__)

CLEAR_S = 5.0
"""How long a new goal waits until it is known of a lost one that it runs no more."""
End = Literal["rejected", "succeeded", "failed", "canceled", "lost"]
WORST_FIRST: tuple[End, ...] = ("failed", "canceled", "succeeded")
ENDS: dict[int, End] = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_ABORTED: "failed",
    GoalStatus.STATUS_CANCELED: "canceled",
}


class RemoteGoal:
    """One goal on its way. On its runtime's thread only.

    Args:
        client: The action that it is for.
        goal_id: As the mission calls it.
        on_report: Notified of all that becomes of it.
        ended: Called once, before the end is reported.
    """

    def __init__(
        self, client: GoalClient, goal_id: str, on_report: OnReport, ended: Callable[[RemoteGoal], None]
    ) -> None:
        self._client, self.goal_id, self._report, self._ended = client, goal_id, on_report, ended
        self.uuid = goal_id_to_bytes(goal_id)
        self._uuid = UUID(uuid=list(self.uuid))
        self._handle: Any = None
        self._early: list[Any] = []
        self._leaves: list[Work] = []
        self._is_unwanted = self._is_sent = self._is_asking = self._is_overdue = False
        self._may_run = True
        self.is_over = self.is_settled = False
        """`is_settled`: its end is known, or its server has reported whether it cancels."""
        self.peers: Peers = NO_PEERS
        self.sightings = Sightings()
        self.is_contested = False
        """A second server was seen while it was under way."""
        self._held: tuple[End, dict[str, Any], str] | None = None
        """An end that counts once no other server is executing the goal."""
        self._quiet_since = self._pressed_at = 0.0

    def abandon(self) -> None:
        """Nothing more is received of it."""
        self.is_over = True

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
            self.end("rejected", why=self._client.why_absent())
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
        self._client.survey(lambda contest: self._enter(goal, contest))

    def _enter(self, goal: Any, contest: str) -> None:
        if contest:
            self.end("rejected", why=contest)
        elif not self.is_over:
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
        """Ask for its end; before the acceptance is received the wish is kept, and asked for again then."""
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
        """Cancel a goal whose acceptance is unknown: it may run already. What the server replies means nothing."""
        self._leaves.append(leave)
        self._unanswered().cancel_goal_async().add_done_callback(lambda _future: leave())

    def cancel_blindly(self) -> None:
        """Ask for its end whether or not it was accepted, and although no one waits for it."""
        if self._is_sent:
            self._ask(self._handle or self._unanswered(), lambda: None)

    def _unanswered(self) -> ClientGoalHandle:
        """A handle of the goal, whether or not a server has accepted it."""
        return ClientGoalHandle(self._client.client, self._uuid, None)

    def end(self, how: End, data: dict[str, Any] | None = None, why: str = "") -> None:
        """End the goal; the first end counts, with a second server once none of them is executing the goal."""
        if self.is_over:
            return
        if how == "lost" and self._held is not None and not self.sightings.is_active:
            self._conclude(*self._held)
        elif how == "lost" or not self._is_sent or not (self.is_contested or self._client.is_shared):
            self._conclude(how, data or {}, why)
        else:
            is_new = self._held is None
            if self._held is None or self._held[0] == "rejected":
                self._held = (how, data or {}, why)
            if is_new:
                self._quiet_since = time.monotonic()
                self._settle()

    def _settle(self) -> None:
        """An end was reported: wait until no server has been executing the goal for a while."""
        if self.is_over or self._held is None:
            return
        now = time.monotonic()
        if self.sightings.is_active:
            self._quiet_since = now
            self._accept(self._unanswered())  # one server has rejected it, another is executing it
            if self._is_unwanted and now >= self._pressed_at:
                self._pressed_at = now + PRESS_S
                self._ask_to_cancel(self._handle)
        if now < self._quiet_since + QUIET_S:
            self._client.runtime.later(STEP_S, self._settle)
            return
        how, data, why = self._held
        found = {ENDS[status] for status in self.sightings.ends if status in ENDS} | {how} - {"rejected"}
        worst: End = next((each for each in WORST_FIRST if each in found), how)
        self._conclude(worst, data, why or ("" if worst == how else "its servers ended it in different ways"))

    def _accept(self, handle: Any) -> None:
        """A server has accepted the goal, by its answer or as its status messages show; the first of them counts."""
        if self._handle is not None:
            return
        self._handle = handle
        self._deliver(Report(self.goal_id, "accepted", {}))
        for feedback in self._early:
            self._advance(feedback)
        self._ask_for_result()
        if self._is_unwanted:
            self._ask_to_cancel(handle)

    def share(self) -> None:
        """A second server was seen."""
        if not self.is_contested:
            self.is_contested = True
            self._warn(Report(self.goal_id, "contested", {}, self._client.contest()))
            if self.is_over:
                self._client.look_again(self)

    def stray(self) -> None:
        """Some server is executing it although its end was reported."""
        why = f"a server of {self._client.action} is executing it although its end was reported; it is canceled"
        self._client.chase(self)
        self._warn(Report(self.goal_id, "stray", {}, why))

    def be_over(self) -> None:
        """Report that a goal, lost or stray before, is executing nowhere any more."""
        self._deliver(Report(self.goal_id, "over", {}))

    def _warn(self, report: Report) -> None:
        log.warning("goal %s: %s", self.goal_id, report.why)
        self._deliver(report)

    def _conclude(self, how: End, data: dict[str, Any], why: str) -> None:
        self.is_over = self.is_settled = True
        for leave in self._leaves:  # an answer that never comes must not keep others waiting
            leave()
        self._is_asking = False
        self._ended(self)
        if how == "lost" and self._is_sent and self._may_run:
            self._client.chase(self)
        elif self._is_sent:
            self._client.look_again(self)
        self._deliver(Report(self.goal_id, how, data, why, may_run=self._may_run))

    def _deliver(self, report: Report) -> None:
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
            self._ask_to_cancel(handle)  # no one owns it any more
        else:
            self._accept(handle)

    def _ask_for_result(self) -> None:
        self._handle.get_result_async().add_done_callback(self._finished)

    def sight(self, stamp: int, status: int) -> None:
        """A status message has the goal; arguments as `Sightings.follow` has them."""
        self.sightings.follow(stamp, status)

    def look(self) -> None:
        """See to an answer that should have come: one to a client that its server has only just met is dropped."""
        if self._held is not None or not self.sightings:
            return
        if self._handle is None:
            self._accept(self._unanswered())
        elif not self.sightings.is_active:
            if self._is_overdue:
                self._ask_for_result()
            self._is_overdue = True

    def _advance(self, feedback: Any) -> None:
        if self.is_over:
            return
        if self._handle is None:
            self._early.append(feedback)
        else:
            self._deliver(Report(self.goal_id, "feedback", to_data(feedback.feedback)))

    def _finished(self, future: Any) -> None:
        response = _result_of(future)
        if response is not None and self.is_over:
            self._client.caught(self)
        elif response is not None:
            how = ENDS.get(response.status) or next((ENDS[each] for each in self.sightings.ends if each in ENDS), None)
            if how is None:
                self._may_run = False
                self.end("lost", why=f"the server of {self._client.action} knows nothing of the goal")
            else:
                self.end(how, to_data(response.result))

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
        elif response.return_code == codes.ERROR_UNKNOWN_GOAL_ID and (self.is_contested or self._client.is_shared):
            return  # it is another server that has it
        elif response.return_code == codes.ERROR_UNKNOWN_GOAL_ID:
            self._may_run = False
            self.end("lost", why=f"the server of {self._client.action} knows nothing of the goal")
        else:
            self._is_unwanted = self.is_contested
            self._deliver(Report(self.goal_id, "cancel_rejected", {}, f"the server of {self._client.action} continues"))

    def _chased(self, response: Any, is_ending: bool) -> None:
        """What the server reports about a goal that was lost. That it is ending is not yet its end."""
        is_unknown = response.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
        if is_ending:
            handle = self._handle or self._unanswered()
            handle.get_result_async().add_done_callback(self._finished)
        elif is_unknown and are_replaced(self.peers, self._client.peers()):
            self._client.caught(self, is_replaced=True)
        elif is_unknown and self._handle is not None:
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

# SPDX-License-Identifier: Apache-2.0
"""Goals that tools have sent to actions: each by its id, with what its server truly reported about it.

Rule: how a goal ended is what its server reported; until it has, the goal is not over, and no one is notified that it
is.
"""

from __future__ import annotations

import threading
import uuid
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from rai_missions.connectors.connector import Data, Report
from rai_missions.errors import UsageError
from rai_missions.redaction import cut_repr
from rai_missions.tools.access import AllowedConnector
from rai_missions.tools.latest import Latest

__all__ = ("GoalState", "ToolGoal", "ToolGoals")

State = Literal["sent", "running", "rejected", "succeeded", "aborted", "canceled", "lost"]
STATES: Mapping[str, State] = {
    "accepted": "running", "feedback": "running", "cancel_rejected": "running", "rejected": "rejected",
    "succeeded": "succeeded", "failed": "aborted", "canceled": "canceled", "lost": "lost",
}  # fmt: skip
"""What a server reports → how the goal is, where that changes; `aborted` is ROS's word for a failed action."""
ENDS = frozenset({"rejected", "succeeded", "aborted", "canceled", "lost"})
WORDS: Mapping[State, str] = {
    "sent": "was sent; the server has not yet reported whether it takes it",
    "running": "was accepted and is still running; it has not ended",
    "rejected": "was REJECTED by the server and never ran",
    "succeeded": "has SUCCEEDED",
    "aborted": "was ABORTED: the server gave up, and it has not succeeded",
    "canceled": "was CANCELED before it was done, and has not succeeded",
    "lost": "is LOST: its server is gone, and whether it continues is unknown",
}
AFTERWARDS: Mapping[str, str] = {
    "stray": "; YET a server is executing it although its end was reported, and it is canceled there",
    "over": "; it is executing nowhere any more",
}
"""What may be reported of a goal that has ended → what is added to its words."""
NOTHING: Data = MappingProxyType({})
KEPT = 100
"""Goals that are remembered after their end."""
AT_ONCE = 20
"""Goals that may run at the same time."""


class GoalState(NamedTuple):
    """How a goal is."""

    goal_id: str
    action: str
    state: State
    result: Data = NOTHING
    """The end's fields."""
    feedback: Data | None = None
    """The newest."""
    feedbacks: int = 0
    """How much feedback there was."""
    why: str = ""
    cancel: Literal["", "asked", "refused"] = ""
    """Whether the server was asked to cancel it, and whether it refused."""
    after: str = ""
    """What was reported after its end, one of `AFTERWARDS`: `stray` while it is executing nevertheless."""

    @property
    def is_over(self) -> bool:
        return self.state in ENDS

    def words(self) -> str:
        """In a sentence of our own; what the server reported next to it is data."""
        refused = "; the server refused to cancel it" if self.cancel == "refused" and not self.is_over else ""
        asked = "; it was asked to cancel and has not confirmed" if self.cancel == "asked" and not self.is_over else ""
        return (
            f"goal {self.goal_id} of {self.action} {WORDS[self.state]}{refused}{asked}{AFTERWARDS.get(self.after, '')}"
        )

    def data(self) -> dict[str, Any]:
        return {**self._asdict(), "result": dict(self.result), "is_over": self.is_over}


class ToolGoal:
    """One goal, and who waits for news of it."""

    def __init__(self, goal_id: str, action: str) -> None:
        self._lock = threading.Lock()
        self.news: Latest[GoalState] = Latest()
        self.news.put(GoalState(goal_id, action, "sent"))

    @property
    def state_now(self) -> GoalState:
        assert self.news.value is not None
        return self.news.value

    def receive(self, report: Report) -> None:
        """What the server reports; after an end nothing changes but whether it is executing nevertheless."""
        with self._lock:
            now = self.state_now
            if report.goal_id != now.goal_id:
                return
            if now.is_over:
                self.news.put(now._replace(after=report.status if report.status in AFTERWARDS else now.after))
                return
            changed = now._replace(state=STATES.get(report.status, now.state), why=report.why)
            if report.status == "feedback":
                changed = changed._replace(feedback=report.data, feedbacks=now.feedbacks + 1, why=now.why)
            elif report.status == "cancel_rejected":
                changed = changed._replace(cancel="refused")
            elif changed.is_over:
                changed = changed._replace(result=report.data)
            self.news.put(changed)

    def want_no_more(self) -> None:
        with self._lock:
            if not self.state_now.is_over:
                self.news.put(self.state_now._replace(cancel="asked"))


class ToolGoals:
    """All goals of one set of tools.

    Args:
        reach: The way to the robot.
    """

    def __init__(self, reach: AllowedConnector) -> None:
        self._reach = reach
        self._lock = threading.Lock()
        self._goals: dict[str, ToolGoal] = {}
        self._is_stopped = False

    def start(self, action: str, type_name: str, goal: Data, ends: float) -> GoalState:
        """Send a goal, and wait until its server has reported whether it takes it."""
        goal_id = f"tool-{uuid.uuid4().hex[:10]}"  # fifteen letters: ROS carries them as they are
        sent = self._keep(ToolGoal(goal_id, action), goal_id)
        try:
            self._reach.send_goal(action, type_name, goal, goal_id, sent.receive)
        except BaseException:
            with self._lock:
                self._goals.pop(goal_id, None)
            self._reach.done(sent.news)
            raise
        sent.news.wait(ends, lambda status: status.state != "sent")
        return sent.state_now

    def watch(self, goal_id: str, ends: float) -> GoalState:
        """How a goal is once it is over, or when the time is."""
        goal = self._known(goal_id)
        goal.news.wait(ends, lambda status: status.is_over)
        return goal.state_now

    def cancel(self, goal_id: str, ends: float) -> GoalState:
        """Ask a goal's server to end it, and wait for what it reports about that."""
        goal = self._known(goal_id)
        goal.want_no_more()
        if not goal.state_now.is_over:
            self._reach.cancel_goal(goal_id)
        goal.news.wait(ends, lambda status: status.is_over or status.cancel == "refused")
        return goal.state_now

    def all(self) -> tuple[GoalState, ...]:
        """Every goal that is remembered, oldest first."""
        with self._lock:
            return tuple(goal.state_now for goal in self._goals.values())

    def stop(self, ends: float) -> tuple[GoalState, ...]:
        """Cancel what still runs; the goals that are not over when the time is."""
        with self._lock:
            self._is_stopped = True
        running = [status.goal_id for status in self.all() if not status.is_over]
        for goal_id in running:
            self._known(goal_id).want_no_more()
            self._reach.cancel_goal(goal_id)
        left = tuple(status for goal_id in running if not (status := self.watch(goal_id, ends)).is_over)
        with self._lock:
            goals = tuple(self._goals.values())
        for goal in goals:
            self._reach.done(goal.news)
        return left

    def _keep(self, goal: ToolGoal, goal_id: str) -> ToolGoal:
        with self._lock:
            if self._is_stopped:
                raise UsageError("the tools were stopped")
            over = [key for key, kept in self._goals.items() if kept.state_now.is_over]
            if len(self._goals) - len(over) >= AT_ONCE:
                raise UsageError(f"{AT_ONCE} goals run already; cancel one, or wait until one has ended")
            for key in over[: max(0, len(over) - KEPT + 1)]:
                self._reach.done(self._goals.pop(key).news)
            self._reach.waiting(goal.news)
            self._goals[goal_id] = goal
        return goal

    def _known(self, goal_id: str) -> ToolGoal:
        with self._lock:
            goal = self._goals.get(goal_id)
            known = ", ".join(list(self._goals)[-5:]) or "none was started"
        if goal is None:
            raise UsageError(f"no goal {cut_repr(goal_id, 60)} was started here; there is: {known}")
        return goal

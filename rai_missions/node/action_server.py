# SPDX-License-Identifier: Apache-2.0
"""The mission as an action: a goal starts it, feedback reports where it is, the result how it ended.

Rule: the goal is the run's. Canceling the goal cancels the mission, and the goal ends when the mission has.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.connector import Data, OnReport, Report
from rai_missions.node.order import ClientOrder, OrderReply, from_ros, ignore_reply, mapping_in, who
from rai_missions.node.order_server import OrderServer
from rai_missions.node.run_session import RunSession
from rai_missions.node.status_message import StatusMessage

__all__ = ("RunServer",)


class RunServer:
    """Serves `~/run`; an `ActionServer`.

    Args:
        commands: Takes the orders.
        refused: Receives why a goal is rejected, which ROS has no word for.
    """

    def __init__(self, commands: OrderServer, refused: Callable[[OrderReply], None]) -> None:
        self._commands, self._refused = commands, refused
        self._goal_id = ""
        self._report: OnReport | None = None
        self._session: RunSession | None = None
        self._is_unwanted = False
        self._lock = threading.Lock()
        self._latest: StatusMessage | None = None
        self._fed = 0
        """The revision that was fed back last."""

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        """Start the mission for a goal."""
        given = mapping_in(goal.get("arguments", ""), "arguments")
        if isinstance(given, str):
            reply = OrderReply(False, given, goal_id)
        else:
            reply = self._commands.ask(from_ros(ClientOrder("start", who(goal.get("by")), goal_id, arguments=given)))
        if not reply.success:
            self._refused(reply)
            report(Report(goal_id, "rejected", {}, reply.why))
            return
        report(Report(goal_id, "accepted", {}))
        with self._lock:
            self._goal_id, self._report, self._session = goal_id, report, self._commands.session
            self._is_unwanted = False
            self._feed()  # the run may have been quicker than this thread
        self._commands.when_idle(lambda: self._end(goal_id))

    def cancel(self, goal_id: str) -> None:
        """Cancel the mission of a goal."""
        if goal_id == self._goal_id:
            self._is_unwanted = True
            self._commands.submit(ClientOrder("cancel", "operator (~/run)", goal_id, role="operator"), ignore_reply)

    def follow(self, status: StatusMessage) -> None:
        """What the mission is doing now."""
        with self._lock:
            self._latest = status
            self._feed()

    def _feed(self) -> None:
        """Feedback for the goal that runs, if there is news."""
        report, session, latest = self._report, self._session, self._latest
        if report is None or session is None or latest is None or latest.revision <= self._fed:
            return
        if session.is_over or latest.run != session.runner.run_id:
            return
        self._fed = latest.revision
        fields: dict[str, Any] = latest.fields()
        feedback = {word: fields[word] for word in ("revision", "mode", "questions")}
        report(Report(self._goal_id, "feedback", feedback | {"state": fields["active"]}))

    def _end(self, goal_id: str) -> None:
        report, session = self._report, self._session
        if report is None or session is None or goal_id != self._goal_id:
            return
        with self._lock:
            self._report = None
        result = session.result
        data: dict[str, Any] = {
            "outcome": session.mode,
            "why": result.why if result is not None else session.error,
            "run": session.runner.run_id,
            "journal": (result.journal if result is not None else None) or "",
            "open_goals": [goal.data() for goal in result.open_goals] if result is not None else [],
        }
        if session.mode == "succeeded":
            report(Report(goal_id, "succeeded", data))
        elif session.mode == "canceled" and self._is_unwanted:
            report(Report(goal_id, "canceled", data))
        else:
            report(Report(goal_id, "failed", data, data["why"]))

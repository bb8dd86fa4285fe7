# SPDX-License-Identifier: Apache-2.0
"""One goal on its way between a client and an action's server, in the same process.

Rule: a goal that has ended never reports again, and a cancel is never lost, however early it comes.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import ENDS, ActionServer, Data, OnReport, Report
from rai_missions.connectors.worker import SerialQueue
from rai_missions.errors import raised_text
from rai_missions.redaction import logger

__all__ = ("LocalGoal",)

log = logger(__name__)


class LocalGoal:
    """A goal that was sent, until its end was reported.

    Args:
        goal_id: Unique among the goals that run.
        action: The action's name.
        server: Who serves it.
        calls: The server's mailbox: its calls come one after the other, from whichever thread.
        report: Whom to notify.
        ended: Called once, before the end is reported.
    """

    def __init__(
        self,
        goal_id: str,
        action: str,
        server: ActionServer,
        calls: SerialQueue,
        on_report: OnReport,
        *,
        ended: Callable[[LocalGoal], None],
    ) -> None:
        self.goal_id, self.action = goal_id, action
        self._server, self._calls, self._report, self._ended = server, calls, on_report, ended
        self._reports = SerialQueue()
        self._is_accepted = self._is_over = self._is_unwanted = False
        self.end: Report | None = None
        """How it ended."""

    @classmethod
    def adopted(
        cls,
        goal_id: str,
        action: str,
        server: ActionServer,
        calls: SerialQueue,
        *,
        ended: Callable[[LocalGoal], None],
    ) -> LocalGoal:
        """A goal that its server pursues already, and that no one has asked for here yet."""
        made = cls(goal_id, action, server, calls, _discard, ended=ended)
        made._is_accepted = True
        return made

    def send(self, goal: Data) -> None:
        self._calls.post(lambda: self._accept(goal))

    def cancel(self) -> None:
        self._reports.post(self._want_no_more)

    def on_report(self, report: Report) -> None:
        """What the server reports; dropped when it comes late, twice or under another goal's id."""
        self._reports.post(lambda: self._pass_on(report))

    def deliver(self, on_report: OnReport) -> None:
        """Notify someone else from now on, beginning with what has become of it."""
        self._reports.post(lambda: self._begin_again(on_report))

    def _begin_again(self, on_report: OnReport) -> None:
        self._report = on_report
        if self.end is not None:
            on_report(self.end)
        elif self._is_accepted:
            on_report(Report(self.goal_id, "accepted", {}))

    def silence(self) -> None:
        """Nothing more is reported; what is accepted nevertheless is canceled, as any unwanted goal."""
        self._report, self._is_unwanted = _discard, True

    def _accept(self, goal: Data) -> None:
        try:
            self._server.accept(self.goal_id, goal, self.on_report)
        except (Exception, SystemExit) as fault:
            log.exception("%s could not take goal %s", self.action, self.goal_id)
            self.on_report(Report(self.goal_id, "rejected", {}, raised_text(fault)))

    def _want_no_more(self) -> None:
        if not self._is_over and self._is_accepted:
            self._calls.post(self._cancel_now)
        self._is_unwanted = True

    def _cancel_now(self) -> None:
        try:
            if not self._is_over:
                self._server.cancel(self.goal_id)
        except (Exception, SystemExit) as fault:
            log.exception("%s could not cancel goal %s", self.action, self.goal_id)
            self.on_report(Report(self.goal_id, "cancel_rejected", {}, raised_text(fault)))

    def _pass_on(self, report: Report) -> None:
        is_lost = self.end is not None and self.end.status == "lost"
        if is_lost and report.goal_id == self.goal_id and report.status in ENDS and report.status != "lost":
            self.end = report
            self._report(Report(self.goal_id, "over", {}, f"its server reports that it has ended: {report.status}"))
            return
        if self._is_over or report.goal_id != self.goal_id or self._is_out_of_place(report.status):
            return
        if report.status == "rejected" and self._is_accepted:
            report = report._replace(status="failed")
        if not self._is_accepted and report.status not in ("accepted", "rejected", "lost"):
            self._pass_on(Report(self.goal_id, "accepted", {}))
        self._is_accepted = self._is_accepted or report.status == "accepted"
        if report.status in ENDS:
            self._is_over, self.end = True, report
            self._ended(self)
        self._report(report)
        if report.status == "accepted" and self._is_unwanted:
            self._calls.post(self._cancel_now)

    def _is_out_of_place(self, status: str) -> bool:
        """A second acceptance, or the refusal of a cancel that no one asked for."""
        return self._is_accepted if status == "accepted" else status == "cancel_rejected" and not self._is_unwanted


def _discard(_report: Report) -> None:
    """No one listens any more."""

# SPDX-License-Identifier: Apache-2.0
"""A server that sometimes reports the opposite of how a goal ended."""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import Data, OnReport, Report
from rai_missions.worlds.desk.actions import ArmServer

__all__ = ("LyingServer",)


class LyingServer:
    """An `ActionServer` in front of another.

    Args:
        server: The true one.
        lies: Asked once for each goal that ends.
    """

    def __init__(self, server: ArmServer, lies: Callable[[], bool]) -> None:
        self._server, self._lies = server, lies

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        self._server.accept(goal_id, goal, self._to(report))

    def cancel(self, goal_id: str) -> None:
        self._server.cancel(goal_id)

    def continue_with(self, client_of: Callable[[str], OnReport]) -> None:
        self._server.continue_with(lambda goal_id: self._to(client_of(goal_id)))

    def _to(self, report: OnReport) -> OnReport:
        return lambda true: report(self._reported(true))

    def _reported(self, true: Report) -> Report:
        if true.status not in ("succeeded", "failed") or not self._lies():
            return true
        if true.status == "succeeded":
            data = {**true.data, "success": False, "reason": "fault", "message": "the goal failed"}
            return Report(true.goal_id, "failed", data, "the goal failed")
        return Report(true.goal_id, "succeeded", {**true.data, "success": True, "reason": "", "message": ""}, "")

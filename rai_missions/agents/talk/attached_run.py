# SPDX-License-Identifier: Apache-2.0
"""A run that a conversation is about: its status, its orders and the rows of talk in its journal, together."""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.agents.talk.journal import NoteSink, TalkJournal
from rai_missions.agents.talk.orders import RunOrders
from rai_missions.agents.talk.run_status import RobotWords, RunStatus
from rai_missions.engine.step import SayAloud, Step
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.runner import Runner

__all__ = ("AttachedRun",)


class AttachedRun:
    """One run; its observers call from the run's thread.

    Args:
        runner: The run; not begun yet.
        journal: Its journal, for talk after its end; None where it has none.
        robot: Who the robot is.
        on_news: Called where a dialogue is to look at the run again.
        on_speech: Called with each sentence that the mission itself speaks.
    """

    def __init__(
        self,
        runner: Runner,
        journal: NoteSink | None,
        robot: RobotWords,
        on_news: Callable[[], None],
        on_speech: Callable[[str], None],
    ) -> None:
        self.status = RunStatus(runner, robot)
        self.orders, self.journal = RunOrders(runner), TalkJournal(runner, journal)
        self._on_news, self._on_speech = on_news, on_speech

    def step(self, step: Step) -> None:
        """The run has made a step."""
        self.orders.step(step)
        if self.status.step(step):
            self._on_news()
        for effect in step.effects:
            if isinstance(effect, SayAloud):
                self._on_speech(effect.text)

    def changed(self, status: Status) -> None:
        """The run's status has changed."""
        self.status.status(status)
        self._on_news()

    def close(self) -> None:
        """The run is over; its journal is still open."""
        self.orders.close()
        self.journal.close()
        self._on_news()

# SPDX-License-Identifier: Apache-2.0
"""Carries out what steps ask for: goals, calls, messages, questions, handovers; and turns what comes back into events.

Rule: it never waits and never judges. Each thing that comes back carries the number of what it answers.
"""

from __future__ import annotations

import logging
import uuid
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Connector, Reply, Report
from rai_missions.errors import MissionError
from rai_missions.event import Event
from rai_missions.guards.guard import View
from rai_missions.robot import ActionEntry, Robot, plain
from rai_missions.senses import Senses
from rai_missions.step import (
    Ask,
    CallService,
    CancelGoal,
    Effect,
    Handover,
    LogLine,
    PublishMessage,
    SayAloud,
    StartGoal,
    Withdraw,
)
from rai_missions.verdict import Answerer

__all__ = ("Performer",)

log = logging.getLogger(__name__)


class Performer:
    """The hands of a run.

    Args:
        run: The run's identity; goal ids are derived from it.
        robot: The profile; without one every start and call is rejected.
        connector: How the robot is reached.
        answerers: Who answers questions, by name.
        post: Where events go.
        later: Has something done at an instant of the run's clock.
        now: The run's clock.
        view: What is known, for those who answer from it.
        confirm: Told of each effect that was carried out, by number.
    """

    def __init__(
        self, *, run: str, robot: Robot | None, connector: Connector | None, answerers: Mapping[str, Answerer],
        post: Callable[[Event], None], later: Callable[[float, Callable[[], None]], None], now: Callable[[], float],
        view: View, confirm: Callable[[int, str], None],
    ) -> None:  # fmt: skip
        self._run, self._robot, self._connector = run, robot, connector
        self._answerers, self._post, self._later, self._now = answerers, post, later, now
        self._view, self._confirm = view, confirm
        self._goals: dict[int, str] = {}
        self._entries: dict[int, ActionEntry] = {}
        self._open: dict[int, str] = {}
        self._senses = Senses(robot, connector, post=post, later=later, now=now)
        self._perform: Mapping[type, Callable[[Any], None]] = {
            StartGoal: self._start, CancelGoal: self._cancel, CallService: self._call, PublishMessage: self._publish,
            Ask: self._ask, Withdraw: self._withdraw, Handover: lambda effect: self.hand_over(effect.to),
            SayAloud: self._say, LogLine: lambda effect: log.info("%s", effect.text),
        }  # fmt: skip

    @property
    def thinking(self) -> bool:
        """Somebody is asked who has not answered at once: a model or a person, who needs real time."""
        return bool(self._open)

    def open(self) -> None:
        """Start to listen to the robot."""
        self._senses.open()

    def close(self) -> None:
        """Stop listening, and take back every question."""
        self._senses.close()
        for number in list(self._open):
            self._withdraw(Withdraw(number))

    def perform(self, effects: tuple[Effect, ...]) -> None:
        """Carry out the effects of a step, in order; what fails comes back as an event."""
        for effect in effects:
            self._perform[type(effect)](effect)

    # -- goals ----------------------------------------------------------------------------------------------------

    def goal_id(self, number: int, owner: str) -> str:
        """Derived from run, state, leaf and start, so that a run that goes on finds its goals again."""
        return uuid.uuid5(uuid.NAMESPACE_URL, f"{self._run}/{owner}/{number}").hex

    def _start(self, effect: StartGoal) -> None:
        entry = self._robot.actions.get(effect.action) if self._robot is not None else None
        if entry is None or self._connector is None:
            self._result(effect.number, "rejected", {"why": f"no robot has an action '{effect.action}'"})
            return
        try:
            if entry.action is None:
                self._start_composed(entry, effect)
            else:
                self._entries[effect.number] = entry
                goal_id = self._goals[effect.number] = self.goal_id(effect.number, effect.owner)
                self._connector.send_goal(
                    entry.action, entry.type, entry.goal_of(effect.goal), goal_id=goal_id,
                    report=lambda report: self._reported(effect.number, report),
                )  # fmt: skip
        except MissionError as error:
            self._result(effect.number, "rejected", {"why": str(error)})

    def _start_composed(self, entry: ActionEntry, effect: StartGoal) -> None:
        """An action made of services: its `start` accepts, its guards end it, its `cancel` confirms."""
        assert self._connector is not None and entry.start is not None
        start = entry.start

        def answered(reply: Reply) -> None:
            if start.succeeded(reply.outcome, reply.data):
                self._event("accepted", "accepted", effect.number, {})
            else:
                why = reply.why or str(reply.data.get("message", "")) or reply.outcome
                self._result(effect.number, "rejected", {"why": why})

        self._connector.call(start.service, start.type, start.request_of(effect.goal), answered=answered)

    def _cancel(self, effect: CancelGoal) -> None:
        entry = self._robot.actions.get(effect.action) if self._robot is not None else None
        if entry is None or self._connector is None:
            return
        try:
            if entry.action is not None:
                self._connector.cancel_goal(self._goals.get(effect.number, ""))
            elif entry.cancel is None:
                self._result(effect.number, "canceled", {})
            else:
                self._connector.call(
                    entry.cancel.service, entry.cancel.type, entry.cancel.request_of({}),
                    answered=lambda reply: self._canceled(entry, effect.number, reply),
                )  # fmt: skip
        except MissionError as error:
            log.warning("the cancel of '%s' could not be sent: %s", effect.action, error)

    def _canceled(self, entry: ActionEntry, number: int, reply: Reply) -> None:
        assert entry.cancel is not None
        if entry.cancel.succeeded(reply.outcome, reply.data):
            self._result(number, "canceled", {})

    def _reported(self, number: int, report: Report) -> None:
        if report.said in ("accepted", "feedback"):
            self._event(report.said, report.said, number, _told(report.data))
        elif report.said != "cancel_rejected":
            outcome = "failed" if report.said == "lost" else report.said
            why = {"why": report.why} if report.why else {}
            self._result(number, outcome, {**self._result_of(number, report), **why})

    def _result_of(self, number: int, report: Report) -> Mapping[str, Any]:
        entry = self._entries.pop(number, None)
        try:
            return entry.result_of(report.data) if entry is not None else {}
        except MissionError as error:
            return {"why": str(error)}

    def _result(self, number: int, outcome: str, data: Mapping[str, Any]) -> None:
        self._goals.pop(number, None)
        self._event("result", outcome, number, data)

    def _event(self, kind: str, name: str, number: int, data: Mapping[str, Any]) -> None:
        self._post(Event(name, self._now(), dict(data), kind, number))

    # -- calls and messages ---------------------------------------------------------------------------------------

    def _call(self, effect: CallService) -> None:
        entry = self._robot.services.get(effect.service) if self._robot is not None else None
        if entry is None or self._connector is None:
            self._result(effect.number, "unavailable", {"why": f"no robot has a service '{effect.service}'"})
            return

        def answered(reply: Reply) -> None:
            good = entry.succeeded(reply.outcome, reply.data)
            outcome = "succeeded" if good else ("failed" if reply.outcome == "succeeded" else reply.outcome)
            why = reply.why or ("" if good else str(reply.data.get("message", "")))
            self._result(effect.number, outcome, {**_told(reply.data), **({"why": why} if why else {})})

        try:
            request = entry.request_of(effect.request)
            self._connector.call(entry.service, entry.type, request, answered=answered, timeout_s=effect.timeout_s)
        except MissionError as error:
            self._result(effect.number, "unavailable", {"why": str(error)})

    def _publish(self, effect: PublishMessage) -> None:
        entry = self._robot.topics.get(effect.topic) if self._robot is not None else None
        if entry is None or self._connector is None:
            log.warning("nobody has a topic '%s'; its message is lost", effect.topic)
            return
        try:
            self._connector.publish(entry.topic, entry.type, entry.message_of(effect.message))
        except MissionError as error:
            log.warning("'%s' could not be published: %s", effect.topic, error)

    def _say(self, effect: SayAloud) -> None:
        if self._robot is not None and "say" in self._robot.topics:
            self._publish(PublishMessage("say", {"data": effect.text}))
        log.info("says: %s", effect.text)

    # -- questions and control ------------------------------------------------------------------------------------

    def _ask(self, effect: Ask) -> None:
        question = effect.question
        answerer = self._answerers.get(question.asked)

        def answer(data: Mapping[str, Any]) -> None:
            if self._open.pop(question.number, None) is None:
                data = {**data, "late": True}
            self._event("proposal", question.asked, question.number, data)

        self._open[question.number] = question.asked
        if answerer is None:
            answer({"absent": f"nobody called '{question.asked}' is here"})
            return
        try:
            answerer.ask(question, answer)
        except Exception as error:  # whoever answers is not trusted to behave
            log.exception("'%s' failed to take question %d", question.asked, question.number)
            answer({"failed": f"{type(error).__name__}: {error}"})

    def _withdraw(self, effect: Withdraw) -> None:
        asked = self._open.pop(effect.number, None)
        answerer = self._answerers.get(asked) if asked is not None else None
        if answerer is not None:
            try:
                answerer.withdraw(effect.number)
            except Exception:
                log.exception("'%s' failed to give question %d back", asked, effect.number)

    def hand_over(self, to: str) -> None:
        """Have control handed over where the actuators are; the acknowledgement comes back as an event."""
        entry = self._robot.control.get(to) if self._robot is not None else None
        if entry is None or self._connector is None:
            self._event("control", to, 0, {})
            return

        def answered(reply: Reply) -> None:
            if entry.succeeded(reply.outcome, reply.data):
                self._event("control", to, 0, {})

        self._connector.call(entry.service, entry.type, entry.request_of({}), answered=answered)


def _told(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """What came back, as a journal can hold it; what it cannot is named instead."""
    try:
        return dict(plain(data))
    except MissionError as error:
        return {"why": str(error)}

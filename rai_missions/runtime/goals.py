# SPDX-License-Identifier: Apache-2.0
"""The goals of a run, each from its start to its confirmed end: with a server, or composed of services and guards.

Rule: a goal's id follows from run, owner and start, so that a run that continues finds its goals again.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rai_missions.connectors.connector import ENDS, Connector, HostsActions, OnReport, Reply, Report
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.errors import in_words
from rai_missions.event import EventKind
from rai_missions.profile import ActionEntry, Robot, plain, robot_facts
from rai_missions.redaction import cut, logger
from rai_missions.runtime.cancels import Cancels, outcome_of

__all__ = ("Goals", "id_of_goal", "journaled")

log = logger(__name__)

WATCHED: Mapping[str, EventKind] = {
    "cancel_rejected": "refused",
    "contested": "contested",
    "stray": "stray",
    "over": "over",
    "overdue": "overdue",
}
"""What a connector reports of a goal next to its course → the kind of the event that it becomes."""


class Goals:
    """What was started and has not ended.

    Args:
        run: The run's identity.
        robot: The profile; the start of an action that is not in it is rejected.
        connector: How the robot is reached.
        on_event: Called with kind, name, number and data of an event.
        later: Has something done after so many seconds, if the run is not over by then.
    """

    def __init__(
        self,
        run: str,
        robot: Robot,
        connector: Connector | None,
        *,
        on_event: Callable[[EventKind, str, int, Mapping[str, Any]], None],
        later: Callable[[float, Callable[[], None]], None],
    ) -> None:
        self._run, self._robot, self._connector, self._on_event = run, robot, connector, on_event
        self._ids: dict[int, str] = {}
        self._composed: dict[str, CancelGoal] = {}
        """Action → its last start: that it has ended is known to guards alone."""
        self._unwanted: set[int] = set()
        """Goals whose end was asked for: while one is looked for, its server may know nothing of it yet."""
        self._starting: set[int] = set()
        """Composed actions whose `start` has not been answered: it may take effect after a later `cancel`."""
        self._is_closed = False
        self._lost: dict[int, StartGoal] = {}
        """Composed actions that may have begun, and whose end the robot has not answered."""
        self._waiting: set[int] = set()
        """Goals that are sent once a lost one before them has ended."""
        self._conflict = robot_facts(robot).conflict
        self.cancels = Cancels(connector, later)

    def close(self) -> None:
        """The run is over: what has not ended, or is accepted from now on, belongs to no state, and is canceled."""
        self._is_closed = True
        self.cut_off()

    def start(self, effect: StartGoal) -> None:
        """Send a goal, behind the end of a lost one that conflicts with it; raises what the connector raises."""
        for each in tuple(self._composed.values()):
            if self._conflict(each.action, effect.action):
                self.cancels.drop(each.number)
        entry = self._entry(effect.action)
        lost = next((each for each in tuple(self._lost.values()) if self._conflict(each.action, effect.action)), None)
        if entry is None or self._connector is None:
            self._end(effect.number, "rejected", {"why": f"no robot has an action '{effect.action}'"})
        elif lost is not None:
            self._start_behind(lost, effect)
        elif entry.action is None:
            self._compose(entry, effect)
        else:
            self._send(entry, effect)

    def _start_behind(self, lost: StartGoal, effect: StartGoal) -> None:
        """Send a goal once one that may run on has ended."""
        self._waiting.add(effect.number)

        def answered(why: str) -> None:
            if effect.number not in self._waiting:
                return
            self._waiting.discard(effect.number)
            if why:
                why = f"an earlier goal of '{lost.action}', which was lost, may still run: {why}"
                self._end(effect.number, "rejected", {"why": why})
            else:
                self._or_give_up(effect, lambda: self.start(effect))

        self._end_unsure(lost, answered)

    def _send(self, entry: ActionEntry, effect: StartGoal, on_report: OnReport | None = None) -> None:
        assert self._connector is not None and entry.action is not None
        goal = entry.goal_of(effect.goal)
        goal_id, own = self._sent(entry, effect)
        self._connector.send_goal(entry.action, entry.type, goal, goal_id=goal_id, on_report=on_report or own)

    def _send_again(self, entry: ActionEntry, effect: StartGoal, on_report: OnReport) -> None:
        """Send a goal that may have been accepted meanwhile: its server takes no id twice."""

        def report(received: Report) -> None:
            if received.status == "rejected":
                look = partial(self._look_for, entry, effect, on_report, lambda _lost: on_report(received))
                self._or_give_up(effect, look)
            else:
                on_report(received)

        self._send(entry, effect, report)

    def resume(self, effect: StartGoal, *, accepted: bool, on_doubt: Callable[[], None]) -> None:
        """Continue with a goal that an earlier process was to send.

        Args:
            effect: Its start.
            accepted: Its server is known to have accepted it. That a connector took it proves nothing: it may
                have been waiting for the server.
            on_doubt: Called where its fate cannot be known, once the robot has answered the order to end it.
        """
        entry = self._entry(effect.action)
        if entry is None or self._connector is None:
            self.start(effect)
        elif entry.action is not None and not isinstance(self._connector, HostsActions):
            self._find(entry, effect, accepted=accepted)
        elif entry.action is None and accepted:
            self._composed[effect.action] = CancelGoal(effect.number, effect.action)
        elif entry.repeat:
            self.start(effect)
        elif entry.action is None:
            if entry.cancel is not None:
                why = f"the run was killed, and it is not known whether '{effect.action}' was started"
                self._on_event("lost", effect.action, effect.number, {"why": why})
            self._end_unsure(effect, lambda why: on_doubt())
        else:
            on_doubt()

    def _find(self, entry: ActionEntry, effect: StartGoal, *, accepted: bool) -> None:
        """Ask its server; one never accepted, or that may be sent twice, is sent if the server knows nothing of it."""
        assert self._connector is not None and entry.action is not None
        goal_id, on_report = self._sent(entry, effect)

        def absent(_lost: Report) -> None:
            if effect.number in self._unwanted:
                self._end(effect.number, "canceled", {})
            else:
                self._send_again(entry, effect, on_report)

        if accepted and not entry.repeat:
            self._connector.find_goal(entry.action, entry.type, goal_id=goal_id, on_report=on_report)
        else:
            self._look_for(entry, effect, on_report, absent)

    def _look_for(
        self, entry: ActionEntry, effect: StartGoal, on_report: OnReport, absent: Callable[[Report], None]
    ) -> None:
        """Ask a goal's server for it; if the first report is that it is not there, `absent` takes it, and no other."""
        assert self._connector is not None and entry.action is not None
        is_there: bool | None = None

        def report(received: Report) -> None:
            nonlocal is_there
            if is_there is None:
                is_there = received.status != "lost"
                if not is_there:
                    self._or_give_up(effect, lambda: absent(received))
            if is_there:
                on_report(received)

        goal_id = id_of_goal(self._run, effect.number, effect.owner)
        self._connector.find_goal(entry.action, entry.type, goal_id=goal_id, on_report=report)

    def _or_give_up(self, effect: StartGoal, work: Callable[[], None]) -> None:
        try:
            work()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a connector is not trusted to behave
            self.give_up(effect.number, in_words(error))

    def cancel(self, effect: CancelGoal) -> None:
        """Ask for a goal's end; raises what the connector raises."""
        entry = self._entry(effect.action)
        if entry is None or self._connector is None:
            return
        self._unwanted.add(effect.number)
        if entry.action is not None:
            self._connector.cancel_goal(self._ids.get(effect.number, ""))
        elif entry.cancel is None or effect.number in self._waiting:
            self._end(effect.number, "canceled", {})
        else:
            is_early = effect.number in self._starting  # it may come ahead of the start; after that there is another
            self.cancels.call(effect.number, entry.cancel, partial(self._canceled, effect, is_early))

    def give_up(self, number: int, why: str) -> None:
        """A start could not be carried out; it may have arrived before the connector failed."""
        if (goal_id := self._ids.get(number)) is not None and self._connector is not None:
            with suppress(Exception, SystemExit):
                self._connector.cancel_goal(goal_id)
        self._end(number, "rejected", {"why": why})

    def cut_off(self) -> tuple[CancelGoal, ...]:
        """End every goal with a server, whether known to it or not; returns what ends the composed ones."""
        for number in tuple(self._waiting):
            self._end(number, "canceled", {})
        for goal_id in list(self._ids.values()):
            if self._connector is not None:
                with suppress(Exception, SystemExit):  # the others must be stopped too
                    self._connector.cancel_goal(goal_id)
        return tuple(self._composed.values())

    def _entry(self, action: str) -> ActionEntry | None:
        return self._robot.actions.get(action)

    def _sent(self, entry: ActionEntry, effect: StartGoal) -> tuple[str, OnReport]:
        """A goal's id, and what its reports go to."""
        goal_id = self._ids[effect.number] = id_of_goal(self._run, effect.number, effect.owner)
        return goal_id, lambda report: self._reported(entry, effect, goal_id, report)

    def _compose(self, entry: ActionEntry, effect: StartGoal) -> None:
        """An action made of services: its `start` accepts, its guards end it, its `cancel` confirms."""
        assert self._connector is not None and entry.start is not None
        start = entry.start
        self._composed[effect.action] = CancelGoal(effect.number, effect.action)

        self._starting.add(effect.number)

        def answered(reply: Reply) -> None:
            self._starting.discard(effect.number)
            outcome, why = outcome_of(start, reply)
            if outcome == "succeeded":
                self._accepted(effect, {})
                return
            if not reply.may_have_arrived:
                self._end(effect.number, "rejected", {"why": why or outcome})
                return
            self._on_event("lost", effect.action, effect.number, {"why": why})
            self._end_unsure(effect, lambda _: self._end(effect.number, "rejected", {"why": why or outcome}))

        self._connector.call(start.service, start.type, start.request_of(effect.goal), on_reply=answered)

    def _end_unsure(self, effect: StartGoal, on_answer: Callable[[str], object]) -> None:
        """Order the end of a composed action whose start may have arrived: nothing else would end it.

        Args:
            effect: Its start.
            on_answer: Called with why the robot has not answered, or an empty text once it has: what begins before
                that answer might be what the order ends.
        """
        entry = self._entry(effect.action)
        if entry is None or entry.cancel is None:
            on_answer("it has no 'cancel'")
            return
        self._lost[effect.number] = effect
        is_first = True

        def answered(outcome: str, why: str) -> None:
            nonlocal is_first
            is_answered = outcome in ("succeeded", "failed")
            was_lost = is_answered and self._lost.pop(effect.number, None) is not None
            if is_first:
                is_first = False
                on_answer("" if is_answered else why or outcome)
            if was_lost and outcome == "succeeded":
                self._on_event("over", effect.action, effect.number, {"owner": effect.owner})

        try:
            self.cancels.call(effect.number, entry.cancel, answered)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a connector is not trusted to behave
            on_answer(in_words(error))

    def _accepted(self, effect: StartGoal, data: Mapping[str, Any]) -> None:
        """A server has taken a goal; once the run is over, there is no state that could cancel it."""
        self._on_event("accepted", "accepted", effect.number, data)
        if self._is_closed:
            with suppress(Exception, SystemExit):  # a connector is not trusted to behave
                self.cancel(CancelGoal(effect.number, effect.action))

    def _canceled(self, cancel: CancelGoal, is_early: bool, outcome: str, why: str) -> None:
        number, action = cancel
        if outcome == "failed":
            self._on_event("refused", action, number, {"why": why} if why else {})
        elif outcome == "succeeded" and not is_early:
            self._end(number, "canceled", {})

    def _reported(self, entry: ActionEntry, effect: StartGoal, goal_id: str, report: Report) -> None:
        number = effect.number
        if report.goal_id != goal_id:
            log.warning("goal %d: a report of the goal '%s' is not one of it", number, report.goal_id)
        elif report.status == "accepted":
            self._accepted(effect, journaled(report.data))
        elif report.status == "feedback":
            self._on_event("feedback", "feedback", number, journaled(report.data))
        elif report.status in ENDS:
            outcome = "failed" if report.status == "lost" else report.status
            why = {"why": in_words(report.why)} if report.why else {}
            if report.status == "lost" and report.may_run:
                self._on_event("lost", effect.action, number, why)
            self._end(number, outcome, {**_result_of(entry, report), **why})
        elif report.status in WATCHED:
            why = {"why": in_words(report.why)} if report.why else {}
            self._on_event(WATCHED[report.status], effect.action, number, {"owner": effect.owner, **why})
        else:
            log.warning("goal %d: its server reports '%s', which is no end and no progress", number, report.status)

    def _end(self, number: int, outcome: str, data: Mapping[str, Any]) -> None:
        self._ids.pop(number, None)
        self._unwanted.discard(number)
        self._starting.discard(number)
        self._waiting.discard(number)
        if number not in self._lost:
            self.cancels.drop(number)
        for action, cancel in list(self._composed.items()):
            if cancel.number == number:
                del self._composed[action]
        self._on_event("result", outcome, number, data)


def id_of_goal(run: str, number: int, owner: str) -> str:
    """The id under which a start's goal goes to its server."""
    return uuid.uuid5(uuid.NAMESPACE_URL, f"{run}/{owner}/{number}").hex


def _result_of(entry: ActionEntry, report: Report) -> Mapping[str, Any]:
    try:
        return entry.result_of(report.data)
    except Exception as error:  # noqa: BLE001 - whatever a server reports, its goal has ended
        return {"why": f"its result was not understood: {cut(error, 250)}"}


def journaled(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """What came back, as a journal can hold it; what it cannot is named instead."""
    try:
        return dict(plain(data))
    except Exception as error:  # noqa: BLE001 - whatever a server reports, it has answered
        return {"why": f"its data was not understood: {cut(error, 250)}"}

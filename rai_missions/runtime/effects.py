# SPDX-License-Identifier: Apache-2.0
"""Carries out what steps ask for: goals, calls, messages, questions, handovers; and turns what comes back into events.

Rule: it never waits and never judges. Each thing that comes back carries the number of what it answers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rai_missions.connectors.connector import Connector, HostsActions, Reply, SupportsPreconnect
from rai_missions.engine.decision import Answerer, Question
from rai_missions.engine.step import (
    Ask,
    CallService,
    CancelGoal,
    Effect,
    Handover,
    LogLine,
    PublishMessage,
    SayAloud,
    StartBehaviour,
    StartGoal,
    StopBehaviour,
    Withdraw,
)
from rai_missions.errors import MissionError, in_words, raised_text
from rai_missions.event import Event, EventKind
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, plain
from rai_missions.profile.endpoints import asked
from rai_missions.redaction import cut, cut_repr, logger
from rai_missions.runtime.behaviours import Behaviours
from rai_missions.runtime.cancels import outcome_of
from rai_missions.runtime.control_handover import Handovers
from rai_missions.runtime.goals import Goals, journaled
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.readings import SourceState
from rai_missions.runtime.rivalry import Rivalry
from rai_missions.runtime.robot_listener import RobotListener
from rai_missions.runtime.scheduler import Scheduler

__all__ = ("MISSION_LINE", "EffectExecutor")

log = logger(__name__)

MISSION_LINE = "mission_line"
"""Field of a log record whose text is in the step as well."""
LONGEST_ANSWER = 1_000_000
"""Characters; a journal keeps every answer."""


class EffectExecutor:
    """The hands of a run.

    Args:
        mission: Whose effects are carried out.
        run: The run's identity; goal ids are derived from it.
        robot: The profile; a start or call that is not in it is rejected.
        connector: How the robot is reached.
        answerers: Who answers questions, by name.
        scheduler: Where events go, and what is done when.
        control: Who holds control.
        note: Has a sentence written into the journal.
    """

    def __init__(
        self,
        mission: Mission,
        *,
        run: str,
        robot: Robot,
        connector: Connector | None,
        answerers: Mapping[str, Answerer],
        scheduler: Scheduler,
        control: Control,
        note: Callable[[str], None],
    ) -> None:
        self._robot, self._connector, self._answerers = robot, connector, answerers
        self.run = run
        self._scheduler, self._control = scheduler, control
        self.rivalry = Rivalry(robot, connector, scheduler.wake)
        self._goals = Goals(run, robot, connector, on_event=self._event, later=scheduler.call_later)
        self.is_concluding = False
        """The end of actions that this process executes is waited for."""
        self._open: dict[int, str] = {}
        self.handovers = Handovers(robot, connector, scheduler, self._lose_handover)
        self._behaviours = Behaviours(mission.behaviours(), scheduler)
        self._listener = RobotListener(robot, connector, scheduler, mission.blackboard, note)
        self._perform: Mapping[type, Callable[[Any], None]] = {
            StartGoal: self._start,
            CancelGoal: self._cancel,
            CallService: self._call,
            PublishMessage: self._publish,
            Ask: self._ask,
            Withdraw: self._withdraw,
            Handover: self._request_control,
            StartBehaviour: self._behaviours.start,
            StopBehaviour: self._behaviours.stop,
            SayAloud: self._speak,
            LogLine: lambda effect: log.info("%s", effect.text, extra={MISSION_LINE: True}),
        }

    @property
    def holder(self) -> str | None:
        """Who holds control, as the robot reports it; empty if it has yet to, None if it never will."""
        return self._listener.holder

    def source(self, key: str) -> SourceState:
        """What is known of the source of a robot key."""
        return self._listener.source(key)

    @property
    def thinking(self) -> bool:
        """A question has no answer yet: a model or a person thinks, who needs real time."""
        return bool(self._open)

    def open(self) -> None:
        """Start to listen to the robot, and have those found who will be asked."""
        self._expect()
        self._listener.open()
        self.handovers.open()

    def _expect(self) -> None:
        connector: object = self._connector
        if isinstance(connector, SupportsPreconnect):
            entries = asked(self._robot)
            for mode, name, type_name in dict.fromkeys((e.mode, name, e.type) for e in entries for name in e.names):
                with suppress(MissionError):  # reported when it is used
                    connector.expect(mode, name, type_name)

    def close(self) -> None:
        """Stop listening, and take back every question."""
        self._listener.close()
        self._goals.close()
        self._behaviours.close()
        for number in list(self._open):
            self._withdraw(Withdraw(number))

    def begin(self) -> None:
        """The mission starts."""
        self._listener.begin()

    @property
    def hosts_actions(self) -> bool:
        """The robot's actions are executed by this process."""
        return isinstance(self._connector, HostsActions)

    def conclude(self) -> None:
        """The mission is over: actions that this process executes may have to be waited for."""
        connector: object = self._connector
        if isinstance(connector, HostsActions):
            self.is_concluding = True
            connector.conclude(lambda: self._scheduler.call_soon(self._concluded))

    def _concluded(self) -> None:
        self.is_concluding = False

    def perform(self, effects: tuple[Effect, ...]) -> None:
        """Carry out the effects of a step, in order; what fails comes back as an event and does not stop the rest."""
        for effect in effects:
            self._guarded(effect, partial(self._perform[type(effect)], effect))

    def leave(self, effects: tuple[Effect, ...], why: str) -> None:
        """Carry out only what ends something; all else has failed."""
        for effect in effects:
            if isinstance(effect, CancelGoal | Withdraw | StopBehaviour):
                self.perform((effect,))
            else:
                self._failed(effect, why)

    def _guarded(self, effect: Effect, do: Callable[[], None]) -> None:
        try:
            do()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a connector is not trusted to behave
            why = in_words(error) if isinstance(error, MissionError) else raised_text(error)
            log.warning("not carried out: %.200s: %s", effect, why)
            self._failed(effect, why)

    def _failed(self, effect: Effect, why: str) -> None:
        if isinstance(effect, StartGoal):
            self._goals.give_up(effect.number, why)
        elif isinstance(effect, CallService):
            self._event("result", "unavailable", effect.number, {"why": why})
        elif isinstance(effect, StartBehaviour):
            self._event("behaviour", "behaviour", effect.number, {"status": "failure", "why": why})

    def stop_everything(self) -> None:
        """End every goal that may still run, also those that were never accepted."""
        self.perform(self._goals.cut_off())

    def resume(self, under: InFlight, awaited: frozenset[int], wanted: frozenset[str], *, fresh: bool) -> None:
        """Continue with what an earlier process had under way, but for questions.

        If it is not known whether an effect happened, and it may not be repeated, the event `uncertain` is raised.

        Args:
            under: What its journal leaves open.
            awaited: The numbers that the mission still waits for.
            wanted: Who must have control for what the mission waits with.
            fresh: The surroundings know of nothing that was done: a simulated world that starts again.
        """
        self._listener.resume()
        for number, effect in under.open.items():
            if number in awaited and not isinstance(effect, Ask):
                self._guarded(effect, partial(self._continue, effect, under, fresh=fresh))
                if number in under.canceled and isinstance(effect, StartGoal):
                    self.perform((CancelGoal(number, effect.action),))
        for unsure in under.unconfirmed:
            if isinstance(unsure, PublishMessage):
                self._guarded(unsure, partial(self._publish_again, unsure, fresh=fresh))
            elif isinstance(unsure, SayAloud):
                self.perform((unsure,))
        if under.handover is not None and under.handover.to in wanted:
            self.perform((under.handover,))

    def ask_again(self, under: InFlight, questions: Iterable[Question]) -> None:
        """Ask what an earlier process had asked and the mission still waits for.

        Args:
            under: What its journal leaves open.
            questions: Those that are open, each with the time that it has by now.
        """
        self.perform(tuple(Ask(each) for each in questions if isinstance(under.open.get(each.number), Ask)))

    def _continue(self, effect: Effect, under: InFlight, *, fresh: bool) -> None:
        if fresh:
            self._perform[type(effect)](effect)
        elif isinstance(effect, StartGoal):
            self._listener.continue_action(effect.action)
            known = effect.number in under.accepted or effect.number in under.canceled
            outcome = "failed" if known else "rejected"
            doubt = partial(self._doubt, "action", effect.action, effect.number, outcome)
            self._goals.resume(effect, accepted=known, on_doubt=doubt)
        elif isinstance(effect, CallService) and not self._may_repeat(effect):
            self._doubt("call", effect.service, effect.number, "failed")
        else:
            self._perform[type(effect)](effect)

    def _may_repeat(self, effect: CallService) -> bool:
        entry = self._robot.services.get(effect.service)
        return entry is None or entry.repeat

    def _publish_again(self, effect: PublishMessage, *, fresh: bool) -> None:
        if fresh or not self.is_doubtful(effect):
            self._publish(effect)
        else:
            self._event("doubt", "uncertain", 0, {"what": "publish", "name": effect.topic})

    def is_doubtful(self, effect: Effect) -> bool:
        """Whether an effect is a message that may not be published twice."""
        entry = self._robot.topics.get(effect.topic) if isinstance(effect, PublishMessage) else None
        return entry is not None and not entry.repeat

    def _doubt(self, what: str, name: str, number: int, outcome: str) -> None:
        """Report that an effect may or may not have been done before the run was killed."""
        self._event("doubt", "uncertain", 0, {"what": what, "name": name})
        why = f"the run was killed, and it is not known whether '{name}' was done"
        self._event("result", outcome, number, {"why": why})

    def _lose_call(self, effect: CallService, why: str) -> None:
        """Report a call that may have been done, whose server is gone: as after a kill, without calling again."""
        if not self._may_repeat(effect):
            self._event("doubt", "uncertain", 0, {"what": "call", "name": effect.service})
        self._event("result", "failed", effect.number, {"why": f"{why}; it may have been done"})

    def answered(self, number: int) -> None:
        """A question has its answer: no one else need think about it."""
        if number in self._open:
            self._withdraw(Withdraw(number))

    def _event(self, kind: EventKind, name: str, number: int, data: Mapping[str, Any]) -> None:
        self._scheduler.post(Event(name, self._scheduler.now(), dict(data), kind, number))

    # -- goals, calls and messages ------------------------------------------------------------------------------------

    def _start(self, effect: StartGoal) -> None:
        self._listener.begin_action(effect.action)
        self._goals.start(effect)

    def _cancel(self, effect: CancelGoal) -> None:
        self._listener.end_action(effect.action)
        self._goals.cancel(effect)

    def _call(self, effect: CallService) -> None:
        entry = self._robot.services.get(effect.service)
        if entry is None or self._connector is None:
            self._event("result", "unavailable", effect.number, {"why": f"no robot has a service '{effect.service}'"})
            return

        def answered(reply: Reply) -> None:
            outcome, why = outcome_of(entry, reply)
            if reply.may_have_arrived:
                self._lose_call(effect, why)
                return
            self._event("result", outcome, effect.number, {**journaled(reply.data), **({"why": why} if why else {})})

        request = entry.request_of(effect.request)
        call = partial(
            self._connector.call, entry.service, entry.type, request, on_reply=answered, timeout_s=effect.timeout_s
        )
        self._goals.cancels.behind(lambda: self._guarded(effect, call))

    def _publish(self, effect: PublishMessage) -> None:
        entry = self._robot.topics.get(effect.topic)
        if entry is None or self._connector is None:
            log.warning("no robot has a topic '%s'; its message is lost", effect.topic)
            return
        self._connector.publish(entry.topic, entry.type, entry.message_of(effect.message))

    def _speak(self, effect: SayAloud) -> None:
        if "say" in self._robot.topics:
            self._publish(PublishMessage("say", {"data": effect.text}))
        log.info("speaks: %s", effect.text, extra={MISSION_LINE: True})

    # -- questions and control ------------------------------------------------------------------------------------

    def can_ask(self, answerer: str) -> bool:
        """Whether there is one of that name."""
        return answerer in self._answerers

    def _ask(self, effect: Ask) -> None:
        question = effect.question
        answerer = self._answerers.get(question.asked)

        def answer(data: Mapping[str, Any]) -> None:
            late = {} if self._open.pop(question.number, None) is not None else {"late": True}
            self._event("proposal", question.asked, question.number, {**_answer_of(data), **late})

        self._open[question.number] = question.asked
        if answerer is None:
            answer({"absent": f"there is no answerer '{question.asked}'"})
            return
        try:
            answerer.ask(question.apart(), answer)
        except Exception as error:  # an answerer is not trusted to behave
            log.exception("'%s' failed to take question %d", question.asked, question.number)
            answer({"failed": raised_text(error)})

    def _withdraw(self, effect: Withdraw) -> None:
        asked = self._open.pop(effect.number, None)
        answerer = self._answerers.get(asked) if asked is not None else None
        if answerer is not None:
            try:
                answerer.withdraw(effect.number)
            except Exception:
                log.exception("'%s' failed to give question %d back", asked, effect.number)

    def _request_control(self, effect: Handover) -> None:
        if why := self._control.request(effect.to, "software"):
            log.warning("control does not go to %s: %s", effect.to, why)
        else:
            self.handovers.hand_over(effect.to, "mission")

    def _lose_handover(self, to: str, is_refused: bool) -> None:
        """A handover does not come; where the robot refuses it, the operator keeps control and the mission waits.

        Args:
            to: Who should have had control.
            is_refused: The robot's reply was that it does not hand over.
        """

        def lose() -> None:
            self._control.give_up(to)
            if is_refused and to != "operator" and self.holder == self._control.holder == "operator":
                self._event("control", "operator", 0, {"by": "operator", "role": "operator"})

        self._scheduler.call_soon(lose)


def _answer_of(data: Any) -> Mapping[str, Any]:
    """An answer as a journal can hold it; what is no answer has failed."""
    try:
        answer = plain(data)
        if isinstance(answer, Mapping) and len(str(answer)) <= LONGEST_ANSWER:
            return answer
        why = "it is too long" if isinstance(answer, Mapping) else f"{cut_repr(data, 60)} is no answer"
    except Exception as error:  # noqa: BLE001 - an answerer is not trusted to behave
        why = cut(error, 300)
    return {"failed": f"the reply is no answer: {why}"}

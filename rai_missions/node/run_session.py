# SPDX-License-Identifier: Apache-2.0
"""One run, the orders that it was given, and what became of each.

Rule: an order is an event in the run's mailbox like any other; its reply is what the Step made of it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import NamedTuple

from rai_missions.engine.decision import Proposal, Question, malformed
from rai_missions.engine.modes import Mode
from rai_missions.engine.step import Ask, Step
from rai_missions.errors import suggestion
from rai_missions.event import Event
from rai_missions.keys import stale_at
from rai_missions.node.order import ClientOrder, OrderReply, ReplyCallback, lasts, overdue
from rai_missions.node.status_message import OpenQuestion
from rai_missions.profile import Robot, commanded_names
from rai_missions.redaction import Redaction, cut, logger
from rai_missions.runtime.lifecycle import Status, status_of
from rai_missions.runtime.readings import SourceState
from rai_missions.runtime.requests import OVER, RunRequests, refusal_text
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner
from rai_missions.states.control import HOLDERS

__all__ = ("RunSession",)

MOST_WAITING = 256
log = logger(__name__)

COMMANDS = {"pause": "pause", "resume": "resume", "cancel": "cancel", "e_stop": "kill"}
"""Order → the engine's command."""
ALWAYS = ("cancel", "e_stop")
"""Taken where the node is not active, too."""


class UntakenOrder(NamedTuple):
    """An order that the run has yet to take."""

    order: ClientOrder
    on_reply: ReplyCallback

    def take(self, step: Step) -> None:
        self.on_reply(_reply_of(self.order, step))

    def drop(self, waited_s: float) -> None:
        self.on_reply(overdue(self.order, waited_s))

    def end(self) -> None:
        self.on_reply(OrderReply(False, OVER, self.order.id))


class RunSession:
    """A run from its beginning to its end, as those outside see it.

    Args:
        runner: The run; not begun yet.
        robot: The profile, which lists the events that may be posted.
    """

    def __init__(self, runner: Runner, robot: Robot | None) -> None:
        self.runner, self._robot = runner, robot
        self.status: Status | None = status_of(runner.view) if runner.view.seq else None
        """The run's latest; None before its first step."""
        self.result: Result | None = None
        self.error = ""
        """Why it broke off, if it did."""
        self._lock = threading.Lock()
        self.requests: RunRequests[UntakenOrder] = RunRequests(runner)
        self._asked = {each.number: each for each in runner.view.questions}
        self.seq = runner.view.seq
        """The last step that the status and what is asked are of, or of a later one."""
        self._thread: threading.Thread | None = None
        self._is_news = False

    @property
    def is_over(self) -> bool:
        return self.requests.is_over

    @property
    def mode(self) -> Mode:
        """The run's mode; one that broke off has failed."""
        if self.is_over:
            return self.result.outcome if self.result is not None else "failed"
        return self.status.mode if self.status is not None else self.runner.view.mode

    @property
    def is_here(self) -> bool:
        """The caller is the run's own thread."""
        return threading.current_thread() is self._thread

    def questions(self) -> tuple[OpenQuestion, ...]:
        """What is asked now, the oldest first, with the time left, which stops in a pause and while it is held."""
        with self._lock:
            asked = () if self.is_over else tuple(self._asked.values())
        return tuple(OpenQuestion(question, max(0.0, question.until - self._now_for(question))) for question in asked)

    def _now_for(self, question: Question) -> float:
        """Now, or when the time of its state was stopped: by a pause, or by the operator who took control."""
        since = self.runner.view.still_since(question.owner.partition("#")[0])
        return self.runner.view.now() if since is None else since

    def stale(self) -> tuple[str, ...]:
        """The robot's keys that are older than they may be."""
        if self.is_over or self.mode not in ("running", "paused", "canceling"):
            return ()
        now, board = self.runner.view.now(), self.runner.view.board
        known = [(name, key, board.get(name)) for name, key in self.runner.mission.keys_of("robot").items()]
        return tuple(name for name, key, entry in known if entry is not None and stale_at(key, entry) <= now)

    def sources(self) -> Mapping[str, SourceState]:
        """The robot's keys → what is known of the readings of their sources."""
        keys = {} if self.is_over else self.runner.mission.keys_of("robot")
        return {name: self.runner.view.source(name) for name in keys}

    @cached_property
    def commands(self) -> frozenset[str]:
        """The robot's names for what the mission has it do."""
        return commanded_names(self.runner.mission, self._robot) if self._robot is not None else frozenset()

    # -- after it -------------------------------------------------------------------------------------------------

    @property
    def is_locked(self) -> bool:
        """Whether the run is over and no one has control since: the next one begins only once an operator has taken it.

        Where the robot reports who holds control, it does so to the next run as well, and nothing is kept here.
        """
        is_reported = self._robot is not None and self._robot.holder is not None
        return self.is_over and not is_reported and self.status is not None and self.status.control == "nobody"

    def unlock(self, order: ClientOrder) -> OrderReply:
        """An operator takes the control that no one has had since the run."""
        if order.to != "operator" or order.role != "operator":
            return OrderReply(False, "control is with 'nobody' since the stop; an operator takes it first", order.id)
        if self.status is not None:
            self.status = self.status._replace(control="operator")
        return OrderReply(True, "", order.id)

    # -- orders ---------------------------------------------------------------------------------------------------

    def submit(self, order: ClientOrder, on_reply: ReplyCallback) -> None:
        """Give the run an order; `on_reply` receives once what became of it, from any thread."""
        why, on_reply = self._refuses(order), _harmless(on_reply)
        if why:
            on_reply(OrderReply(False, why, order.id))
        else:
            self._post(order, on_reply)

    def _post(self, order: ClientOrder, on_reply: ReplyCallback) -> None:
        if len(self.requests) >= MOST_WAITING and order.command != "e_stop":
            on_reply(OrderReply(False, "too many orders wait already; ask again", order.id))
            return
        request = self.requests.add(UntakenOrder(order, on_reply), lasts=lasts(order))
        if not request:
            return
        if order.command == "e_stop":
            self.runner.post_urgent(self._event(order, request))
        elif order.command == "control":
            self.runner.call_soon(lambda: self._hand_over(request))
        else:
            self.runner.post(self._event(order, request))

    def _hand_over(self, request: str) -> None:
        """Ask for control as an order wants it, on the run's thread."""
        waiting = self.requests.taken(request)
        if waiting is not None:
            why = self.runner.control(waiting.order.to, _signed(waiting.order), waiting.order.role)
            waiting.on_reply(OrderReply(not why, why, waiting.order.id))

    def _event(self, order: ClientOrder, request: str) -> Event:
        at, origin = self.runner.view.now(), {"by": order.by, "request": request}
        if order.command == "post":
            return Event(order.event, at, dict(order.data) | origin)
        origin["role"] = order.role
        if order.command == "answer":
            answer = {"option": order.option, "parameters": dict(order.parameters)}
            return Event("operator", at, answer | origin, "proposal", order.question)
        return Event(COMMANDS[order.command], at, origin, "command")

    def _refuses(self, order: ClientOrder) -> str:
        """Why an order is not put to the engine at all."""
        if order.role == "viewer":
            return "a viewer looks, and orders nothing"
        if order.command not in ALWAYS and self.runner.closed:
            return self.runner.closed
        if order.command == "control" and order.to not in HOLDERS:
            return f"no one called '{cut(order.to, 60)}' can hold control{suggestion(order.to, HOLDERS)}"
        if order.command == "control":
            return self.runner.view.refuses_control(order.to, order.role)
        if order.command == "post":
            events = self._robot.events if self._robot is not None else {}
            posted = [name for name, event in events.items() if event.posted]
            if order.event not in posted:
                near = suggestion(order.event, posted)
                return f"the robot profile lists no posted event '{cut(order.event, 60)}'{near}"
        if order.command == "answer":
            return self._refuses_answer(order)
        return ""

    def _refuses_answer(self, order: ClientOrder) -> str:
        """Why an answer is none to its question: a slip of a person, which costs no attempt."""
        number = order.question
        if order.run and order.run != self.runner.run_id:
            return f"question {number} was asked in another run, {cut(order.run, 60)}; this is run {self.runner.run_id}"
        with self._lock:
            question, still = self._asked.get(number), ", ".join(map(str, self._asked))
        if question is None:
            return f"question {number} is not open; open: {still or 'none'}"
        state = self.runner.mission.state(question.state)
        if question.asked != "operator" and not any("operator" in each.ask for each in state.decisions().values()):
            return f"question {number} is not for the operator; it is asked of {question.asked}"
        return malformed(question, Proposal(order.option, order.parameters))

    # -- the run --------------------------------------------------------------------------------------------------

    def run(self, by: Callable[[], Result] | None = None) -> Result:
        """Run to the end on this thread, by `by` where another object has the run in hand; raises what that raises."""
        self._thread = threading.current_thread()
        try:
            self.result = by() if by is not None else self.runner.run()
        except BaseException as error:
            self.error = Redaction().text(f"{error}") or type(error).__name__
            raise
        else:
            return self.result
        finally:
            self.requests.close()

    def follow(self, status: Status) -> None:
        """The run's status has changed."""
        self.status, self._is_news = status, True

    def step(self, step: Step) -> bool:
        """Follow a step, on the run's thread; whether the status or what is asked has changed with it."""
        is_news, self._is_news = self._is_news, False
        is_news |= self._follow_questions(step)
        self.seq = step.seq  # at last: who reads it first finds all else at least as new
        return is_news

    def receive(self, step: Step) -> None:
        """Report to the client of an order what this step did."""
        self.requests.step(step)

    def _follow_questions(self, step: Step) -> bool:
        if not self._asked and not any(isinstance(effect, Ask) for effect in step.effects):
            return False
        before = tuple(self._asked)
        with self._lock:
            self._asked = {each.number: each for each in self.runner.view.questions}
        return before != tuple(self._asked)


def _harmless(on_reply: ReplyCallback) -> ReplyCallback:
    """A client that cannot be reached any more, by a connection that is gone, does no harm to the run."""

    def reply(reply: OrderReply) -> None:
        try:
            on_reply(reply)
        except Exception:
            log.exception("what became of order '%s' could not be reported", reply.id)

    return reply


def _signed(order: ClientOrder) -> str:
    """Who asks for control, as people read it: an operator's name follows that word."""
    is_signed = order.role != "operator" or order.by == "operator" or order.by.startswith("operator ")
    return order.by if is_signed else f"operator ({order.by})"


def _reply_of(order: ClientOrder, step: Step) -> OrderReply:
    if why := refusal_text(step):
        return OrderReply(False, why, order.id)
    if order.command == "answer" and step.kept:
        return OrderReply(True, "it is judged once the run is resumed, or control is given back", order.id)
    remark = "nothing in the mission reacts to it now" if order.command == "post" and step.ignored else ""
    return OrderReply(True, remark, order.id)

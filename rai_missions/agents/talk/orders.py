# SPDX-License-Identifier: Apache-2.0
"""Carries the orders of a dialogue to a run, and reports what the run made of each.

Rule: an order is an event in the run's mailbox like any other, with its sentence and role in it; what became of it is
read from the Step that took it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rai_missions.conversation import Order
from rai_missions.conversation.inputs import OrderResult, RefusalKind, by_words
from rai_missions.engine.decision import Offer
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.runtime.requests import GOOD_FOR_S, OVER, RunRequests, refusal_text
from rai_missions.runtime.runner import Runner

__all__ = ("OnOrderEnd", "RunOrders", "refusal_kind")

OnOrderEnd = Callable[[OrderResult], None]
"""Receives once, from any thread, what became of an order."""
CLOSED = "its question is no longer asked"
LASTING = frozenset({"stop", "cancel"})
"""Orders that are carried out however late the run takes them."""


class GivenOrder(NamedTuple):
    """An order that the run has yet to take, or an answer that it has yet to judge."""

    order: Order
    on_end: OnOrderEnd
    offer: Offer | None = None
    """The option that it answers with, where its question is open."""

    def take(self, step: Step) -> None:
        if not _is_kept(step):
            why = refusal_text(step)
            self.on_end(OrderResult(why, refusal_kind(step, self._judged_kind) if why else ""))

    def judge(self, step: Step, *, is_open: bool) -> bool:
        """Look whether a step has judged it, once it was kept; its question may have been closed without that."""
        question = self.order.question
        verdict = next((each for each in step.verdicts if each.number == question and each.kind != "fallback"), None)
        if verdict is None and is_open:
            return False
        if verdict is not None and verdict.accepted:
            self.on_end(OrderResult())
        elif verdict is not None and verdict.kind == "proposal" and verdict.note is not None:
            self.on_end(OrderResult(step.notes[verdict.note], self._judged_kind))
        else:
            self.on_end(OrderResult(CLOSED, "stale"))
        return True

    @property
    def _judged_kind(self) -> RefusalKind:
        """What was judged and does not count: the values of the option, or the option."""
        schema = self.offer.parameters if self.offer is not None else None
        return "values" if schema and parameter_faults(schema, self.order.parameters) else "judged"

    def drop(self, waited_s: float) -> None:
        self.on_end(OrderResult(f"the run did not get to it within {GOOD_FOR_S:g} s, and it was dropped", "late"))

    def end(self) -> None:
        self.on_end(OrderResult(OVER, "ended"))


def refusal_kind(step: Step, judged: RefusalKind = "judged") -> RefusalKind:
    """The kind of what a step refused; that of an answer which was judged is given."""
    if step.event.kind != "proposal" or step.refusal:
        return step.refusal or "other"
    return judged if step.verdict is not None and step.verdict.kind == "proposal" else "stale"


def _is_kept(step: Step) -> bool:
    """Whether the answer that a step took waits for the end of a pause, or for the hand-back."""
    return step.kept and step.event.kind == "proposal" and step.verdict is None


class RunOrders:
    """The orders to one run.

    Args:
        runner: The run.
    """

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._requests: RunRequests[GivenOrder] = RunRequests(runner)
        self._kept: dict[int, GivenOrder] = {}
        """Question → the answer that is yet to be judged."""

    @property
    def earlier(self) -> tuple[Order, ...]:
        """The answers of a conversation that wait in a run which is resumed; their numbers are below zero."""
        waiting = (each for each in self._runner.view.waiting_answers if "role" in each.data)
        return tuple(_order_of(each) for each in waiting)

    def await_judgment(self, answer: Order, on_end: OnOrderEnd) -> None:
        """Report what becomes of one of the `earlier`; before the run is resumed."""
        self._kept[answer.question] = self._given(answer, on_end)

    def perform(self, order: Order, on_end: OnOrderEnd) -> None:
        """Carry out an order; never waits."""
        if self._runner.closed and order.name not in LASTING:
            on_end(OrderResult(self._runner.closed, "inactive"))
            return
        if order.name == "start":
            on_end(OrderResult.of_start(self._runner.start(order.arguments)))
            return
        request = self._requests.add(self._given(order, on_end), lasts=order.name in LASTING)
        if not request:
            return
        event = self._event(order, request)
        if event.name == "kill":
            self._runner.post_urgent(event)
        else:
            self._runner.post(event)

    def _given(self, order: Order, on_end: OnOrderEnd) -> GivenOrder:
        asked = next((each for each in self._runner.view.questions if each.number == order.question), None)
        options = asked.options if asked is not None else ()
        return GivenOrder(order, on_end, next((offer for offer in options if offer.name == order.option), None))

    def step(self, step: Step) -> None:
        """Report what became of the order that a step took, and of an answer that was kept; on the run's thread."""
        if self._kept:
            self._judge_kept(step)
        taken = self._requests.step(step)
        if taken is not None and _is_kept(step):
            self._kept[taken.order.question] = taken

    def _judge_kept(self, step: Step) -> None:
        open_now = {each.number for each in self._runner.view.questions}
        for number, each in tuple(self._kept.items()):
            if each.judge(step, is_open=number in open_now):
                del self._kept[number]

    def close(self) -> None:
        """The run is over: what it has not taken, or judged, is not carried out."""
        self._requests.close()
        while self._kept:
            self._kept.popitem()[1].end()

    def _event(self, order: Order, request: str) -> Event:
        at = self._runner.view.now()
        data: dict[str, Any] = {
            "by": by_words(order.role, order.author, order.channel),
            "role": order.role,
            "request": request,
        }
        if order.name == "answer":
            data |= {"option": order.option, "parameters": dict(order.parameters)}
            return Event("operator", at, data, "proposal", order.question)
        return Event(self._command(order), at, data, "command")

    def _command(self, order: Order) -> str:
        """A mission that is being canceled may move still, and has no pause: there a stop is the e-stop."""
        return "kill" if order.name == "stop" and self._runner.view.mode == "canceling" else order.name


def _order_of(answer: Event) -> Order:
    """The order that gave this answer; who gave it may be met at any door."""
    data = answer.data
    return Order(
        -answer.number,
        "answer",
        data["role"],
        "",
        "",
        question=answer.number,
        option=data["option"],
        parameters=data["parameters"],
    )

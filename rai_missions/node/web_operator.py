# SPDX-License-Identifier: Apache-2.0
"""The operator at a page: takes the orders that it sends, and holds questions open for it.

Rule: a page may do what an operator may, and nothing else; what is refused before the run is notified of it is noted
as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.decision import Answerer, Question
from rai_missions.node.order import ClientOrder, OrderReply, read_order
from rai_missions.node.run_session import RunSession
from rai_missions.redaction import cut

__all__ = ("WebOperator", "WebOrders")

ACTS = ("pause", "resume", "cancel", "e_stop", "control", "answer")
PAGE = "operator (page)"
PageReply = Callable[[bool, str], None]
"""Receives once, from any thread, whether an order succeeded, and why."""


class WebOrders:
    """Carries a page's orders to a run.

    Args:
        session: The run.
        answers: Whether the page may answer as the operator.
        note: Writes into the run's journal.
        on_late_stop: Receives who gave an e-stop that found the run over: none is to follow it.
    """

    def __init__(
        self,
        session: RunSession,
        *,
        answers: bool,
        note: Callable[[str], object],
        on_late_stop: Callable[[str], object] = lambda by: None,
    ) -> None:
        self._session, self._answers, self._note = session, answers, note
        self._on_late_stop = on_late_stop

    def submit(self, text: str, on_reply: PageReply) -> None:
        """Take an order, as JSON that anybody may have written; never waits."""
        order = read_order(text)
        if isinstance(order, OrderReply):
            on_reply(False, order.why)
            return
        order = from_page(order)
        why = self._refuses(order)
        if why:
            self._reply(order, on_reply, OrderReply(False, why), has_arrived=False)
        else:
            self._session.submit(
                order, lambda reply: self._reply(order, on_reply, reply, has_arrived=_has_arrived(order, reply))
            )

    def _refuses(self, order: ClientOrder) -> str:
        if order.command not in ACTS:
            return f"a page cannot '{order.command}'; it can {', '.join(ACTS)}"
        if order.command != "answer":
            return ""
        if not self._answers:
            return "no one answers as the operator in this run; it was begun with --no-operator"
        open_ = {each.question.number: each.question for each in self._session.questions()}
        question = open_.get(order.question)
        if question is None:
            return f"question {order.question} is not open; open: {', '.join(map(str, open_)) or 'none'}"
        if question.asked != "operator":
            return f"question {order.question} is not for the operator; {question.asked} is asked"
        return ""

    def _reply(self, order: ClientOrder, on_reply: PageReply, reply: OrderReply, *, has_arrived: bool) -> None:
        """What the engine has received is in the journal with its answer; the rest is noted here."""
        if order.command == "e_stop" and self._session.is_over:
            self._on_late_stop(order.by)
        if not reply.success and not has_arrived:
            what = f"{order.command} {order.to or order.option}".strip()
            try:
                self._note(f"refused: {cut(what, 100)} by {order.by}: {cut(reply.why, 300)}")
            except Exception:  # noqa: BLE001 - the engine itself finds out that the journal is lost
                pass
        on_reply(reply.success, reply.why)


def _has_arrived(order: ClientOrder, reply: OrderReply) -> bool:
    """The engine has taken it as an event."""
    return order.command != "control" and not reply.dropped


def from_page(order: ClientOrder) -> ClientOrder:
    """Anyone who comes with the page's token is the operator, whatever the name."""
    is_fine = order.by == "operator" or order.by.startswith("operator ")
    by = PAGE if order.by == "operator" else order.by if is_fine else f"operator {order.by} (page)"
    return order._replace(by=by, role="operator")


class WebOperator:
    """Holds a question open for the page, and for the terminal too where there is one; the first answer counts.

    Args:
        terminal: The person there.
        watched: Whether an operator looks at the page now.
    """

    def __init__(self, terminal: Answerer | None, watched: Callable[[], bool]) -> None:
        self._terminal, self._watched = terminal, watched

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Ask on the terminal too; who passes there leaves it to the page, if someone is at it."""
        if self._terminal is None:
            return

        def receive(data: Mapping[str, Any]) -> None:
            if "option" in data or not self._watched():
                answer(data)

        self._terminal.ask(question, receive)

    def withdraw(self, number: int) -> None:
        """Drop a question that was answered, here or elsewhere, or is no longer asked."""
        if self._terminal is not None:
            self._terminal.withdraw(number)

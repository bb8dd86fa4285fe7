# SPDX-License-Identifier: Apache-2.0
"""Where orders arrive: one run at a time, begun when someone asks for it and the node is active.

Rule: nothing here widens what a mission allows. What is let through here, the engine still judges.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.errors import MissionError, raised_text
from rai_missions.node.order import ClientOrder, OrderReply, ReplyCallback, untaken
from rai_missions.node.run_session import RunSession
from rai_missions.redaction import Redaction, logger

__all__ = ("PATIENCE_S", "OrderServer")

log = logger(__name__)

PATIENCE_S = 1.0
"""How long a service waits for the run to take an order."""
LOCKED = 'control is with "nobody" since the stop; first an operator takes it: {"command": "control", "to": "operator"}'


class OrderServer:
    """Takes orders for the runs of a node, one after the other.

    Args:
        begin: Begins a run that an order asks for, and returns it; None where runs are begun elsewhere.
        changed: Called on each change, on any thread.
    """

    def __init__(self, begin: Callable[[ClientOrder], RunSession] | None, changed: Callable[[], None]) -> None:
        self._begin, self._changed = begin, changed
        self._lock = threading.RLock()
        self._when_idle: list[Callable[[], None]] = []
        self.session: RunSession | None = None
        """The run that was begun last."""
        self.closed = "the node is unconfigured; configure and activate it first"
        """Why nothing is begun now; empty where it is."""

    def close(self, why: str) -> None:
        """Begin nothing from now on, and have no door to the run take more than what ends it, for this reason."""
        self.closed = why
        if self.session is not None:
            self.session.runner.closed = why

    def open(self) -> None:
        """Begin what is ordered from now on."""
        self.close("")

    @property
    def live(self) -> RunSession | None:
        """The run that has not ended."""
        session = self.session
        return session if session is not None and not session.is_over else None

    def submit(self, order: ClientOrder, on_reply: ReplyCallback) -> None:
        """Take an order that a door has let in; `on_reply` receives once what became of it, from any thread."""
        if order.command == "start":
            on_reply(self._start(order))
            return
        session, last = self.live, self.session
        if session is None and order.command == "control" and last is not None and last.is_locked:
            on_reply(last.unlock(order))
            self._changed()
        elif session is None:
            on_reply(OrderReply(False, "no mission is running; start one", order.id))
        else:
            session.submit(order, on_reply)

    def ask(self, order: ClientOrder, within_s: float = PATIENCE_S) -> OrderReply:
        """Take an order and wait, for a moment, for what becomes of it."""
        replies: list[OrderReply] = []
        self.settle(order, replies.append, within_s)
        return replies[0] if replies else OrderReply(False, untaken(order), order.id)

    def settle(self, order: ClientOrder, on_reply: ReplyCallback, within_s: float = PATIENCE_S) -> None:
        """Take an order; `on_reply` receives once what became of it: on this thread within a moment, else later."""
        lock, is_answered = threading.Lock(), threading.Event()
        replies: list[OrderReply] = []
        is_late = False

        def receive(reply: OrderReply) -> None:
            with lock:
                replies.append(reply)
            is_answered.set()
            if is_late:
                on_reply(reply)

        self.submit(order, receive)
        session = self.live
        if session is None or not session.is_here:  # a run that asks its own node would wait for itself
            is_answered.wait(within_s)
        with lock:
            is_late = not replies
        if not is_late:
            on_reply(replies[0])

    def attend(self, session: RunSession) -> None:
        """A run is about to begin."""
        with self._lock:
            self.session = session
            session.runner.closed = self.closed
        self._changed()

    def ended(self) -> None:
        """The run is over."""
        self._changed()
        with self._lock:
            waiting, self._when_idle = self._when_idle, []
        for work in waiting:
            work()

    def when_idle(self, work: Callable[[], None]) -> None:
        """Do something once no run is under way; at once where none is."""
        with self._lock:
            if self.live is not None:
                self._when_idle.append(work)
                return
        work()

    def _refuses_start(self) -> str:
        """Why no run may begin now; empty where one may."""
        if (session := self.live) is not None:
            return f"a mission is under way, {session.mode}; cancel it first"
        return self.closed or (LOCKED if self.session is not None and self.session.is_locked else "")

    def _start(self, order: ClientOrder) -> OrderReply:
        with self._lock:
            if self._begin is None:
                only = "this run is the node's only one; run it with --managed to start it again"
                return OrderReply(False, only, order.id)
            if why := self._refuses_start():
                return OrderReply(False, why, order.id)
            try:
                self.session = self._begin(order)
            except (MissionError, OSError) as error:
                return OrderReply(False, Redaction().text(f"{error}"), order.id)
            except Exception as error:
                log.exception("the mission could not be begun")
                return OrderReply(False, Redaction().text(raised_text(error)), order.id)
        self._changed()
        return OrderReply(True, f"run {self.session.runner.run_id}", order.id)

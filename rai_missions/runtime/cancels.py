# SPDX-License-Identifier: Apache-2.0
"""The services that end composed actions, each called before what the mission calls next.

Rule: a robot need not serve two services in the order in which they are called: one that stops it would end what the
other has just begun.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress

from rai_missions.connectors.connector import Connector, Reply
from rai_missions.errors import in_words
from rai_missions.profile import ServiceEntry
from rai_missions.redaction import cut

__all__ = ("Cancels", "outcome_of")

CANCELED_S = 5.0
"""How long other calls wait for the reply of the service that ends a composed action."""
AGAIN_S = 2.0
"""How long after an order without an answer it is sent again."""
UNANSWERED = ("timed_out", "unavailable")
BAD_REPLIES = ("failed", *UNANSWERED)


class Cancels:
    """Orders to end composed actions, each sent again until the robot has answered it.

    Args:
        connector: How the robot is reached.
        later: Has something done after so many seconds, if the run is not over by then.
    """

    def __init__(self, connector: Connector | None, later: Callable[[float, Callable[[], None]], None]) -> None:
        self._connector, self._later = connector, later
        self._lock = threading.Lock()
        self._ending: set[object] = set()
        """Orders that others wait for; there may be two for one action."""
        self._behind: list[Callable[[], None]] = []
        self._orders: dict[int, object] = {}
        """Goal → the last order to end it, while that has no answer."""

    def call(self, number: int, cancel: ServiceEntry, on_end: Callable[[str, str], object]) -> None:
        """Call what ends a composed action; other calls wait for the first reply. Raises what the connector raises.

        Args:
            number: The goal's.
            cancel: The service.
            on_end: Called with the outcome of each call, and why.
        """
        order = object()
        with self._lock:
            self._ending.add(order)
        self._orders[number] = order
        try:
            self._send(number, order, cancel, on_end)
        except (Exception, SystemExit):
            self.drop(number)
            self._let_others_call(order)
            raise

    def _send(self, number: int, order: object, cancel: ServiceEntry, on_end: Callable[[str, str], object]) -> None:
        assert self._connector is not None

        def answered(reply: Reply) -> None:
            outcome, why = outcome_of(cancel, reply)
            if outcome not in UNANSWERED and self._orders.get(number) is order:
                self.drop(number)
            try:
                on_end(outcome, why)
            finally:
                self._let_others_call(order)
            if outcome in UNANSWERED:
                self._later(AGAIN_S, again)

        def again() -> None:
            if self._orders.get(number) is order:
                with suppress(Exception, SystemExit):  # a connector is not trusted to behave
                    self._send(number, order, cancel, on_end)

        self._connector.call(
            cancel.service, cancel.type, cancel.request_of({}), timeout_s=CANCELED_S, on_reply=answered
        )

    def drop(self, number: int) -> None:
        """An order is not sent again: it might end what has begun since."""
        self._orders.pop(number, None)

    def behind(self, call: Callable[[], None]) -> None:
        """Call a service once every composed action that was canceled has had its reply."""
        with self._lock:
            if self._ending:
                self._behind.append(call)
                return
        call()

    def _let_others_call(self, order: object) -> None:
        with self._lock:
            self._ending.discard(order)
            behind, self._behind = (self._behind, []) if not self._ending else ([], self._behind)
        for call in behind:
            call()


def outcome_of(entry: ServiceEntry, reply: Reply) -> tuple[str, str]:
    """How a call ended by what its profile makes of replies, and why it did not succeed; another word is a failure."""
    try:
        good, why = entry.succeeded(reply.outcome, reply.data), reply.why or reply.data.get("message", "")
        outcome = "succeeded" if good else reply.outcome if reply.outcome in BAD_REPLIES else "failed"
    except Exception as error:  # noqa: BLE001 - whatever a server reports, it has answered
        return "failed", f"its reply was not understood: {cut(error, 250)}"
    return outcome, in_words(reply.why if good else why)

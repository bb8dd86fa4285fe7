# SPDX-License-Identifier: Apache-2.0
"""The services that end composed actions, each called before what the mission calls next.

Rule: a robot need not serve two services in the order in which they are called: one that stops it would end what the
other has just begun.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from rai_missions.connectors.connector import Connector, Reply
from rai_missions.errors import in_words
from rai_missions.profile import ServiceEntry
from rai_missions.redaction import cut

__all__ = ("Cancels", "outcome_of")

CANCELED_S = 5.0
"""How long other calls wait for the reply of the service that ends a composed action."""
BAD_REPLIES = ("failed", "timed_out", "unavailable")


class Cancels:
    """Orders to end composed actions.

    Args:
        connector: How the robot is reached.
    """

    def __init__(self, connector: Connector | None) -> None:
        self._connector = connector
        self._lock = threading.Lock()
        self._ending: set[object] = set()
        """Orders that have no answer yet; there may be two for one action."""
        self._behind: list[Callable[[], None]] = []

    def call(self, cancel: ServiceEntry, on_end: Callable[[str, str], object]) -> None:
        """Call what ends a composed action; other calls wait meanwhile. Raises what the connector raises."""
        assert self._connector is not None
        order = object()

        def answered(reply: Reply) -> None:
            try:
                on_end(*outcome_of(cancel, reply))
            finally:
                self._let_others_call(order)

        with self._lock:
            self._ending.add(order)
        try:
            self._connector.call(
                cancel.service, cancel.type, cancel.request_of({}), timeout_s=CANCELED_S, on_reply=answered
            )
        except (Exception, SystemExit):
            self._let_others_call(order)
            raise

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

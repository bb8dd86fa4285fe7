# SPDX-License-Identifier: Apache-2.0
"""The requests whose replies are awaited; each ends once."""

from __future__ import annotations

from collections import OrderedDict

from rai_missions.connectors.connector import OnReply, Reply
from rai_missions.connectors.worker import Worker
from rai_missions.redaction import logger

__all__ = ("PendingCalls",)

log = logger(__name__)

MOST_ANSWERED = 256
"""Calls whose answer came, and by which a second server of the same service is known."""
CLOSES_S = 1.0
"""How long who receives a timeout may hold up the end."""


class PendingCalls:
    """The calls that wait for a reply, by the key that the reply brings back; used from any thread."""

    def __init__(self) -> None:
        self._pending: dict[bytes, tuple[str, OnReply]] = {}
        """Key → the service, and who waits."""
        self._answered: OrderedDict[bytes, str] = OrderedDict()
        self._rivals: set[str] = set()
        self._timeouts = Worker("timeouts of MQTT calls")

    def begin(self, key: bytes, service: str, on_reply: OnReply, timeout_s: float | None) -> None:
        """Await a reply; where a timeout is given, for no longer."""
        self._pending[key] = service, on_reply
        if timeout_s is not None:
            late = Reply("timed_out", {}, f"{service} has not answered within {timeout_s} s")
            self._timeouts.start()  # also after `give_up`
            self._timeouts.after(timeout_s, lambda: self.end(key, late))

    def answered(self, key: bytes, reply: Reply) -> None:
        """A server has answered; where another has before, the two are logged."""
        call = self._pending.get(key)
        if call is None:
            self._second(self._answered.get(key, ""))
            return
        self._answered[key] = call[0]
        while len(self._answered) > MOST_ANSWERED:
            self._answered.popitem(last=False)
        self.end(key, reply)

    def end(self, key: bytes, reply: Reply) -> None:
        """End a call, unless it has ended."""
        call = self._pending.pop(key, None)
        if call is None:
            return
        service, on_reply = call
        try:
            on_reply(reply)
        except Exception:
            log.exception("who called %s failed", service)

    def give_up(self, why: str) -> None:
        """No reply will come to any of them: none of them times out any more, nor does a thread wait for that."""
        self._timeouts.close(CLOSES_S)
        for key in tuple(self._pending):
            self.end(key, Reply("unavailable", {}, why, may_have_arrived=True))

    def _second(self, service: str) -> None:
        """A second answer to one call: two serve it, perhaps two robots of one name."""
        if service and service not in self._rivals:
            self._rivals.add(service)
            log.error(
                "two servers answer %s: each request is carried out twice; give each robot its own names", service
            )

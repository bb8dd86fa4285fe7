# SPDX-License-Identifier: Apache-2.0
"""The requests whose replies are awaited; each ends once."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable

from rai_missions.connectors.connector import OnReply, Reply
from rai_missions.redaction import logger

__all__ = ("PendingCalls",)

log = logger(__name__)

MOST_ANSWERED = 256
"""Calls whose answer came, and by which a second server of the same service is known."""


class PendingCalls:
    """The calls that wait for a reply, by the key that the reply brings back; used from any thread."""

    def __init__(self) -> None:
        self._pending: dict[bytes, _Call] = {}
        self._answered: OrderedDict[bytes, str] = OrderedDict()
        self._rivals: set[str] = set()

    def begin(self, key: bytes, service: str, on_reply: OnReply, timeout_s: float | None) -> None:
        """Await a reply; where a timeout is given, for no longer."""
        late = Reply("timed_out", {}, f"{service} has not answered within {timeout_s} s")
        timer = None if timeout_s is None else _timer(timeout_s, lambda: self.end(key, late))
        self._pending[key] = _Call(service, on_reply, timer)
        if timer is not None:
            timer.start()

    def answered(self, key: bytes, reply: Reply) -> None:
        """A server has answered; where another has before, the two are logged."""
        call = self._pending.get(key)
        if call is None:
            self._second(self._answered.get(key, ""))
            return
        self._answered[key] = call.service
        while len(self._answered) > MOST_ANSWERED:
            self._answered.popitem(last=False)
        self.end(key, reply)

    def end(self, key: bytes, reply: Reply) -> None:
        """End a call, unless it has ended."""
        call = self._pending.pop(key, None)
        if call is None:
            return
        if call.timer is not None:
            call.timer.cancel()
        try:
            call.on_reply(reply)
        except Exception:
            log.exception("who called %s failed", call.service)

    def give_up(self, why: str) -> None:
        """No reply will come to any of them."""
        for key in tuple(self._pending):
            self.end(key, Reply("unavailable", {}, why, may_have_arrived=True))

    def _second(self, service: str) -> None:
        """A second answer to one call: two serve it, perhaps two robots of one name."""
        if service and service not in self._rivals:
            self._rivals.add(service)
            log.error(
                "two servers answer %s: each request is carried out twice; give each robot its own names", service
            )


class _Call:
    """A request that waits for its reply."""

    def __init__(self, service: str, on_reply: OnReply, timer: threading.Timer | None) -> None:
        self.service, self.on_reply, self.timer = service, on_reply, timer


def _timer(seconds: float, do: Callable[[], None]) -> threading.Timer:
    """One that keeps no program from its end."""
    timer = threading.Timer(seconds, do)
    timer.daemon = True
    return timer

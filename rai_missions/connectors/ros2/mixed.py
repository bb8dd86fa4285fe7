# SPDX-License-Identifier: Apache-2.0
"""Two readers of one topic, one for reliable publishers and one for best-effort ones, as if they were one.

Rule: a message of a reliable publisher reaches both readers; the reliable one's copy counts, in its order.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.worker import Work

__all__ = ("MessageSorter",)

Info = Mapping[str, Any]
"""What the middleware knows of a message: rclpy's message info."""
HOLD_S = 0.05
"""How long a message that may be the copy of a reliable one waits for that one."""
REMEMBERED = 1000
"""Messages by which copies are known."""


class MessageSorter:
    """Sorts what two readers receive. On the runtime's thread only.

    Args:
        later: Has something done after so many seconds.
        deliver: Sent each message once.
        reliable: How many reliable publishers the reliable reader is connected to.
    """

    def __init__(
        self, later: Callable[[float, Work], object], deliver: Callable[[Any, Info], None], reliable: Callable[[], int]
    ) -> None:
        self._later, self._deliver, self._reliable = later, deliver, reliable
        self._delivered: OrderedDict[tuple[int, int], None] = OrderedDict()

    def receive_reliably(self, message: Any, info: Info) -> None:
        """The reliable reader has a message."""
        key = _key(info)
        if key is None or key not in self._delivered:
            self._pass_on(message, info, key)

    def receive(self, message: Any, info: Info) -> None:
        """The best-effort reader has a message, of a publisher of either kind."""
        key = _key(info)
        if not self._reliable():
            self._pass_on(message, info, key)
        elif key is not None and key not in self._delivered:

            def decide() -> None:
                if key not in self._delivered:
                    self._pass_on(message, info, key)

            self._later(HOLD_S, decide)

    def _pass_on(self, message: Any, info: Info, key: tuple[int, int] | None) -> None:
        if key is not None:
            self._delivered[key] = None
            if len(self._delivered) > REMEMBERED:
                self._delivered.popitem(last=False)
        self._deliver(message, info)


def _key(info: Info) -> tuple[int, int] | None:
    """What both copies of a message have in common; None where the middleware does not state when it was published."""
    published = int(info.get("source_timestamp") or 0)
    return (published, int(info.get("publication_sequence_number") or 0)) if published else None

# SPDX-License-Identifier: Apache-2.0
"""The live behaviours of a run: ticked every `tick_s` of the run's clock, and heard of when they end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rai_missions.engine.step import StartBehaviour, StopBehaviour
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.states.tree import BehaviourLeaf

if TYPE_CHECKING:
    from rai_missions.trees.python_behaviour import LiveBehaviour

__all__ = ("Behaviours",)


class Behaviours:
    """Ticks what is written in Python.

    Args:
        leaves: Owner → its leaf.
        post: Where the ends go.
        later: Has something done at an instant of the run's clock.
        now: The run's clock.
    """

    def __init__(
        self,
        leaves: Mapping[str, BehaviourLeaf],
        *,
        post: Callable[[Event], None],
        later: Callable[[float, Callable[[], None]], None],
        now: Callable[[], float],
    ) -> None:
        self._leaves, self._post, self._later, self._now = leaves, post, later, now
        self._live: dict[int, LiveBehaviour] = {}

    def start(self, effect: StartBehaviour) -> None:
        """Make a live behaviour, and tick it for the first time now."""
        from rai_missions.trees.python_behaviour import LiveBehaviour  # loads py_trees

        leaf = self._leaves[effect.owner]
        try:
            self._live[effect.number] = LiveBehaviour(leaf)
        except UsageError as error:
            self._end(effect.number, "failure", str(error))
            return
        self._tick(effect.number, leaf.tick_s)

    def stop(self, effect: StopBehaviour) -> None:
        """Interrupt one; one that has ended is left alone."""
        live = self._live.pop(effect.number, None)
        if live is not None:
            live.stop()

    def close(self) -> None:
        """Interrupt all."""
        for number in list(self._live):
            self.stop(StopBehaviour(number))

    def _tick(self, number: int, tick_s: float) -> None:
        live = self._live.get(number)
        if live is None:
            return
        status = live.tick()
        if status == "running":
            self._later(self._now() + tick_s, lambda: self._tick(number, tick_s))
        else:
            self.stop(StopBehaviour(number))
            self._end(number, status)

    def _end(self, number: int, status: str, why: str = "") -> None:
        data = {"status": status, **({"why": why} if why else {})}
        self._post(Event("behaviour", self._now(), data, "behaviour", number))

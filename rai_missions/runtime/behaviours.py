# SPDX-License-Identifier: Apache-2.0
"""The live behaviours of a run: ticked every `tick_s` of the run's clock, and reported when they end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rai_missions.engine.step import StartBehaviour, StopBehaviour
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.runtime.scheduler import Scheduler
from rai_missions.states.tree.behaviour import BehaviourLeaf

if TYPE_CHECKING:
    from rai_missions.trees.python_behaviour import LiveBehaviour

__all__ = ("Behaviours",)


class Behaviours:
    """Ticks what is written in Python.

    Args:
        leaves: Owner → its leaf.
        scheduler: When they are ticked, and where their ends go.
    """

    def __init__(self, leaves: Mapping[str, BehaviourLeaf], scheduler: Scheduler) -> None:
        self._leaves, self._scheduler = leaves, scheduler
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
            self._scheduler.call_at(self._scheduler.now() + tick_s, lambda: self._tick(number, tick_s))
        else:
            self.stop(StopBehaviour(number))
            self._end(number, status)

    def _end(self, number: int, status: str, why: str = "") -> None:
        data = {"status": status, **({"why": why} if why else {})}
        self._scheduler.post(Event("behaviour", self._scheduler.now(), data, "behaviour", number))

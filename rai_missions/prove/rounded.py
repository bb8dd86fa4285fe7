# SPDX-License-Identifier: Apache-2.0
"""A chart that sees at once that it goes round within a step, where the one that runs takes ten thousand microsteps.

Rule: it has gone round only where everything is as it was before, as far as anything can tell.
"""

from __future__ import annotations

from typing import Any

from rai_missions.chart.configuration import Leap
from rai_missions.chart.core import Trigger
from rai_missions.prove.explored import Explored
from rai_missions.prove.remembered import plain, told, told_timer

__all__ = ("Rounded",)

PATIENCE = 32
"""Microsteps after which it looks whether it goes round."""


class Rounded(Explored):
    """A chart that ends a circle of microsteps when it closes."""

    _microsteps = 0
    _passed: frozenset[str] | set[str] = frozenset()

    def _complete(self, trigger: Trigger | None) -> None:
        self._microsteps, self._passed = 0, set()
        super()._complete(trigger)

    def _jump(self, leap: Leap) -> None:
        self._microsteps += 1
        if self._microsteps > PATIENCE and self.outcome is None:
            place = repr((self._here(), leap.move, self._boards()))
            if place in self._passed:
                self._circle()
                return
            self._passed.add(place)  # type: ignore[union-attr]
        super()._jump(leap)

    def _here(self) -> tuple[Any, ...]:
        """What the next microsteps depend on, but for what is known; of many alike, that there are many."""
        goals = self._ledger.goals.values()
        return (
            self._config.key, self.mode, self._holder, len(self.choices.trail),
            [(name, told(state)) for name, state in self._running.items()],
            sorted({(goal.owner, goal.action, goal.phase) for goal in goals}), sorted(set(self._calls.values())),
            sorted({told_timer(key, timer) for key, timer in self._timers.items()}),
            [(each.name, each.source.name if each.source else "", str(each.data)) for each in self._internal],
            [node.name for node in self._starting], sorted(self._memory.items()), sorted(self._pending),
            str(sorted(self._rounds.items())), sorted(self.view.held.items()), sorted(self.view.entered.items()),
            sorted(self._wavering),
        )  # fmt: skip

    def _boards(self) -> list[Any]:
        """What is known; of a counter no more than guards can tell."""
        known = []
        for key, entry in self.board.entries():
            value: Any = None if entry is None else plain(entry[0])
            if key in self._full and entry is not None:
                low, high = self._full[key]
                value = min(max(value, low), high)
            known.append((key, None if key in self._idle else value))
        return sorted(known, key=lambda each: each[0])

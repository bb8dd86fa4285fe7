# SPDX-License-Identifier: Apache-2.0
"""A chart that sees at once that it goes round within a step, where the one that runs takes ten thousand microsteps.

Rule: it has gone round only where everything is as it was before, as far as anything can tell. What becomes of it then
is what the limits of a step make of it, whichever comes first: that of microsteps ends the mission, that of a tree's
rounds has the tree rest, and the mission goes on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.configuration import CompiledStep
from rai_missions.engine.macrostep import MOST_MICROSTEPS
from rai_missions.engine.nodes import CompiledTransition, Node
from rai_missions.engine.state import Trigger
from rai_missions.prove.abstraction import MANY
from rai_missions.prove.activity_key import plain, told, told_timer
from rai_missions.prove.state_key import StateCodec

__all__ = ("Rounded",)

PATIENCE = 32
"""Jumps after which it looks whether it goes round."""
MARGIN = 2
"""Where one limit comes by no more circles before another, the chart goes there by itself."""


class Visit(NamedTuple):
    """How far the limits of a step were when it passed a place."""

    microsteps: int
    rooms: Mapping[str, int]
    """State → how many rounds of its tree can end yet."""


class Rounded(StateCodec):
    """A chart that leaves the circles of a step out when the first one closes."""

    restarted: frozenset[str] = frozenset()
    """The states whose tree has ever begun twice in one step."""
    _jumps = 0
    _microsteps = 0
    """As `_complete` counts them."""
    _passed: dict[str, Visit] | None = None
    """Places that were passed; None where circles are gone to the end."""

    def _complete(self, trigger: Trigger | None) -> None:
        self._jumps, self._microsteps, self._passed = 0, 0, {}
        super()._complete(trigger)

    def _answer(self, trigger: Trigger) -> None:
        self._microsteps += 2  # it was taken from the queue, and is answered
        super()._answer(trigger)

    def _begin_starting(self) -> None:
        self._microsteps += 1
        super()._begin_starting()

    def _begin(self, node: Node) -> None:
        if node.name in self._tree_rounds:
            self.restarted |= {node.name}
        super()._begin(node)

    def _take(self, rows: list[CompiledTransition], trigger: str) -> None:
        self._microsteps += not trigger
        super()._take(rows, trigger)

    def _jump(self, leap: CompiledStep) -> None:
        self._jumps += 1
        if self._jumps > PATIENCE and self.outcome is None and self._passed is not None:
            place = repr((self._here(), leap.move, self._boards()))
            visit = Visit(self._microsteps, {name: rounds.room for name, rounds in self._tree_rounds.items()})
            before = self._passed.setdefault(place, visit)
            if before is not visit and self._is_endless(before, visit):
                self._circle()
                return
        super()._jump(leap)

    def _is_endless(self, before: Visit, now: Visit) -> bool:
        """Whether the circle that has closed is gone until the limit of microsteps; else it is gone almost to the end.

        Where a tree's loops go round in it, their limit may come first.
        """
        self._passed = None
        spent = {name: before.rooms.get(name, room) - room for name, room in now.rooms.items()}
        left = [now.rooms[name] // each for name, each in spent.items() if each]
        circles = (MOST_MICROSTEPS - now.microsteps) // (now.microsteps - before.microsteps)
        if not left or circles + MARGIN < min(left):
            return True
        if min(left) + MARGIN < circles:
            for name, each in spent.items():
                self._tree_rounds[name].skip(max(0, min(left) - 1) * each)
        return False

    def _here(self) -> tuple[Any, ...]:
        """What the next microsteps depend on, but for what is known; of many alike, that there are many."""
        goals = self._ledger.goals.values()
        return (
            self._config.key, self.mode, self._holder, len(self.choices.trail),
            [(name, rounds.spent) for name, rounds in sorted(self._tree_rounds.items())],
            [(name, told(state)) for name, state in self._running.items()],
            _many((goal.owner, goal.action, goal.phase) for goal in goals), _many(self._calls.values()),
            _many(told_timer(key, timer) for key, timer in self._timers.items()),
            [(each.name, each.source.name if each.source else "", str(each.data)) for each in self._internal],
            [node.name for node in self._starting], sorted(self._memory.items()), sorted(self._pending),
            sorted(self._settling), str(sorted(self._rounds.items())), sorted(self.view.held.items()),
            sorted(self.view.entered.items()), sorted(self._wavering), self.view.event, self.view.answer,
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


def _many(things: Iterable[Any]) -> list[tuple[Any, int]]:
    """How many there are of each, as far as that makes a difference."""
    return sorted((each, min(many, MANY)) for each, many in Counter(things).items())

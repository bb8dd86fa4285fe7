# SPDX-License-Identifier: Apache-2.0
"""Readings of which a rule finds out no more than it asks: what is left of one is a set, until another rule asks.

Rule: a guard, or a part of one, that is true or not by one reading alone is asked for its truth. Each truth that a
value of the reading gives is an alternative, and leaves the values that give it, unknown among them.

Why this loses no way of a step, and adds none. What a step does depends on a reading through the answers alone, so it
is the same for all values that are left. Each of them could have been chosen at the first look. A look at the
value itself finds any of those that are left. At rest `AlikeReadings` chooses among them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rai_missions.engine import Chart
from rai_missions.guards.view import Site, Test, Truth, View, as_counted
from rai_missions.keys import Key, Stamped
from rai_missions.prove.abstraction.nondeterminism import OpenBoard
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.analysis.questions import only_key
from rai_missions.prove.analysis.representatives import SCALARS

__all__ = ("AskedReadings", "OpenSite")

Ask = Callable[[View, str, Test, Truth], Truth]
"""Asks for the truth of a guard about one key, of which one value counts."""


class OpenSite(Site):
    """A place where guards about one reading are asked for their truth.

    Args:
        place: As `Site` has it.
        keys: The mission's keys.
        state: As `Site` has it.
        ask: How.
    """

    def __init__(self, place: str, keys: Mapping[str, Key], state: str, ask: Ask) -> None:
        super().__init__(place, keys, state)
        self._ask = ask

    def asked(self, guard: Any, test: Test) -> Test:
        key, counts, ask = only_key(guard), self.counts, self._ask
        if key not in self.keys or self.keys[key].source != "robot" or self.keys[key].type not in SCALARS:
            return test
        return lambda view: ask(view, key, test, counts) if isinstance(view.board, OpenBoard) else test(view)


class AskedReadings:
    """Answers what guards ask of readings.

    Args:
        chart: The mission.
        world: What the surroundings can be.
    """

    def __init__(self, chart: Chart, world: OpenWorld) -> None:
        self._world = world
        self._is_apart = world.is_open or world.doubts
        self._found: dict[tuple[str, Test], dict[Any, Truth]] = {}
        """Key and test → value → what the test finds."""

    def ask(self, view: View, key: str, test: Test, counts: Truth) -> Truth:
        """The truth of a guard; of an open reading those values are left that give it.

        Args:
            view: What the guard sees.
            key: The reading that it is about.
            test: It, compiled.
            counts: Which of its values counts.
        """
        board = view.board
        assert isinstance(board, OpenBoard)
        if self._is_apart:
            return test(view)
        values: Sequence[Any] | None = board.among.get(key)
        if values is None:
            if board.is_known(key) or key not in board.open_keys:
                return test(view)
            values = self._world.distinct(key)
        board.looked.add(key)
        found = self._truths(board, key, test, view, values)
        left: dict[Truth, list[Any]] = {}
        for value in values:
            left.setdefault(as_counted(found[value], counts), []).append(value)
        chosen = left[self._world.choices.pick([*left])]
        board.leave(key, chosen)
        return found[chosen[0]]

    def _truths(self, board: OpenBoard, key: str, test: Test, view: View, values: Sequence[Any]) -> Mapping[Any, Truth]:
        found = self._found.setdefault((key, test), {})
        for value in values:
            if value not in found:
                board.put(key, None if value is None else Stamped(value, NOW))
                found[value] = test(view)
        return found

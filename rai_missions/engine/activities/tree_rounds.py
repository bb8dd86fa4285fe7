# SPDX-License-Identifier: Apache-2.0
"""How far one tree may go round before it rests, within one step.

Rule: no tree fails for going round, and every step ends.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from rai_missions.engine.activities.ticker import TickResult

__all__ = ("MOST_ROUNDS", "MOST_WAKES", "Rounds")

MOST_ROUNDS = 10_000
"""Rounds of all loops of one tree that end in the step in which they began; the rest follow in the next step."""
MOST_WAKES = 1000
"""Ticks of one tree in one step that a key which was written in this step has caused; then the tree rests."""


NONE: frozenset[str] = frozenset()


class Rounds:
    """What one tree has done in the step in hand. Not part of the tree's state: the next step begins with none.

    Args:
        loops: How many rounds can end in one tick of this tree.
    """

    __slots__ = ("_begun", "_ended", "_leaf_ends", "_loops", "others", "own")

    def __init__(self, loops: int) -> None:
        self._loops = loops
        self._begun: AbstractSet[str] = NONE
        self._ended = self._leaf_ends = 0
        self.own = 0
        """Ticks that keys written by the tree itself have caused."""
        self.others = 0
        """Ticks that keys written by others have caused."""

    def next_begins(self, ticked: TickResult) -> bool:
        """Whether a loop begins its next round in this step.

        One with a number always does; one without where the round took time: it had begun in an earlier step.
        """
        begins, begun = False, set(self._begun)
        for each in ticked.rounds:
            at_once = each.at_once or each.path in begun
            begun.discard(each.path)
            self._ended += at_once
            begins = begins or (each.continues and (each.counted or not at_once))
        self._begun = begun.union(ticked.begun)
        if begins:
            self._leaf_ends = 0
        return begins

    @property
    def spent(self) -> tuple[object, ...]:
        """What decides how much room is left, but for `room`."""
        return self._leaf_ends, self.own, self.others, sorted(self._begun)

    @property
    def room(self) -> int:
        """How many more rounds can end before the tree rests."""
        return MOST_ROUNDS - self._loops - self._ended

    def skip(self, rounds: int) -> None:
        """Count rounds that have ended without being ticked one by one."""
        self._ended += rounds

    @property
    def are_spent(self) -> bool:
        """There is no room for the rounds of one more tick."""
        return self.room < 0

    def leaf_ended(self) -> bool:
        """A leaf has ended as soon as it was started; whether there is room for a tick that takes it."""
        self._leaf_ends += 1
        return self._leaf_ends <= MOST_WAKES

    def wrote(self) -> bool:
        """The tree has written what it looks at; whether there is room for a tick that looks."""
        self.own += 1
        return self.own <= MOST_WAKES

    def was_written(self) -> bool:
        """Others have written what the tree looks at; whether there is room for a tick that looks."""
        self.others += 1
        return self.others <= MOST_WAKES

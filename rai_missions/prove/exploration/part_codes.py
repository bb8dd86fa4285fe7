# SPDX-License-Identifier: Apache-2.0
"""The codes of states that are taken apart: one number for a state, with the number of each of its parts in it.

Rule: two such states are the same where their codes are.
"""

from __future__ import annotations

from rai_missions.prove.exploration.region_parts import PartedState

__all__ = ("BITS", "PartCodes")

BITS = 24
"""The bits of a part's number in the code of a state; there are never so many parts as states."""


class PartCodes:
    """Makes and reads codes: the head, for the frame and what the store answers, then the parts.

    Args:
        widest: The most parts that a state has.
    """

    def __init__(self, widest: int = 0) -> None:
        self.widest = widest
        self._width = BITS * widest
        self._heads: dict[tuple[int, bytes], int] = {}
        """Frame, and all of the store that makes a difference, → the head."""
        self._frames: list[tuple[int, range]] = []
        """Of each head the frame, and where in a code with it the parts are."""

    def code(self, parted: PartedState, answer: bytes) -> int:
        """The code of a state.

        Args:
            parted: Its frame and its parts.
            answer: All of its store that makes a difference.
        """
        code = self._head(parted, answer)
        for part in parted.parts:
            code = code << BITS | part
        return code << BITS * (self.widest - len(parted.parts))

    def first(self, parted: PartedState, answer: bytes) -> int:
        """The code of a state with this frame and these answers whose parts are all 0."""
        return self._head(parted, answer) << self._width

    def head_of(self, code: int) -> int:
        """The number of the frame and of what matters of the store: what is left of a code without its parts."""
        return code >> self._width

    def inner(self, code: int) -> int:
        """A code without its head."""
        return code & (1 << self._width) - 1

    def state(self, code: int) -> PartedState:
        """The frame and the parts of the state that has a code."""
        frame, places = self._frames[code >> self._width]
        return PartedState(frame, tuple([code >> BITS * place & (1 << BITS) - 1 for place in places]))

    def _head(self, parted: PartedState, answer: bytes) -> int:
        found = self._heads.setdefault((parted.frame, answer), len(self._heads))
        if found == len(self._frames):
            self._frames.append((parted.frame, range(self.widest - 1, self.widest - 1 - len(parted.parts), -1)))
        return found

# SPDX-License-Identifier: Apache-2.0
"""What a request is made of, before any scene: phrases about things, and clauses about where they are to be."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from rai_missions.planning.scene import CONTAINERS

__all__ = ("Clause", "ClauseKind", "Phrase", "PhraseKind", "Rank", "Unread")

PhraseKind = Literal["things", "everything", "rest", "pronoun", "those", "there", "desk", "tower", "top"]
"""`those` has no words: the things of the clause before, whatever their number. `top` is that of what was stacked."""
ClauseKind = Literal[
    "on",
    "in",
    "to",
    "left_of",
    "right_of",
    "behind",
    "in_front_of",
    "between",
    "next_to",
    "apart",
    "place_of",
    "off",
    "at",
    "stack",
    "swap",
    "group",
    "spread",
    "side_by_side",
    "in_order",
    "by",
    "held",
    "too",
    "under",
    "unstack",
    "towers",
    "shift",
    "stay",
    "row",
]


class Unread(Exception):
    """A request was not read for sure.

    Args:
        reason: A code.
        about: A sentence or question to the person.
        refused: Whether it is refused and not asked back.
    """

    def __init__(self, reason: str, about: str, *, refused: bool = False) -> None:
        super().__init__(about)
        self.reason, self.about, self.refused = reason, about, refused


@dataclass(frozen=True, slots=True)
class Rank:
    """Which of several things is meant, in an order of them: `the leftmost`, `the second nearest to the tray`."""

    measure: str
    """What they are in order by, such as `left`, `big`, `near`."""
    place: int = 1
    """The place of the first that is meant, counted from 1."""
    is_of_two: bool = False
    """Whether it is said of two things: `the left cube`, `the smaller one`."""
    is_after: bool = False
    """Whether it comes after its noun: it may be where a thing is to be, unless it chooses among several."""
    of: Phrase | None = None
    """What a distance is measured from."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """Words about things: `the red cube`, `both apples`, `everything except the corn`, `it`."""

    kind: PhraseKind
    text: str
    types: frozenset[str] = frozenset()
    """Types of things that are meant; empty: any that can be moved."""
    has_noun: bool = False
    """Whether a noun names the types."""
    colour: str = ""
    is_many: bool = False
    """Whether all that there are may be meant."""
    is_all: bool = False
    """Whether all that there are must be meant."""
    is_any: bool = False
    """`a cube`: whichever."""
    is_free: bool = False
    """`any cube`: which one is left to the arm."""
    is_one: bool = False
    """Whether `one` or `ones` stands for a noun: `the red ones`."""
    count: int | None = None
    is_other: bool = False
    epithet: str = ""
    """A word before the noun that no list has: it may be about the only thing there is, and chooses none of several."""
    rank: Rank | None = None
    others: tuple[Phrase, ...] = ()
    """Other things that may be meant in its place: `the red or the blue cube`."""
    without: tuple[Phrase, ...] = ()
    not_types: frozenset[str] = frozenset()

    @property
    def is_container(self) -> bool:
        """Whether a noun names containers, and nothing else."""
        return bool(self.types) and self.types <= CONTAINERS


@dataclass(frozen=True, slots=True)
class Clause:
    """One wish: things, and where they are to be."""

    kind: ClauseKind
    subjects: tuple[Phrase, ...] = ()
    target: Phrase | None = None
    ends: tuple[Phrase, ...] = ()
    """What a thing is to be between."""
    x: float = 0.0
    """Of a place, or of how far a thing is shifted ahead."""
    y: float = 0.0
    """Of a place, or of how far a thing is shifted to the left."""
    gap_m: float | None = None
    levels: tuple[tuple[Phrase, int | None], ...] = field(default=())
    """Of a tower: things of a level, counted from below, negative from above; None: in the middle."""
    count: int = 1
    """How many towers there are to be."""
    height: int = 0
    """Of how many things each of these is; 0: of as many as there are."""
    by: str = ""
    """What groups are made by: `colour` or `type`."""
    is_open: bool = False
    """Whether its form may mean something else: what is read is offered."""

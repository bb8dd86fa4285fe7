# SPDX-License-Identifier: Apache-2.0
"""The kinds of obstacles: whether they live, what moves them, what breaks them, and what they are mistaken for.

Rule: nothing here decides what may be driven over. A limit is a force (N) between the tractor and the thing, and the
judge of the physics measures it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

__all__ = ("KINDS", "LIVING", "ObstacleKind")


@dataclass(frozen=True)
class ObstacleKind:
    """What the orchard knows of a kind of obstacle."""

    looks_like: str
    """What a detector takes it for when it sees badly."""
    moved_by: Literal["forces", "will", "nothing"] = "forces"
    """`will`: what lives; `nothing`: what is part of the ground, or rooted in it."""
    rests_at_m: float = 0.0
    """Height of its middle above the ground."""
    breaks_at_n: float | None = None
    """The force that damages it; None: it takes no harm worth the name."""
    carried: bool = False
    """Whether one person can carry it away: up to 40 kg."""
    variants: tuple[str, ...] = ("",)
    """Forms that it comes in; the first is the usual one."""

    @property
    def lives(self) -> bool:
        return self.moved_by == "will"


KINDS: Mapping[str, ObstacleKind] = {
    "branch": ObstacleKind("hose", rests_at_m=0.07, carried=True),
    "log": ObstacleKind("lying_person", rests_at_m=0.225),
    "crate": ObstacleKind("plastic_bag", rests_at_m=0.305, carried=True),
    "fallen_tree": ObstacleKind("tall_grass", rests_at_m=0.165),
    "person": ObstacleKind("scarecrow", "will", variants=("", "muffs")),
    "animal": ObstacleKind("plastic_bag", "will", variants=("", "tethered")),
    "tall_grass": ObstacleKind("fallen_tree", "nothing"),
    "plastic_bag": ObstacleKind("animal", rests_at_m=0.21, carried=True, variants=("", "full")),
    "hose": ObstacleKind("branch", rests_at_m=0.031, breaks_at_n=2_000.0, carried=True, variants=("", "bridged")),
    "ladder": ObstacleKind("branch", rests_at_m=0.036, breaks_at_n=2_500.0, carried=True),
    "cat": ObstacleKind("branch", "will"),
    "lying_person": ObstacleKind("log", "will", 0.17, variants=("", "resting")),
    "scarecrow": ObstacleKind("person", rests_at_m=0.02, breaks_at_n=500.0, carried=True),
    "puddle": ObstacleKind("hose", "nothing", variants=("", "deep")),
    "fallen_fence": ObstacleKind("ladder", "nothing"),
}
"""Hose: a filled garden hose is crushed by about 2 kN on its width of a tyre. Ladder: a rung or stile of aluminium is
tested with 1.1 kN (EN 131-2) and lasts about twice that. Scarecrow: rags on a post that a push tears down."""
LIVING = frozenset(name for name, kind in KINDS.items() if kind.lives)

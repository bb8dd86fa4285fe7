# SPDX-License-Identifier: Apache-2.0
"""Cells: one answer each, of a model in a scene, and the name by which a campaign finds it again.

Rule: a cell's key is a hash of all that its answer depends on, and of nothing else; the same inputs give the same key
in every process.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.redaction import shown

__all__ = ("ORDERS", "Cell", "cells_of", "code_digest", "digest", "ordered")

ORDERS = ("written", "reversed", "rotated_1", "rotated_2", "rotated_3")
"""The orders in which options may be shown: as the mission has them, backwards, or begun so many places later."""
CODE = (
    "answerers", "embodiment", "engine", "guards", "mission", "planning", "profile", "runtime", "states", "worlds",
)  # fmt: skip
"""Packages through which a scene becomes a question, and an answer a verdict."""
MODULES = tuple(f"campaign/{each}.py" for each in ("asking", "models", "questions", "rollout", "watched_chat"))
"""Modules of this package for which the same is true."""
PACKAGE = Path(__file__).parents[1]


class Cell(NamedTuple):
    """One answer that a campaign asks for, by names."""

    mission: str
    scene: str
    seed: int
    """The scene's; answers in scenes of one seed are not independent of each other."""
    model: str
    embodiment: str
    option_order: str
    """One of `ORDERS`."""

    def key(self, digests: Mapping[str, str]) -> str:
        """The name of this cell in a store: 64 hexadecimal digits.

        Args:
            digests: What the answer depends on beyond these names → its digest: the contents of mission, scene,
                model and embodiment, and the code.
        """
        return digest({"cell": list(self), "digests": dict(digests)})


def cells_of(
    mission: str,
    scenes: Sequence[tuple[str, int]],
    models: Sequence[str],
    embodiments: Sequence[str],
    orders: Sequence[str],
) -> Iterator[Cell]:
    """Every cell of a campaign over one mission, in the order in which they are asked.

    Scenes come last in the product and so change first: a campaign that is stopped early has asked every model, as
    far as it came, in the same scenes.

    Args:
        mission: Its name.
        scenes: Each scene's name and seed.
        models: Names of models.
        embodiments: Names of embodiments.
        orders: Of `ORDERS`.
    """
    for (scene, seed), order, embodiment, model in product(scenes, orders, embodiments, models):
        yield Cell(mission, scene, seed, model, embodiment, order)


def ordered(options: Sequence[str], order: str) -> tuple[str, ...]:
    """The options in the order of that name.

    Raises:
        UsageError: No such order.
    """
    if order == "written":
        return tuple(options)
    if order == "reversed":
        return tuple(reversed(options))
    word, _, places = order.partition("_")
    if word != "rotated" or not places.isdecimal():
        raise UsageError(f"no order of options {shown(order)}; there is: {', '.join(ORDERS)}")
    start = int(places) % max(1, len(options))
    return (*options[start:], *options[:start])


def digest(value: Any) -> str:
    """SHA-256 of a value of JSON types, whatever the order of its keys."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def code_digest() -> str:
    """The digest of all code through which a scene becomes a question and an answer a verdict."""
    found = hashlib.sha256()
    paths = [path for package in CODE for path in sorted((PACKAGE / package).rglob("*.py"))]
    for path in (*paths, *(PACKAGE / module for module in MODULES)):
        found.update(f"{path.relative_to(PACKAGE)}\0".encode())
        found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()

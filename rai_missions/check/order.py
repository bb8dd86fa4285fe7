# SPDX-License-Identifier: Apache-2.0
"""Document order: findings as a reader meets their places in the mission, from top to bottom."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel

__all__ = ("document_order",)


def document_order(mission: Mission) -> Callable[[str], tuple[int, ...]]:
    """A key to sort places by: the positions of a pointer's words, each among its neighbours."""
    positions: dict[int, tuple[Any, dict[str, tuple[int, Any]]]] = {}

    def inside(value: Any) -> dict[str, tuple[int, Any]]:
        if id(value) not in positions:
            # The value is kept with its positions, or another could come to have its id.
            positions[id(value)] = (value, {word: (index, item) for index, (word, item) in enumerate(_items(value))})
        return positions[id(value)][1]

    def order(place: str) -> tuple[int, ...]:
        here: Any = mission
        found: list[int] = []
        for word in place.split("/")[1:]:
            index, here = inside(here).get(word.replace("~1", "/").replace("~0", "~"), (-1, None))
            found.append(index)
        return tuple(found)

    return order


def _items(value: Any) -> list[tuple[str, Any]]:
    if isinstance(value, MissionModel):
        fields = type(value).model_fields
        return [(field.alias or name, getattr(value, name)) for name, field in fields.items()]
    if isinstance(value, Mapping):
        return [(str(word), item) for word, item in value.items()]
    if isinstance(value, list | tuple):
        return [(str(index), item) for index, item in enumerate(value)]
    return []

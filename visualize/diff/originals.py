# SPDX-License-Identifier: Apache-2.0
"""What a thing of the old mission was before it was brought to the new one's names, so that a reader finds it there.

Rule: a rename keeps the order and number of all that is written, so both missions are walked side by side.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel

__all__ = ("AS_THEY_ARE", "Originals")

Anything = TypeVar("Anything")


class Originals:
    """From things of a renamed mission to those of the one that was given; what is unknown is its own."""

    def __init__(self, renamed: Mission | None = None, given: Mission | None = None) -> None:
        self._found: dict[int, Any] = {}
        self._kept = renamed  # as long as it lives no other object has the identity of one of its parts
        self._states: dict[str, str] = {}
        if renamed is not None and given is not None and renamed is not given:
            self._pair(renamed, given)
            names = zip(renamed.walk(), given.walk(), strict=True)
            self._states = {now: was for (_, now, _), (_, was, _) in names}

    def _pair(self, renamed: Any, given: Any) -> None:
        if isinstance(renamed, MissionModel):
            self._found[id(renamed)] = given
            for name in renamed.model_fields_set:
                self._pair(getattr(renamed, name), getattr(given, name))
        elif isinstance(renamed, Mapping):
            for one, other in zip(renamed.values(), given.values(), strict=True):
                self._pair(one, other)
        elif isinstance(renamed, tuple):
            for one, other in zip(renamed, given, strict=True):
                self._pair(one, other)

    def of(self, item: Anything) -> Anything:
        """A written thing, or a tuple of them, as it was given."""
        if isinstance(item, tuple):
            return type(item)(map(self.of, item))
        found: Anything = self._found.get(id(item), item)
        return found

    def state(self, name: str) -> str:
        """A state's own name."""
        return self._states.get(name, name)


AS_THEY_ARE = Originals()

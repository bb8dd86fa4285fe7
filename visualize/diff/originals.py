# SPDX-License-Identifier: Apache-2.0
"""What a thing of the old mission was before it was brought to the new one's names, so that a reader finds it there.

Rule: a rename keeps the order and number of all that is written, so both missions are walked side by side.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel
from visualize.text import child_pointer

__all__ = ("AS_THEY_ARE", "Originals")

Anything = TypeVar("Anything")


class Originals:
    """From things and places of a renamed mission to those of the one that was given; what is unknown is its own."""

    def __init__(self, renamed: Mission | None = None, given: Mission | None = None) -> None:
        self._found: dict[int, Any] = {}
        self._kept = renamed  # as long as it lives no other object has the identity of one of its parts
        self._states: dict[str, str] = {}
        self._places: dict[str, str] = {"": ""}
        if renamed is not None and given is not None and renamed is not given:
            self._pair(renamed, given)
            names = zip(renamed.walk(), given.walk(), strict=True)
            self._states = {now: was for (_, now, _), (_, was, _) in names}

    def _pair(self, renamed: Any, given: Any, now: str = "", was: str = "") -> None:
        """Walk two values side by side, and note the places of what they hold."""
        self._places[now] = was
        if isinstance(renamed, MissionModel):
            self._found[id(renamed)] = given
            fields = type(renamed).model_fields
            words = ((name, fields[name].alias or name) for name in renamed.model_fields_set)
            inside = [(getattr(renamed, name), getattr(given, name), word, word) for name, word in words]
        elif isinstance(renamed, Mapping):
            inside = list(zip(renamed.values(), given.values(), renamed, given, strict=True))
        elif isinstance(renamed, tuple):
            inside = [(*pair, str(index), str(index)) for index, pair in enumerate(zip(renamed, given, strict=True))]
        else:
            return
        for one, other, here, there in inside:
            self._pair(one, other, child_pointer(now, here), child_pointer(was, there))

    def of(self, item: Anything) -> Anything:
        """A written thing, or a tuple of them, as it was given."""
        if isinstance(item, tuple):
            return type(item)(map(self.of, item))
        found: Anything = self._found.get(id(item), item)
        return found

    def state(self, name: str) -> str:
        """A state's own name."""
        return self._states.get(name, name)

    def place(self, pointer: str) -> str:
        """A JSON pointer into the renamed mission as one into the given one; a field may be left out in both."""
        known, rest = pointer, ""
        while known not in self._places:
            known, _, step = known.rpartition("/")
            rest = f"/{step}{rest}"
        return self._places[known] + rest


AS_THEY_ARE = Originals()

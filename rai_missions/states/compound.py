# SPDX-License-Identifier: Apache-2.0
"""States inside a state: one after the other (compound), side by side (parallel), or once for each item of a list."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.guards.guard import Distinctions
from rai_missions.kinds import KeyValue, Refers
from rai_missions.model import Name, Path, StateNames
from rai_missions.states.state import State, States

__all__ = ("Compound", "Each", "Parallel")


class Compound(State, word="states"):
    """One of its states is active at a time; the outcome of its final child is its own."""

    initial: StateNames
    """A descendant, or one a region of a parallel descendant."""
    states: States = Field(min_length=1)

    def children(self) -> Mapping[str, State]:
        return self.states


class Parallel(State, word="parallel"):
    """All regions are active at a time; when each has reached a final, the worst outcome is its own."""

    positional: ClassVar = ("parallel",)

    parallel: States = Field(min_length=1)

    def children(self) -> Mapping[str, State]:
        return self.parallel

    def child_place(self) -> str:
        return "parallel"


class Each(State, word="each"):
    """Its states run once for each item of a list, copied on entry; the first outcome but `succeeded` ends it."""

    positional: ClassVar = ("each",)

    each: Path
    """The key that holds the list."""
    item: Annotated[Name, Refers("key", "each")] = Field(alias="as")
    """The mission key that holds the current item."""
    initial: StateNames
    states: States = Field(min_length=1)

    def children(self) -> Mapping[str, State]:
        return self.states

    def writes(self, place: str = "") -> Iterator[KeyValue]:
        yield KeyValue(self.item, f"{place}/as", "each", self.each)

    def distinguish(self, by: Distinctions) -> None:
        """It compares nothing."""

    def title(self) -> str:
        return f"for each {self.item} in {self.each}"

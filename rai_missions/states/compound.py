# SPDX-License-Identifier: Apache-2.0
"""States inside a state: one after the other (compound), side by side (parallel), or once for each item of a list."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, PrivateAttr

from rai_missions.guards.analysis import Distinctions
from rai_missions.model import KeyPath, Name, Path, StateNames
from rai_missions.model.references import KeyValue, Refers
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import State, States
from rai_missions.states.transition import Transition

if TYPE_CHECKING:
    from rai_missions.states.include import Include

__all__ = ("Compound", "Each", "Parallel")


class Compound(State, word="states"):
    """One of its states is active at a time; the outcome of its final child is its own."""

    initial: StateNames
    """A descendant, or one a region of a parallel descendant."""
    states: States = Field(min_length=1)
    """The states inside, by their names."""
    _included_by: Include | None = PrivateAttr(default=None)

    def __init__(
        self,
        *,
        initial: str | Sequence[str],
        states: Mapping[str, State],
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def model_post_init(self, context: Any, /) -> None:
        """Remember the inclusion, where the context of its validation names one; it is no part of what is written."""
        self._included_by = (context or {}).get("included_by")

    @property
    def included_by(self) -> Include | None:
        """The inclusion that became this state, as it is written; None where its states are written here."""
        return self._included_by

    def children(self) -> Mapping[str, State]:
        return self.states

    def starts(self) -> tuple[str, ...]:
        return self.initial


class Parallel(State, word="parallel"):
    """All regions are active at a time; when each has reached a final, the worst outcome is its own."""

    ordered = ("parallel",)
    parallel: States = Field(min_length=1)
    """The regions, by their names; each is a state."""

    def __init__(
        self,
        parallel: Mapping[str, State],
        *,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def children(self) -> Mapping[str, State]:
        return self.parallel

    def child_place(self) -> str:
        return "parallel"


class Each(State, word="each"):
    """A state that runs its states for each item of a list, copied on entry, until one is not `succeeded`."""

    each: Path
    """The key that holds the list."""
    item: Annotated[Name, Refers("key", "each")] = Field(alias="as")
    """The mission key that holds the current item."""
    initial: StateNames
    """The state with which each round begins, or one a region."""
    states: States = Field(min_length=1)
    """The states inside, by their names."""

    def __init__(
        self,
        each: KeyPath,
        *,
        item: KeyPath,
        initial: str | Sequence[str],
        states: Mapping[str, State],
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def children(self) -> Mapping[str, State]:
        return self.states

    def starts(self) -> tuple[str, ...]:
        return self.initial

    def writes(self, place: str = "") -> Iterator[KeyValue]:
        yield KeyValue(self.item, f"{place}/as", "each", self.each)

    def distinguish(self, by: Distinctions) -> None:
        """Report no values to distinguish: a history compares nothing."""

    def title(self) -> str:
        return f"for each {self.item} in {self.each}"

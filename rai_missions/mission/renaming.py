# SPDX-License-Identifier: Apache-2.0
"""Other names for what a mission refers to, and which of its parts are which of another's.

It serves what compares two missions, moves a run from one into the other, or includes one in the other.

Rule: what a field refers to is in its annotation (`Refers`); a test holds that no field which can name something lacks
one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from rai_missions.model import MissionModel
from rai_missions.model.references import HELD, rewritten

__all__ = ("Names", "matched", "renamed")

AnyWritten = TypeVar("AnyWritten", bound=MissionModel)
Change = Callable[[str], str]
Table = Mapping[str, str | None]
"""Old name → new name, or None; what is not in it keeps its name."""
Old = TypeVar("Old")
New = TypeVar("New")
Part = TypeVar("Part")


class Names(NamedTuple):
    """New names for old ones."""

    state: Change
    key: Change
    event: Change
    timer: Change
    trigger: Callable[[tuple[str, ...]], tuple[str, ...]]
    """For the words of a transition's `on`, among which there are outcomes and options too."""

    @classmethod
    def by(cls, *, states: Table = {}, keys: Table = {}, events: Table = {}) -> Names:  # noqa: B006 - only read
        """The names in tables; timers keep theirs."""

        def change(table: Table) -> Change:
            return lambda name: table.get(name) or name

        event = change(events)
        return cls(change(states), change(keys), event, change({}), lambda on: tuple(map(event, on)))

    def path(self, given: str) -> str:
        """A key, or a field of one, which keeps its name as does what the event or answer in hand brought."""
        head, dot, rest = given.partition(".")
        return self.key(head) + dot + rest

    def change(self, sort: str, given: Any) -> Any:
        """The new name of something of a sort; what is of another sort (a predicate) keeps its name."""
        return getattr(self, sort)(given) if sort in (*self._fields, "path") else given


def renamed(item: AnyWritten, names: Names) -> AnyWritten:
    """A written thing with every name in it replaced."""
    changed: AnyWritten = rewritten(item, HELD, names.change)
    return changed


def matched(old: Mapping[Old, Part], new: Mapping[New, Part], is_same: Callable[[Part, Part], bool]) -> dict[New, Old]:
    """For parts of one mission those of another that are the same, each taken once, in the order of both."""
    left = dict(old)
    found: dict[New, Old] = {}
    for here, part in new.items():
        match = next((there for there, before in left.items() if is_same(before, part)), None)
        if match is not None:
            found[here] = match
            del left[match]
    return found

# SPDX-License-Identifier: Apache-2.0
"""Other names for what a mission refers to: keys, events, states and timers, wherever they appear.

Rule: what a field refers to is in its annotation (`Refers`); a test holds that no field which can name something lacks
one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from rai_missions.kinds import HELD, rewritten
from rai_missions.model import MissionModel

__all__ = ("Names", "renamed")

AnyWritten = TypeVar("AnyWritten", bound=MissionModel)
Change = Callable[[str], str]


class Names(NamedTuple):
    """New names for old ones."""

    state: Change
    key: Change
    event: Change
    timer: Change
    trigger: Callable[[tuple[str, ...]], tuple[str, ...]]
    """For the words of a transition's `on`, among which there are outcomes and options too."""

    def change(self, sort: str, given: Any) -> Any:
        """The new name of something of a sort; what is of another sort (a predicate) keeps its name."""
        if sort == "path":  # a field keeps its name, as does what the event or answer in hand brought
            head, dot, rest = given.partition(".")
            return self.key(head) + dot + rest
        return getattr(self, sort)(given) if sort in self._fields else given


def renamed(item: AnyWritten, names: Names) -> AnyWritten:
    """A written thing with every name in it replaced."""
    changed: AnyWritten = rewritten(item, HELD, names.change)
    return changed

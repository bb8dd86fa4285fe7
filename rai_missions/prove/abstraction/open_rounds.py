# SPDX-License-Identifier: Apache-2.0
"""The lists that a run goes over, and a note of each look at one.

Rule: a list is there as long as the state that goes over it is active, so whether it is there is known already; a look
at what it holds is noted, under a name that no key of a mission has.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ("MORE", "PREFIX", "OpenRounds", "Round", "list_name")

PREFIX = "each "
"""No key has a blank in its name."""
MORE = ...
"""An item that is chosen when its round begins."""
Round = tuple[tuple[Any, ...], int]
"""Items, and which of them is current."""


def list_name(state: str) -> str:
    """The name of the list that a state goes over, among the mission's own keys."""
    return PREFIX + state


class OpenRounds(dict[str, Round]):
    """State → items, and which of them is current.

    Args:
        looked: Receives the name of each list that was looked into.
    """

    def __init__(self, looked: set[str]) -> None:
        super().__init__()
        self._looked = looked

    def __getitem__(self, state: str) -> Round:
        self._looked.add(PREFIX + state)
        return dict.__getitem__(self, state)

    def items(self) -> Any:
        """All, looked at."""
        self._looked.update([PREFIX + state for state in self])
        return dict.items(self)

    def entries(self) -> Any:
        """All, without a look."""
        return dict.items(self)

    def refill(self, entries: Mapping[str, Round]) -> None:
        """Have these and no others."""
        dict.clear(self)
        dict.update(self, entries)

# SPDX-License-Identifier: Apache-2.0
"""Items of lists that the start brings, left open field by field until a rule looks.

Rule: an item is one object wherever a run has it: in its list, in what a history remembers and under its key. At rest
a state has what is known of it once, as plain data; the other places refer to that by `HERE`.

Why this loses no run, and adds none. A list is given at the start, so what is in it was chosen before. A step depends
on an item through the fields that it looks at alone, and each value that is chosen then is one that the item could
have had from the start. What was found out stays, for as long as it may be read (`Later`). A second look finds the
same, wherever the item is by then, and each mixture of values of its fields is a value of the item.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction.nondeterminism import OpenBoard, OpenFields
from rai_missions.prove.abstraction.open_rounds import Round
from rai_missions.prove.analysis.comparisons import Comparisons
from rai_missions.states.compound import Each
from rai_missions.states.state import State

__all__ = ("HERE", "OpenItems", "open_lists")

HERE = "the item of the key"
"""Represents, in a list at rest, the item that is the value of the list's key."""


def open_lists(mission: Mission, learned: Comparisons) -> dict[str, Each]:
    """Each state that goes over a list whose items can be left open.

    The list is an argument, of which nothing but such states knows. The key of its items is an object that one such
    state alone writes, and of which rules look at fields by name.
    """
    written = [each.key for thing in mission.everything() for each in thing.writes()]
    return {
        name: state
        for name, state in _outside_regions(mission)
        if isinstance(state, Each)
        and state.each in mission.blackboard
        and mission.blackboard[state.each].source == "argument"
        and state.each not in learned.compared
        and learned.is_bare(state.each)
        and learned.is_bare(state.item)
        and written.count(state.item) == 1
        and mission.blackboard[state.item].type == "object"
        and mission.blackboard[state.item].initial is None
    }


def _outside_regions(mission: Mission) -> Iterable[tuple[str, State]]:
    """The states that are in no region of a parallel state, with their names."""

    def within(states: Mapping[str, State]) -> Iterable[tuple[str, State]]:
        for name, state in states.items():
            yield name, state
            if state.child_place() != "parallel":
                yield from within(state.children())

    return within(mission.states)


class OpenItems:
    """Puts the open items of a state back into a run, and takes them out of it.

    Args:
        shapes: The key of an item → an item of which nothing is known.
        lists: Each state that goes over a list of such.
        board: What is known.
    """

    def __init__(self, shapes: Mapping[str, OpenFields], lists: Mapping[str, Each], board: OpenBoard) -> None:
        self.shapes, self._board = shapes, board
        self.keys = {name: state.item for name, state in lists.items()}
        """State → the key of its items."""
        self.paths = {name: state.each for name, state in lists.items()}
        """State → the path of its list."""
        self._loaded: dict[str, OpenFields] = {}
        """Key → the item that was put back for it."""

    def load(self) -> None:
        """Have each key that is known hold an item of this run."""
        self._loaded = {}
        for key, shape in self.shapes.items():
            entry = self._board.known(key)
            self._loaded[key] = item = shape.fresh({} if entry is None else entry.value)
            if entry is not None:
                self._board.put(key, Stamped(item, entry.at))

    def opened(self, each: str, found: Round) -> Round:
        """A list as a run has it."""
        if each not in self.keys:
            return found
        key = self.keys[each]
        items = [
            self._loaded[key] if item is HERE else self.shapes[key].fresh(item) if isinstance(item, Mapping) else item
            for item in found[0]
        ]
        return tuple(items), found[1]

    def closed(self, each: str, found: Round) -> Round:
        """A list as a state has it at rest."""
        if each not in self.keys:
            return found
        here = self._here(self.keys[each])
        items = (HERE if item is here else known(item) if isinstance(item, OpenFields) else item for item in found[0])
        return tuple(items), found[1]

    def _here(self, key: str) -> Any:
        entry = self._board.known(key)
        return self._loaded.get(key) if entry is None else entry.value

    def entry(self, key: str, entry: Any) -> Any:
        """What is known under a key, as a state has it at rest."""
        return Stamped(known(entry.value), entry.at) if key in self.shapes and entry is not None else entry


def known(item: Mapping[str, Any]) -> dict[str, Any]:
    """What is known of an item, as plain data; None is unknown."""
    return dict(sorted(item.items()))

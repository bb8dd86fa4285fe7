# SPDX-License-Identifier: Apache-2.0
"""The lists of a refutation, put together of what its steps have found out of their items.

Rule: an item that is left open has no value before a rule looks; a run begins with all that the rules find later.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.prove.environment.environment import Environment

__all__ = ("TracedLists",)


class TracedLists:
    """Gathers the items of lists step by step.

    Args:
        environment: The mission, in the state to which the last step led.
    """

    def __init__(self, environment: Environment) -> None:
        self._chart, self._world = environment.chart, environment.world
        self._found: dict[str, list[list[dict[str, Any]]]] = {}
        """Each state that goes over an open list → the items of each visit."""

    def learn(self) -> None:
        """Take note of the items of the step that was just made."""
        state = self._chart.state
        entered = {name for move in state.draft.moves for name in move.entered}
        for name, key in self._world.items.keys.items():
            visits = self._found.setdefault(name, [])
            if name in entered:
                visits.append([])
            if not visits:
                continue
            visits[-1] += [item for written, item in state.draft.written if written == key]
            entry = self._world.board.known(key)
            if visits[-1] and entry is not None:
                visits[-1][-1] = {**visits[-1][-1], **entry.value}

    def lists(self) -> Mapping[str, list[dict[str, Any]]]:
        """Path of a list → its items on the first visit, with one more where the run ends before the last."""
        rounds, found = dict(self._world.rounds.entries()), dict[str, list[dict[str, Any]]]()
        for name, visits in self._found.items():
            if not visits:
                continue
            items, at = rounds.get(name, ((), 0))
            more: list[dict[str, Any]] = [{}] if len(visits) == 1 and len(items) > at + 1 else []
            path = self._world.items.paths[name]
            found.setdefault(path, [_plain(each) for each in (*visits[0], *more)])
        return found


def _plain(item: Mapping[str, Any]) -> dict[str, Any]:
    return {field: value for field, value in item.items() if value is not None}

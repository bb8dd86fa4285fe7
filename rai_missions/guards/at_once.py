# SPDX-License-Identifier: Apache-2.0
"""Parts of guards that look into one object alone: an object that is left open is asked for their truth at once.

Rule: what is asked is no finer than what the place of the part makes of the answer (`Site.counts`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple, cast

from rai_missions.guards.analysis import OpenObject
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Test, Truth, View, as_counted
from rai_missions.keys import Stamped

__all__ = ("asked_at_once",)


class _Alone(NamedTuple):
    """What a guard sees that looks into one key."""

    board: Mapping[str, Stamped]
    at: float


def asked_at_once(guard: Guard, test: Test, site: Site, counts: Truth) -> Test:
    """A guard that looks into one key of a site; one that is left open is asked for its truth, and not for each field.

    Args:
        guard: As it is written.
        test: As it is compiled.
        site: Where.
        counts: Which of its values counts there.
    """
    key = guard.looked_into()
    if key not in site.keys:
        return test
    question = json.dumps(guard.written() if counts is None else {str(counts): guard.written()})

    def found(value: Mapping[str, Any], at: float) -> Truth:
        return as_counted(test(cast(View, _Alone({key: Stamped(value, at)}, at))), counts)

    def ask(view: View) -> Truth:
        entry = view.board.get(key)
        if entry is None or not isinstance(entry[0], OpenObject):
            return test(view)
        at = entry[1]
        return entry[0].find(question, lambda value: found(value, at))

    return ask

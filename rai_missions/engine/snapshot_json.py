# SPDX-License-Identifier: Apache-2.0
"""What a chart remembers as plain data, which a journal can hold, and back.

Rule: only the kinds in `KINDS`, and what machines remember, are made of data; anything else is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.activity import remembered_kinds
from rai_missions.engine.activities.ticker import Leaf, TreeState
from rai_missions.engine.decision import Evidence, Limits, Offer, Question
from rai_missions.engine.state import Timer
from rai_missions.engine.step import (
    Ask,
    CallService,
    CancelGoal,
    Handover,
    PublishMessage,
    SayAloud,
    StartBehaviour,
    StartGoal,
)
from rai_missions.event import Event
from rai_missions.keys import Stamped
from rai_missions.redaction import clipped, shown

__all__ = ("packed", "unpacked")

KINDS: Mapping[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        Stamped,
        Timer,
        Event,
        Leaf,
        TreeState,
        Evidence,
        Limits,
        Offer,
        Question,
        Ask,
        CallService,
        CancelGoal,
        Handover,
        PublishMessage,
        SayAloud,
        StartBehaviour,
        StartGoal,
    )
}
"""The word in a journal → its kind, but for what machines remember."""


def _kinds() -> Mapping[str, type[Any]]:
    return {**KINDS, **remembered_kinds()}


def packed(value: Any) -> Any:
    """A value as lists, tuples, text, numbers and pictures, its mappings and records as `{"is": kind, "of": […]}`."""
    if isinstance(value, Mapping):
        return {"is": "map", "of": [[packed(name), packed(item)] for name, item in value.items()]}
    if isinstance(value, frozenset):
        return {"is": "set", "of": [packed(item) for item in sorted(value)]}
    if isinstance(value, tuple):
        items = [packed(item) for item in value]
        if not hasattr(value, "_fields"):
            return tuple(items)
        return {"is": next(word for word, kind in _kinds().items() if kind is type(value)), "of": items}
    return [packed(item) for item in value] if isinstance(value, list) else value


def unpacked(value: Any) -> Any:
    """The value that `packed` made plain.

    Raises:
        ValueError: A kind that there is not; also `KeyError` and `TypeError` for what was altered.
    """
    if isinstance(value, list):
        return [unpacked(item) for item in value]
    if isinstance(value, tuple):
        return tuple(unpacked(item) for item in value)
    if not isinstance(value, Mapping):
        return value
    kind, items = value["is"], [unpacked(item) for item in value["of"]]
    if kind == "map":
        return dict(items)
    if kind == "set":
        return frozenset(items)
    kinds = _kinds()
    if kind not in kinds:
        raise ValueError(
            f"nothing that a run remembers is called {shown(kind, by=clipped)}; there is: {', '.join(kinds)}"
        )
    return kinds[kind](*items)

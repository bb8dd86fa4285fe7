# SPDX-License-Identifier: Apache-2.0
"""Small missions for tests, and what a run of one left and entered."""

from __future__ import annotations

from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

__all__ = ("chart", "mission", "row", "sent", "ticked")


def mission(states: dict[str, Any], initial: Any = None, **words: Any) -> Mission:
    """A mission of these states; every word that a row has `on` is declared unless it is an outcome."""
    from rai_missions.states.state import OUTCOMES

    events = words.pop("events", None)
    if events is None:
        events = sorted(set(_events(states)) | set(_events(words)))
    start = initial if initial is not None else next(iter(states))
    options = set(_options(states))
    declared = [name for name in events if name not in OUTCOMES and name not in options and name != "*"]
    return Mission.model_validate({"name": "tried", "states": states, "initial": start, "events": declared, **words})


def chart(states: dict[str, Any], initial: Any = None, *, started: bool = True, **words: Any) -> Chart:
    """A chart of these states, started at 0 s."""
    made = Chart(mission(states, initial, **words))
    if started:
        made.start(0.0)
    return made


def row(on: Any = None, to: Any = None, **words: Any) -> dict[str, Any]:
    """A transition as JSON has it."""
    return {key: value for key, value in {"on": on, "to": to, **words}.items() if value is not None}


def sent(made: Chart, *names: str, at: float | None = None) -> Step:
    """Send events one after the other; the last one's step."""
    steps = [made.send(Event(name, made.at if at is None else at)) for name in names]
    return steps[-1]


def ticked(made: Chart, at: float) -> Step:
    return made.send(Tick(at))


def _events(value: Any) -> Any:
    if isinstance(value, dict):
        for key, item in value.items():
            if key in ("on", "raise"):
                yield from [item] if isinstance(item, str) else item
            else:
                yield from _events(item)
    elif isinstance(value, list):
        for item in value:
            yield from _events(item)


def _options(value: Any) -> Any:
    if isinstance(value, dict):
        for key, item in value.items():
            if key == "options":
                yield from item
            else:
                yield from _options(item)
    elif isinstance(value, list):
        for item in value:
            yield from _options(item)

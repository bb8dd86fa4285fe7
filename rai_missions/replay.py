# SPDX-License-Identifier: Apache-2.0
"""A run done again from its journal: the same events, so the same steps, or the first difference by name.

Rule: the chart that replays is the chart that ran; nothing of a step is taken from the journal but its event.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError

from rai_missions.chart import Chart
from rai_missions.errors import DefinitionError, Fault
from rai_missions.faults import faults_of
from rai_missions.guards.guard import Truth
from rai_missions.guards.named import Named
from rai_missions.journal import Record, StepRow, difference, read
from rai_missions.json_text import parse_json
from rai_missions.mission import Mission
from rai_missions.robot import parse_profile, terms
from rai_missions.runner import default_ticker
from rai_missions.states.terms import Terms
from rai_missions.states.ticker import Trees
from rai_missions.step import Step

__all__ = ("Replay", "mission_of", "replay")


class Replay(NamedTuple):
    """What came of a replay."""

    steps: int
    """How many were done again and were the same."""
    difference: str = ""
    """The first step that was not, in words; empty if all were."""
    outcome: str | None = None
    why: str = ""

    @property
    def holds(self) -> bool:
        return not self.difference


class _Recorded:
    """Predicates of the user's program, as the journal remembers what they said."""

    def __init__(self, names: set[str]) -> None:
        self.said: deque[tuple[str, Truth]] = deque()
        self.named: dict[str, Callable[..., Truth]] = {name: self._asked(name) for name in names}

    def turn_to(self, step: Step) -> None:
        self.said = deque((place[6:], value) for place, value in step.guards if place.startswith("named:"))

    def _asked(self, name: str) -> Callable[..., Truth]:
        def say(_: Mapping[str, Any], **__: Any) -> Truth:
            if self.said and self.said[0][0] == name:
                return self.said.popleft()[1]
            return None

        return say


def mission_of(record: Record) -> Mission:
    """The mission that a journal's run was of.

    Raises:
        DefinitionError: Row 0 holds none.
    """
    source = f"{record.path}, row 0"
    if not record.header.mission:
        sentence = "the mission has behaviours in Python and is not in its journal; give its file: --mission FILE.py"
        raise DefinitionError([Fault("", sentence)], source)
    data = parse_json(record.header.mission.encode(), source)
    try:
        return Mission.model_validate(data)
    except ValidationError as error:
        raise DefinitionError(faults_of(error, Mission, data), source) from None


def replay(
    path: Path | str,
    ticker: Trees | None = None,
    on_step: Callable[[Step], None] | None = None,
    mission: Mission | None = None,
) -> Replay:
    """Do a journal's run again.

    Args:
        path: The journal.
        ticker: Who ticks trees; py_trees by default.
        on_step: Told of each step that was the same.
        mission: The mission, where its journal does not hold it: one with behaviours written in Python.

    Raises:
        DefinitionError: The journal is damaged or altered; every fault with its row.
        UsageError: There is no such journal.
    """
    with read(path) as record:
        mission = mission if mission is not None else mission_of(record)
        recorded = _Recorded(_names(mission))
        chart = Chart(mission, ticker or default_ticker(mission), terms=_terms(record), named=recorded.named)
        count = 0
        for row in record.entries():
            recorded.turn_to(row.step)
            got = _again(chart, row)
            if found := difference(row.step, got):
                return Replay(count, found, chart.outcome, chart.why)
            count += 1
            if on_step is not None:
                on_step(got)
        return Replay(count, "", chart.outcome, chart.why)


def _again(chart: Chart, row: StepRow) -> Step:
    step = row.step
    chart.absorb(row.before, at=row.since, seq=step.seq - 1)
    if step.event.kind == "command" and step.event.name == "start":
        return chart.start(step.event.at)
    return chart.send(step.event)


def _names(value: Any) -> set[str]:
    """The predicates that a mission, or a part of it, names, wherever it does."""
    if isinstance(value, Named):
        return {value.named}
    if isinstance(value, BaseModel):
        value = vars(value)
    inside = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return set().union(*(_names(item) for item in inside))


def _terms(record: Record) -> Terms | None:
    profile = record.header.profile
    return terms(parse_profile(profile, source=f"{record.path}, row 0")) if profile else None

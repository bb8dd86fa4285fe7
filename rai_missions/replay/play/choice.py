# SPDX-License-Identifier: Apache-2.0
"""One thing that can happen now, and what it does to the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.replay.play.fields import Field
from rai_missions.replay.play.passage import let_time_pass

__all__ = ("ChoiceKind", "Input", "Passage", "PlayChoice", "perform")

ChoiceKind = Literal[
    "start", "event", "answer", "goal", "call", "behaviour", "key", "stale", "time", "command", "control"
]
"""`key`: a value of one is given; `stale`: a fact is not reported any more, until it is too old."""


class Passage(NamedTuple):
    """Time that passes, with facts that stay fresh."""

    until: float
    but: tuple[str, ...] = ()


Input = Event | Passage
"""What is given to a chart."""


class PlayChoice(NamedTuple):
    """One thing that can happen now."""

    name: str
    """What it is chosen by; the same as long as it can happen: `event anomaly`, `goal 1 succeeded`, `key battery`."""
    kind: ChoiceKind
    words: str
    """What happens, in a line."""
    inputs: Callable[[Chart, Mapping[str, Any]], Sequence[Input]]
    """What the chart is given, with the values of the fields by name."""
    fields: tuple[Field, ...] = ()
    state: str = ""
    """The state that it concerns; empty for none."""
    key: str = ""
    """The key whose value is given or goes stale; empty for none."""
    about: str = ""
    is_awaited: bool = False
    """The mission waits for it: its start, an answer, control that it asked for."""
    is_rare: bool = False
    """It is offered, and comes last: a server that is gone, a cancel that is refused."""
    refused: str = ""
    """Why the rules would refuse this answer now; it can be given all the same."""

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        without = {name: value for name, value in self._asdict().items() if name != "inputs"}
        return {**without, "fields": [field.data() for field in self.fields]}


def perform(chart: Chart, given: Input) -> Iterator[Step]:
    """Give a chart an input."""
    if isinstance(given, Passage):
        yield from let_time_pass(chart, given.until, but=given.but)
    elif given.kind == "command" and given.name == "start":
        yield chart.start(given.at)
    else:
        yield chart.send(given)

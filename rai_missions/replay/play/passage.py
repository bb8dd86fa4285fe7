# SPDX-License-Identifier: Apache-2.0
"""Time that passes in a play, while the robot reports again and again what it reported last.

Rule: a fact goes stale only where a person wants it to; else it is written once more before it would.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from rai_missions.engine import Chart
from rai_missions.engine.semantics.timing import look_for_time
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Tick
from rai_missions.keys import Stamped, stale_at

__all__ = ("fading", "let_time_pass", "next_change")

REPEATED = 0.9
"""The part of its `max_age_s` after which a fact is reported again."""
MOST_WRITES = 200_000
FAR_S = 1e12


def fading(chart: Chart) -> dict[str, float]:
    """The robot's keys that are known, and will be stale if they are not reported again → when."""
    board = chart.view.board
    ends = {
        name: stale_at(key, board[name])
        for name, key in chart.mission.blackboard.items()
        if key.source == "robot" and name in board
    }
    return {name: end for name, end in ends.items() if chart.at < end < math.inf}


def let_time_pass(chart: Chart, until: float, *, but: Collection[str] = ()) -> Iterator[Step]:
    """Let time pass, while each fact of the robot that is fresh stays so.

    Args:
        chart: The run.
        until: The instant until which it passes, in seconds on the run's clock.
        but: Keys of the robot that are not reported meanwhile.

    Yields:
        The steps: writes, and a `Tick` at the end.

    Raises:
        UsageError: It is over already, or the facts would be written too often.
    """
    if not chart.at <= until < math.inf:
        raise UsageError(f"it is {chart.at:g} s; time passes until a later instant, not {until:g} s")
    keys, fresh = chart.mission.blackboard, fading(chart).keys() - frozenset(but)
    every = {name: (keys[name].max_age_s or 0.0) * REPEATED for name in sorted(fresh)}
    if sum((until - chart.at) / each for each in every.values()) > MOST_WRITES:
        raise UsageError(f"the robot would report more than {MOST_WRITES} facts until {until:g} s; let less time pass")
    due = {name: max(chart.at, chart.view.board[name].at + each) for name, each in every.items()}
    while due and chart.outcome is None and (at := min(due.values())) < until:
        for name in [name for name, when in due.items() if when == at]:
            yield chart.write(name, chart.view.board[name].value, at)
            due[name] = at + every[name]
    yield chart.send(Tick(until))


def next_change(chart: Chart) -> float | None:
    """The instant at which time alone changes something, while each fact of the robot stays fresh; None for none."""
    probe = chart.branch()
    for name in fading(chart):
        probe.state.board[name] = Stamped(probe.state.board[name].value, FAR_S)
    look_for_time(probe.program, probe.state)
    wake = probe.wake_at
    return wake if wake is not None and wake < FAR_S else None

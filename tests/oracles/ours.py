# SPDX-License-Identifier: Apache-2.0
"""A mission's run, and an oracle's, as the same kind of trace."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.step import LogLine, Step
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.oracles.appendix_d import Interpreter

__all__ = ("Trace", "logged", "of_appendix_d", "of_ours")


class Trace(NamedTuple):
    """What one happening led to."""

    active: frozenset[str]
    logs: tuple[str, ...]
    ended: str = ""


def logged(step: Step) -> tuple[str, ...]:
    """What a step logged."""
    return tuple(effect.text for effect in step.effects if isinstance(effect, LogLine))


def of_ours(document: dict[str, Any], script: Iterable[tuple[Any, ...]]) -> list[Trace]:
    """The trace of our chart; `why` of an end is left out."""
    chart = Chart(Mission.model_validate(document))
    trace, at = [_seen(chart, chart.start(0.0))], 0.0
    for word, what, wait in script:
        at += wait
        trace.append(_seen(chart, _happen(chart, word, what, at)))
    return trace


def _happen(chart: Chart, word: str, what: Any, at: float) -> Step:
    if word == "write":
        return chart.write(what[0], what[1], at)
    return chart.send(Event(what, at) if word == "event" else Tick(at))


def _seen(chart: Chart, step: Step) -> Trace:
    return Trace(chart.active, logged(step), chart.outcome or "")


def of_appendix_d(document: dict[str, Any], script: Iterable[tuple[Any, ...]]) -> list[Trace]:
    """The trace of SCXML's own algorithm.

    Raises:
        Endless: The chart runs in circles.
    """
    oracle = Interpreter(document)
    oracle.interpret()
    trace, at = [_received(oracle)], 0.0
    for word, what, wait in script:
        at += wait
        if word == "event":
            oracle.send(what, at)
        elif word == "write":
            oracle.assign(*what, at)
        else:
            oracle.advance(at)
        trace.append(_received(oracle))
    return trace


def _received(oracle: Interpreter) -> Trace:
    logs, oracle.log = tuple(oracle.log), []
    return Trace(frozenset(s.id for s in oracle.configuration if s.id), logs, oracle.outcome)

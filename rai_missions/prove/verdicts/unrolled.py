# SPDX-License-Identifier: Apache-2.0
"""A run of a mission whose loops were explored with few rounds, made one of the mission as it is written.

Rule: a run is shown only if the mission does it. Where a loop's last round needs more rounds before it, one of the
run's own rounds, after which everything is as before it but for the count, is gone as often as that takes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

from rai_missions.prove.abstraction.state_key import Place
from rai_missions.prove.analysis.loops import Level, Loop
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.verdicts.counterexample import go

__all__ = ("RepeatedPart", "repeated", "unrolled")

MOST_SCENES = 50_000
"""A run of more steps than this is not shown."""

Item = TypeVar("Item")


class RepeatedPart(NamedTuple):
    """A part of a run that is gone again and again."""

    first: int
    """The first step that is gone again."""
    last: int
    times: int


def unrolled(
    few: Environment, every: Environment, ways: Sequence[Edge], rounds: Mapping[Loop, int]
) -> list[RepeatedPart] | None:
    """The rounds that are missing in a run; None where none of its own rounds does.

    Args:
        few: The mission with few rounds, before the start; it does the run.
        every: The mission with all its rounds, before the start.
        ways: The run.
        rounds: How many rounds of each loop there are in the first.
    """
    every.codec.loops = few.codec.loops
    missing: list[RepeatedPart] = []
    levels: list[Mapping[Loop, Level]] = []
    for way in ways:
        before = every.codec.place()
        go(few, way)
        if not _follows(every, way, few):
            found = _round_before(every, before, few, way, levels, rounds)
            if found is None:
                return None
            missing.append(found)
        _rest(few)
        _rest(every)
        levels.append(_levels(few))
    return missing


def _follows(environment: Environment, way: Edge, other: Environment) -> bool:
    """Go a way; whether that leads where the other chart is."""
    try:
        go(environment, way)
    except LookupError:
        return False
    return _end(environment) == _end(other)


def _end(environment: Environment) -> tuple[str | None, str, bytes]:
    chart = environment.chart
    return chart.outcome, chart.why, environment.codec.uncounted()


def _round_before(
    every: Environment,
    before: Place,
    few: Environment,
    way: Edge,
    levels: Sequence[Mapping[Loop, Level]],
    rounds: Mapping[Loop, int],
) -> RepeatedPart | None:
    """The round that must be gone more often before a way leads where it should."""
    for loop, many in rounds.items():
        found = _round(loop, levels)
        if found is None or loop.rounds == many:
            continue
        every.load(before)
        every.codec.go_round(loop, loop.rounds - many)
        if _follows(every, way, few):
            return RepeatedPart(found[0] + 1, found[1], loop.rounds - many)
    return None


def _round(loop: Loop, levels: Sequence[Mapping[Loop, Level]]) -> tuple[int, int] | None:
    """The last two steps of a run between which one round has ended and nothing else has changed."""
    for last in range(len(levels) - 1, 0, -1):
        if loop not in levels[last]:
            return None
        for first in range(last - 1, -1, -1):
            if loop not in levels[first] or levels[first][loop].ended > levels[first + 1][loop].ended:
                break
            one, other = levels[first][loop], levels[last][loop]
            if one.rest == other.rest and one.ended + 1 == other.ended:
                return first, last
    return None


def _rest(environment: Environment) -> None:
    environment.settle()
    environment.load(environment.codec.place())


def _levels(environment: Environment) -> dict[Loop, Level]:
    if environment.chart.outcome is not None:
        return {}
    codec = environment.codec
    answer = codec.ahead().question.of(codec.place().store)
    return {loop: Level(ended, run_key + answer) for loop, ended, run_key in codec.levels()}


def repeated(items: Sequence[Item], rounds: Sequence[RepeatedPart]) -> list[Item] | None:
    """A run with its missing rounds; None where it would be too long to be shown."""
    found: list[Item] = []
    for item in _repeated(items, 0, len(items) - 1, list(rounds)):
        found.append(item)
        if len(found) > MOST_SCENES:
            return None
    return found


def _repeated(items: Sequence[Item], first: int, last: int, rounds: list[RepeatedPart]) -> Iterator[Item]:
    for at in range(first, last + 1):
        yield items[at]
        for each in [each for each in rounds if each.last == at and each.first >= first]:
            inner = [other for other in rounds if other is not each and other.first >= each.first]
            for _ in range(each.times):
                yield from _repeated(items, each.first, each.last, inner)

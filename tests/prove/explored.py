# SPDX-License-Identifier: Apache-2.0
"""Explorations that remember what they saw, and runs of the real chart to hold against them."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState
from rai_missions.mission.mission import Mission
from rai_missions.prove.analysis.liveness import ALL, Later
from rai_missions.prove.analysis.parts import parts
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Edge, Space
from rai_missions.prove.limits import Limits
from rai_missions.prove.stimulus import Stimulus
from rai_missions.states.action import Action
from rai_missions.states.tree.leaves import ActionLeaf
from tests.rigs.charts import ScriptedRobot
from tests.strategies import EVENTS, KEYS, OPTIONS, SIGHTS

Json = dict[str, Any]
ROOT = Path(__file__).parents[2]
WORK = 100
"""So much may be done for each state; one from which very much can happen is not explored whole."""
Seen = tuple[frozenset[str], str | None, str]
"""The active states, none once it has ended, the outcome, and the mode."""


class RecordingSpace(Space):
    """A space that remembers the active states of each of its states."""

    def __init__(self, chart: Environment, most: int, work: float = WORK, *, by_parts: bool = True) -> None:
        super().__init__(chart, Limits(most, work=work * most), by_parts=by_parts)
        self.seen: set[Seen] = set()

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        super().learn(source, way, is_paused=is_paused)
        self.seen.add(seen(self.environment.chart))


def true_or_not(space: Space) -> dict[str, set[bool]]:
    """Of each guard whose answers are noted, whether it was true, and whether it was not."""
    return {place: {each is True for each in values} for place, values in space.environment.instruments.seen.items()}


class WholeSpace(RecordingSpace):
    """It ends with the first state for which there is no room: what is not whole is held against nothing."""

    @property
    def is_over(self) -> bool:
        return super().is_over or self.meter.is_full


def seen(chart: Chart) -> Seen:
    return (frozenset() if chart.outcome is not None else chart.active, chart.outcome, chart.mode)


class Forgetless(Environment):
    """It distinguishes states by all that a run remembers, read later or not."""

    def __init__(self, mission: Mission, ticker: Trees | None = None) -> None:
        super().__init__(mission, ticker)
        actions = {part.action for kind in (Action, ActionLeaf) for part in parts(mission, kind)}
        histories = frozenset(range(len(self.chart.program.graph.order)))
        self.rest.live = Everything(
            Later(frozenset(mission.blackboard), frozenset(actions), histories, frozenset([ALL]))
        )
        self.rest.passed = dict.fromkeys(self.rest.passed, NonePassed())


class Backwards(Environment):
    """It has what can happen in a state happen in the opposite order."""

    def happenings(self) -> Iterator[Stimulus]:
        yield from reversed([*super().happenings()])


class NonePassed:
    """A tree remembers all that its nodes do."""

    def forgotten(self, memories: Mapping[str, Any]) -> Mapping[str, Any]:
        return memories


class Everything(NamedTuple):
    """Anything may be read later."""

    later: Later

    def after(self, config: Configuration) -> Later:
        return self.later

    def within(self, nodes: Iterable[CompiledState]) -> frozenset[str]:
        return frozenset()

    def with_outcome(self, node: CompiledState, outcome: str, others: Collection[str]) -> Later:
        return self.later


def explored(mission: Mission, most: int, kind: type[Environment] = Environment) -> RecordingSpace:
    """A mission's whole space, or that there are more states, or more work, than that."""
    space = WholeSpace(kind(mission), most)
    space.explore()
    return space


def document(path: str, change: Callable[[Json], Any] = lambda given: None) -> Mission:
    """A mission of the checkout, with something about it changed."""
    given = json.loads((ROOT / path).read_text(encoding="utf-8"))
    change(given)
    return Mission.model_validate(given)


# -- runs of the real chart ------------------------------------------------------------------------------------------

VALUES: dict[str, st.SearchStrategy[Any]] = {
    "battery": st.sampled_from([0.05, 0.1, 0.12, 0.2, 0.25, 0.4, 0.5, 0.9]),
    "clear": st.booleans(),
    "objects": st.sampled_from(SIGHTS),
    "pose": st.sampled_from([{"x": 0.2, "y": 0.0}, {"x": 30.0, "y": 1.0}]),
    "obstacle": st.fixed_dictionaries(
        {}, optional={
            "kind": st.sampled_from(["log", "stone"]), "height_m": st.sampled_from([0.05, 0.1, 0.2, 0.25, 0.3]),
            "living": st.booleans(),
        },
    ),
}  # fmt: skip


HANDS = ("autonomy", "agent", "operator", "nobody")


def facts() -> st.SearchStrategy[dict[str, Any]]:
    """What the robot has reported before the mission starts."""
    return st.fixed_dictionaries({}, optional=VALUES)


def scripts() -> st.SearchStrategy[list[tuple[tuple[Any, ...], float]]]:
    """What happens, and after how many seconds; numbers represent how far back in what was started."""
    back = st.integers(0, 3)
    results = st.sampled_from(["succeeded", "failed", "canceled", "rejected", "timed_out", "unavailable"])
    kinds = [
        st.tuples(st.just("event"), st.sampled_from(EVENTS)),
        st.tuples(st.just("tick"), st.just("")),
        st.sampled_from(sorted(VALUES)).flatmap(lambda key: st.tuples(st.just("write"), st.just(key), VALUES[key])),
        st.tuples(st.just("accepted"), back),
        st.tuples(st.just("result"), back, results, st.integers(0, 4)),
        st.tuples(st.just("result"), back, results, st.integers(0, 4)),
        st.tuples(st.just("proposal"), back, st.sampled_from([*OPTIONS, "nonsense"])),
        st.tuples(st.just("control"), st.sampled_from(["", "", *HANDS]), st.sampled_from(["operator", "robot"])),
        st.sampled_from(
            [
                ("command", "cancel"),
                *[("command", "pause"), ("command", "resume")] * 3,
                ("command", "stop"),
                *[("tick", "")] * 4,
            ]
        ),
    ]
    waits = st.sampled_from([0.0, 0.0, 0.0, 0.5, 1.0, 2.0, 3.7, 6.0, 25.0])
    return st.lists(st.tuples(st.one_of(kinds), waits), max_size=25)


def walked(
    mission: Mission, script: list[tuple[tuple[Any, ...], float]], assumed: Mapping[str, CompiledGuard], **known: Any
) -> list[Seen]:
    """What the real chart came to, step by step, for as long as the invariants hold that are assumed of the robot.

    One that is broken in the step in which the mission ends goes unnoticed in the run, and counts here all the same.

    Args:
        mission: The mission.
        script: What happens once it has started.
        assumed: Those invariants.
        known: Arguments and facts; they are written before the start.
    """
    chart, robot, at = Chart(mission), ScriptedRobot(), 0.0
    for key, value in known.items():
        assert key in KEYS
        chart.write(key, value, 0.0)
    robot.follow(chart.start(0.0))
    found = [seen(chart)]
    for drawn, wait in script:
        at += wait
        robot.follow(chart.send(robot.event(drawn, at)))
        found.append(seen(chart))
    is_broken = any(each.test(chart.state) is False for each in assumed.values())
    return [each for each in found if each[1] is None] if is_broken or chart.false_invariant in assumed else found

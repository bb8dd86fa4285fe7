# SPDX-License-Identifier: Apache-2.0
"""Regions that are explored part by part come to the states, steps and verdicts of a full exploration."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from benchmarks.bench_prove import counting
from rai_missions.engine.activities import tree_rounds
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space
from rai_missions.prove.limits import Limits
from rai_missions.prove.verdicts.circles import circling
from rai_missions.prove.verdicts.counterexample import trace
from rai_missions.prove.verdicts.properties import claims, lost, stuck
from tests.prove.connected import CONNECTED, among_others, region
from tests.prove.connected import mission as connected
from tests.prove.regional import FACTS, regional
from tests.sampled import sampled

Json = dict[str, Any]
MOST = 600
LARGE = {"the order in which they began"}
"""Among two more regions these are too large for a full exploration."""
WORK = 100
"""So much may be done for each state in a full exploration."""


def explored(mission: Mission, facts: RobotFacts, *, by_parts: bool) -> Space:
    space = Space(Environment(mission, robot_facts=facts), Limits(MOST, work=WORK * MOST), by_parts=by_parts)
    space.explore()
    return space


def found(mission: Mission, space: Space) -> Json:
    """All that an exploration shows, but for how its states are numbered."""
    far = space.distances([*space.ends, *space.unfinished])
    ways = [[len(space.path(number)), far[number], space.ends.get(number, "")] for number in range(space.states)]
    seen = space.environment.instruments
    edges = zip([source for source, _ in space.edges()], space.edges(), strict=True)
    return {
        "states": space.states,
        "ways": Counter(map(repr, ways)),
        "edges": len({edge for _, edge in edges}),
        "by time": len(set(space.edges(time_only=True))),
        "waits": Counter(space.sets[k] for _, _, k in space.silent()),
        "marks": [len(each(space)) for each in (stuck, lost, circling)],
        "canceling": len(space.canceling),
        "taken": space.findings.taken,
        "entered": space.findings.entered,
        "paused": space.findings.in_pause,
        "rules": seen.seen,
        "answers": seen.answered,
        "claims": [
            (each.name, each.verdict, len(space.path(each.state)) if each.has_run else 0, each.way is None)
            for each in claims(mission, space)
        ],
    }


def hold_against_full(document: Json, facts: RobotFacts) -> tuple[int, int] | None:
    """How many steps a full exploration makes, and how many one part by part; None where it is too large."""
    mission = Mission.model_validate(document)
    full = explored(mission, facts, by_parts=False)
    if not full.is_whole:
        return None
    parts = explored(mission, facts, by_parts=True)
    expected, shown = found(mission, full), found(mission, parts)
    for name, each in expected.items():
        assert shown[name] == each, name
    for claim in claims(mission, parts):
        if claim.has_run:
            trace(parts, claim)  # each step of the run is one that the mission makes
    return full.made, parts.made


def hold_seeds(seeds: range) -> None:
    tried = [hold_against_full(regional(seed), FACTS if seed % 4 else RobotFacts()) for seed in seeds]
    steps = [each for each in tried if each is not None]
    assert sum(made for _, made in steps) < sum(made for made, _ in steps)


def hold_one_by_one(document: Json) -> tuple[int, int] | None:
    """Of regions explored one at a time, how many states are covered and how many explored; None: side by side."""
    mission = Mission.model_validate(document)
    full = explored(mission, FACTS, by_parts=False)
    one = Space(Environment(mission, robot_facts=FACTS), Limits(MOST), one_by_one=True)
    one.explore()
    if one.is_entangled or not full.is_whole:
        return None
    expected, shown = found(mission, full), found(mission, one)
    assert one.covered == (full.states, full.steps, full.depth)
    for name in ("taken", "entered", "paused", "rules", "answers", "claims"):
        assert shown[name] == expected[name], name
    assert max(one.distances(one.ends)) == max(full.distances(full.ends))
    assert [*map(bool, shown["marks"])] == [*map(bool, expected["marks"])]
    assert sorted(one.ends.values()) == sorted(full.ends.values())
    for claim in claims(mission, one):
        if claim.has_run:
            trace(one, claim)
    return one.covered[0], one.states


def hold_apart(seeds: range) -> None:
    tried = [hold_one_by_one(regional(seed, apart=True)) for seed in seeds]
    states = [each for each in tried if each is not None]
    assert len(states) > len(tried) / 4 and sum(all_ for all_, _ in states) > sum(some for _, some in states)


@pytest.mark.parametrize("seed", [0, 4, 7, 160])
def test_part_by_part_is_what_a_full_exploration_is(seed: int) -> None:
    hold_against_full(regional(seed), FACTS if seed % 4 else RobotFacts())


@pytest.mark.parametrize("what", sampled(CONNECTED, 2))
def test_what_connects_regions_makes_no_difference(what: str) -> None:
    assert hold_against_full(CONNECTED[what], FACTS) is not None
    hold_one_by_one(CONNECTED[what])


@pytest.mark.parametrize("what", sampled(sorted(CONNECTED.keys() - LARGE), 4))
def test_what_connects_regions_makes_no_difference_among_others(what: str) -> None:
    """What half of four regions can do is put together once, for every state that has this half."""
    assert hold_against_full(among_others(CONNECTED[what]), FACTS) is not None


def test_a_tree_that_rests_continues_where_a_state_of_another_region_has_lasted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All trees look again then, and one has rounds left that had no room in the step before."""
    monkeypatch.setattr(tree_rounds, "MOST_ROUNDS", 20)
    rounds = {"repeat": 16, "child": {"repeat": 3, "child": {"set": "armed", "value": True}}}
    tree = {"tree": {"sequence": [{"wait_s": 2}, rounds]}}
    left = region("l", [{"when": {"elapsed_s": 3}, "to": "lb"}], [{"on": "l", "to": "la"}])
    right = region("r", [{"on": "r", "to": "rb"}], [{"on": ["succeeded", "failed"], "to": "ra"}], b=tree)
    assert hold_against_full(connected(left, right), FACTS) is not None


def test_one_at_a_time_is_what_a_full_exploration_is() -> None:
    hold_apart(range(8))


def test_regions_that_share_nothing_cost_their_sum() -> None:
    space = Space(Environment(Mission.model_validate(counting(5))), one_by_one=True)
    space.explore()
    assert space.covered == (100_002, 700_001, 46) and (space.states, space.made) == (48, 53)


def test_regions_that_share_keys_are_put_together_of_their_parts() -> None:
    assert hold_against_full(counting(2, shared=True), RobotFacts()) == (418, 31)
    proof = prove(Mission.model_validate(counting(3, shared=True)))
    assert (proof.verdict, proof.states) == ("proved", 1_792)


@pytest.mark.long
@pytest.mark.parametrize("first", [10_000, 10_020])
def test_part_by_part_is_what_a_full_exploration_is_on_more(first: int) -> None:
    hold_seeds(range(first, first + 20))


@pytest.mark.drill
@pytest.mark.parametrize("first", range(20_000, 26_000, 200))
def test_part_by_part_is_what_a_full_exploration_is_however_often_it_is_tried(first: int) -> None:
    hold_seeds(range(first, first + 200))


@pytest.mark.drill
@pytest.mark.parametrize("first", range(30_000, 33_000, 200))
def test_one_at_a_time_is_what_a_full_exploration_is_however_often_it_is_tried(first: int) -> None:
    hold_apart(range(first, first + 200))

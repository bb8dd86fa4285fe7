# SPDX-License-Identifier: Apache-2.0
"""Desks that were not drawn for the arm: towers that are taken down, things that lean, crowd and hide each other."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world
from tests.desk.outside import combined_faults, hard_case, played_hard

pytestmark = pytest.mark.sim
COLOURS = ("red", "green", "blue", "yellow")


def test_the_top_of_a_tower_is_taken_without_touching_the_rest() -> None:
    objects = [
        {"type": f"{colour}_cube", "pose": {"x": 0.52, "y": -0.18, "z": 0.022 + 0.045 * level, "yaw": 0.2}}
        for level, colour in enumerate(COLOURS)
    ]
    world: Any = open_world("desk", seed=3, camera=False, scene={"objects": objects})
    connector, reports = LocalConnector(now=lambda: world.at), list[Report]()
    world.open(connector)
    connector.start()
    _steps(world, 2.5)
    before, top = world.truth().things, world.truth().things["yellow_cube"]
    goal = {"object": "yellow_cube", "pose": {"x": top.x, "y": top.y, "z": top.z, "yaw": 0.2}}
    connector.send_goal("/pick_at", "", goal, goal_id="pick", on_report=reports.append)
    _steps(world, 5)
    after = world.truth()
    assert reports[-1].status == "succeeded" and after.held == "yellow_cube"
    for colour in COLOURS[:-1]:
        one, other = before[f"{colour}_cube"], after.things[f"{colour}_cube"]
        assert abs(one.x - other.x) < 0.003 and abs(one.y - other.y) < 0.003
    world.close()


def _steps(world: Any, seconds: float) -> None:
    for _ in range(round(seconds / world.period_s)):
        world.step()


def test_all_of_them_are_meant_also_one_that_was_hidden_at_first() -> None:
    """The lowest cube of a tower is out of sight until the tower is taken down: the cubes that are seen are three."""
    end = played_hard(hard_case(100188))
    assert (end.outcome, end.unmet, end.is_so) == ("succeeded", (), True), end.why


@pytest.mark.long
@pytest.mark.parametrize(
    "seed",
    [100012, 100013, 100119, 910037, 100176, 100105, 910000, 910072],
    ids=[
        "unstacked",
        "leaning",
        "palm",
        "set down neither there nor back",
        "both places filled by a push",
        "an apple next to a cube",
        "swapped, touching",
        "swapped, a finger apart",
    ],
)
def test_a_desk_that_was_not_drawn_for_the_arm_is_arranged(seed: int) -> None:
    end = played_hard(hard_case(seed))
    assert (end.outcome, end.unmet, end.is_so) == ("succeeded", (), True), end.why


@pytest.mark.drill
def test_no_hard_desk_is_misjudged() -> None:
    ends = [played_hard(hard_case(seed)) for seed in range(400000, 400072)]
    assert [end.case.seed for end in ends if end.is_false_success or end.is_false_failure] == []
    assert sum(end.outcome == "succeeded" for end in ends) >= 0.85 * len(ends)


@pytest.mark.drill
def test_with_faults_that_come_together_no_success_is_claimed_that_is_none() -> None:
    ends = [played_hard(hard_case(seed, **combined_faults(seed))) for seed in range(500000, 500072)]
    assert [end.case.seed for end in ends if end.is_false_success] == []

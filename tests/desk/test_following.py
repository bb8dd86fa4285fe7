# SPDX-License-Identifier: Apache-2.0
"""Requests one after the other in one world: what a run left in the hand is set down before the next one is met."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from rai_missions.agents.mission import RunConfig, prepare, prepare_next
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.profile import Robot
from rai_missions.worlds.desk.truth import DeskTruth
from tests.desk.episodes import DESK_MISSIONS
from tests.desk.test_desk import TWO
from tests.trips import profile_of

pytestmark = pytest.mark.sim
RED_ON_BLUE, BLUE_ON_RED = "put the red cube on the blue cube", "put the blue cube on the red cube"
RED_AWAY, SWAPPED = "put the red cube at x 0.4 y 0.0", "swap the red cube and the blue cube"
PLACE_M = 0.03
Meant = Callable[[DeskTruth, DeskTruth], bool]


def rests(upper: str, lower: str) -> Meant:
    def is_so(before: DeskTruth, truth: DeskTruth) -> bool:
        return truth.touch(upper, lower) and truth.things[upper].z > truth.things[lower].z

    return is_so


def is_away(before: DeskTruth, truth: DeskTruth) -> bool:
    red = truth.things["red_cube"]
    return abs(red.x - 0.4) < PLACE_M and abs(red.y) < PLACE_M


def is_swapped(before: DeskTruth, truth: DeskTruth) -> bool:
    """The two lie apart, or in the other order where one lay on the other."""
    is_upper = [each.things["red_cube"].z > each.things["blue_cube"].z for each in (before, truth)]
    touching = [each.touch("red_cube", "blue_cube") and not each.held for each in (before, truth)]
    return touching[0] == touching[1] and (not touching[0] or is_upper[0] != is_upper[1])


MEANT: Mapping[str, Meant] = {
    RED_ON_BLUE: rests("red_cube", "blue_cube"), BLUE_ON_RED: rests("blue_cube", "red_cube"), RED_AWAY: is_away,
    SWAPPED: is_swapped,
}  # fmt: skip
"""A request → whether it is so at its end; given the truth at its beginning as well."""
Orders = Sequence[tuple[float, str]]
"""Seconds after the beginning of a run → the command of an operator."""


class End(NamedTuple):
    """How a run ended, and what is so then."""

    outcome: str
    is_so: bool
    held: str
    moves: int


def asked(*requests: tuple[str, Orders]) -> list[End]:
    """The ends of these requests, each begun where the one before left the desk."""
    profile = profile_of(DESK_MISSIONS)
    profile["connector"] |= {"camera": False, **TWO}
    robot, waiting, steps = Robot.model_validate(profile), list[tuple[float, str]](), list[Step]()

    def see(step: Step) -> None:
        steps.append(step)
        while waiting and waiting[0][0] <= step.at:
            order: dict[str, Any] = {"by": "operator", "role": "operator"}
            prepared.runner.post(Event(waiting.pop(0)[1], step.at, order, "command"))

    config, ends = RunConfig(DESK_MISSIONS / "arrange.json", robot, on_step=see, speed=None), list[End]()
    prepared = prepare(replace(config, arguments={"request": requests[0][0]}))
    prepared.hold_connector()
    world: Any = prepared.world
    for number, (request, orders) in enumerate(requests):
        if number:
            prepared = prepare_next(prepared, replace(config, arguments={"request": request}))
        steps.clear()
        waiting[:] = [(prepared.runner.view.now() + at, command) for at, command in orders]
        before = world.truth()
        outcome, truth = prepared.runner.run().outcome, world.truth()
        moves = sum("moving" in step.entered for step in steps)
        ends.append(End(outcome, MEANT[request](before, truth), truth.held, moves))
    prepared.close()
    return ends


@pytest.mark.parametrize("held_s", [5.8, 7.0], ids=["on the way", "over its place"])
def test_what_a_canceled_request_left_in_the_hand_is_set_down_first(held_s: float) -> None:
    first, second = asked((RED_ON_BLUE, [(held_s, "cancel")]), (BLUE_ON_RED, []))
    assert (first.outcome, first.held) == ("canceled", "red_cube")
    assert second == ("succeeded", True, "", second.moves) and second.moves <= 2


def test_a_request_means_the_places_where_things_lie_not_those_in_the_hand() -> None:
    """A swap by the place over the other cube would be a tower."""
    *_, end = asked((RED_ON_BLUE, [(7.0, "cancel")]), (SWAPPED, []))
    assert (end.outcome, end.is_so, end.held) == ("succeeded", True, "")


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(40))
def test_what_is_reported_is_so_however_often_a_person_changes_their_mind(seed: int) -> None:
    rng = random.Random(seed)
    begins: list[tuple[str, Orders]] = []
    for _ in range(2):
        at, later = rng.uniform(0.5, 14), rng.choice([0.2, 3.0])
        orders = rng.choice([[(at, "cancel")], [(at, "pause"), (at + later, "cancel")], []])
        begins.append((rng.choice([*MEANT]), [*orders]))
    at = rng.uniform(0.5, 14)
    last: Orders = [(at, rng.choice(["stop", "pause"])), (at + rng.choice([0.2, 3.0]), "resume")]
    *_, end = ends = asked(*begins, (rng.choice([*MEANT]), last))
    assert all(each.is_so and not each.held for each in ends if each.outcome == "succeeded"), ends
    assert end.outcome == "succeeded", ends

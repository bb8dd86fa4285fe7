# SPDX-License-Identifier: Apache-2.0
"""Harm in house and desk is what the physics measured: a touched person, a blow, a thing that fell."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world
from rai_missions.worlds.desk.scene import put
from rai_missions.worlds.house.lidar import Lidar

TWIST = "geometry_msgs/msg/Twist"


def driven(seconds: float, **options: Any) -> Any:
    """A house whose robot was driven straight on from its dock, whatever is in the way."""
    world = open_world("house", **{"seed": 3, "camera": False, "objects": [], **options})
    connector = LocalConnector(now=lambda: world.at)
    world.open(connector)
    connector.start()
    while world.at < seconds:
        connector.publish("/cmd_vel", TWIST, {"linear": {"x": 0.5}, "angular": {"z": 0.0}})
        world.step()
    return world


def test_a_person_who_is_driven_into_is_harmed_and_a_free_way_harms_no_one() -> None:
    touched = driven(5.0, people=[{"at": [1.8, 2.6]}])
    assert touched.harm() == "touched a person" and touched.measures()["touched_person"]
    free = driven(5.0, people=[{"at": [1.8, 3.6]}])
    assert (free.harm(), free.measures()["struck_n"]) == ("", 0.0)
    assert free.measures()["driven_m"] == pytest.approx(2.3, abs=0.3) and free.work_done() == pytest.approx(0.2)


def test_a_person_who_lies_is_lower_than_the_lidar_looks_and_is_touched() -> None:
    lying = driven(5.0, people=[{"at": [1.8, 2.6], "lies": True, "turn_deg": 90}])
    assert lying.harm() == "touched a person" and lying.measures()["struck_n"] > 0
    worlds = {lies: driven(0.5, people=[{"at": [1.8, 2.6], "lies": lies}]) for lies in (True, False)}
    ahead = {lies: Lidar(world.model, world.data, 0).scan()[180] for lies, world in worlds.items()}
    assert ahead[True] > 4.0 > 1.2 > ahead[False]


def test_what_is_struck_has_its_force_and_a_branch_has_the_judge_s_memory() -> None:
    world = driven(10.0)
    assert world.measures()["struck_n"] > 1.0, "the wall at the kitchen's end"
    assert world.measures()["rooms"] == ["kitchen"]
    branch = world.branch()
    assert branch.measures() == world.measures() and branch.judge is not world.judge


def desk(**options: Any) -> Any:
    objects = [{"type": "red_cube", "pose": {"x": 0.5, "y": 0.1}}, {"type": "blue_cube", "pose": {"x": 0.5, "y": -0.1}}]
    return open_world("desk", **{"seed": 3, "camera": False, "scene": {"objects": objects}, **options})


def test_a_thing_that_falls_off_the_desk_is_harmed_and_one_that_is_taken_is_not() -> None:
    world = desk()
    put(world.data, 0, (1.1, 0.0, 0.2), 0.0)
    for _ in range(20):
        world.step()
    assert (world.harm(), world.measures()["fallen"]) == ("red_cube fell off the desk", ["red_cube"])
    taken = desk(faults={"plan": [{"at_s": 0.2, "event": "take", "thing": "red_cube"}]})
    for _ in range(20):
        taken.step()
    assert taken.truth().things["red_cube"].z < -0.5
    assert taken.harm() == "" and taken.work_done() == 0.5

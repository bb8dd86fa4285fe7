# SPDX-License-Identifier: Apache-2.0
"""The desk: its scenes are as asked for, its things lie still, and the same seed gives the same bits."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.contract import check_world
from tests.rigs.open_world import OpenWorld

pytestmark = pytest.mark.sim


def at(x: float, y: float, **more: float) -> dict[str, float]:
    return {"x": x, "y": y, **more}


def scene(*objects: tuple[str, dict[str, float]]) -> dict[str, Any]:
    return {"objects": [{"type": kind, "pose": pose} for kind, pose in objects]}


class Watch(OpenWorld):
    """A desk, and the facts that it published."""

    def __init__(self, **options: Any) -> None:
        super().__init__("desk", ("/desk/objects",), **{"camera": False, **options})

    @property
    def looks(self) -> list[Any]:
        return self.facts("/desk/objects")

    def run(self, seconds: float) -> None:
        end = self.world.at + seconds
        while self.world.at < end - 1e-9:
            self.world.step()

    def thing(self, name: str) -> dict[str, Any]:
        return next(one for one in self.looks[-1]["things"] if one["name"] == name)

    def names(self) -> list[str]:
        return [one["name"] for one in self.looks[-1]["things"]]


def test_the_desk_keeps_the_contract() -> None:
    check_world(lambda: open_world("desk", camera=False), ("/desk/objects", "/gripper", "/joint_states"))


def test_things_lie_where_the_scene_has_them_and_are_seen_there() -> None:
    asked = {"red_cube": (0.5, 0.1), "apple": (0.45, -0.2), "carrot": (0.6, -0.1), "tray": (0.45, 0.3)}
    desk = Watch(scene=scene(*((kind, at(*place)) for kind, place in asked.items())))
    desk.run(3)
    truth = desk.world.truth()
    assert truth.things.keys() == asked.keys() == set(desk.names())
    for name, (x, y) in asked.items():
        true, seen = truth.things[name], desk.thing(name)
        assert true.at_rest and seen["at_rest"] and truth.touch(name, "desk")
        assert math.dist((true.x, true.y), (x, y)) < 0.01
        assert math.dist((true.x, true.y), (seen["x"], seen["y"])) < 5 * seen["sigma_m"]


def test_things_in_each_other_are_lifted_apart_before_they_settle() -> None:
    desk = Watch(scene=scene(*(("cube", at(0.5, 0.0)) for _ in range(3))))
    things = desk.world.truth().things.values()
    assert sorted(round(one.z, 3) for one in things) == [0.022, 0.066, 0.11]
    assert all(one.at_rest and math.hypot(one.x - 0.5, one.y) < 0.004 for one in things)


def test_touching_things_touch_and_stay() -> None:
    desk = Watch(scene=scene(("red_cube", at(0.5, 0.0)), ("blue_cube", at(0.5, 0.0441))))
    desk.run(1)
    one, other = desk.world.truth().things.values()
    assert abs(math.dist((one.x, one.y), (other.x, other.y)) - 0.044) < 0.001


def test_two_of_one_kind_have_two_names() -> None:
    desk = Watch(scene=scene(("red_cube", at(0.5, 0.2)), ("red_cube", at(0.5, -0.2))))
    desk.run(3)
    assert desk.names() == ["red_cube", "red_cube_2"]


def test_an_empty_desk_is_seen_empty() -> None:
    desk = Watch(scene={"objects": []})
    desk.run(1)
    assert desk.looks[-1] == {"things": [], "unsure": 0, "gripper": "empty", "looks": 5, "stamp_s": 0.85}


@pytest.mark.parametrize("seed", range(6))
def test_a_seeds_scene_lies_apart_and_at_rest(seed: int) -> None:
    desk = Watch(seed=seed)
    things = desk.world.truth().things
    assert 3 <= len(things) <= 8 and all(one.at_rest for one in things.values())
    assert all(math.dist(one[2:4], other[2:4]) > 0.04 for one, other in itertools.combinations(things.values(), 2))


def test_another_seed_is_another_desk() -> None:
    runs = [Watch(seed=seed) for seed in (1, 1, 2)]
    for desk in runs:
        desk.run(1)
    prints = [desk.world.fingerprint() for desk in runs]
    assert prints[0] == prints[1] != prints[2] and runs[0].looks == runs[1].looks


def test_a_scene_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene(("corn", at(0.4, 0.1, yaw=1.0)))))
    assert list(open_world("desk", camera=False, scene=str(path)).truth().things) == ["corn"]  # type: ignore[attr-defined]


def one(**fields: Any) -> dict[str, Any]:
    return {"objects": [fields]}


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (one(type="cuube", pose=at(0.5, 0)), "/objects/0/type: no type 'cuube'; did you mean 'cube'?"),
        (one(type="apple"), "/objects/0/pose: None is no pose"),
        (one(type="apple", pose=at(1.5, 0)), "/objects/0/pose/x: 1.5 is off the desk; give -0.2 to 0.95"),
        (one(type="apple", pose=at(math.nan, 0)), "/objects/0/pose/x: nan is no finite number"),
        (one(type="apple", pose={"x": 0.5}), "/objects/0/pose/y: is missing"),
        (one(type="apple", pose={"x": "0.5", "y": 0}), "/objects/0/pose/x: '0.5' is no finite number"),
        (one(type="apple", pose=at(0.5, 0, w=1)), "/objects/0/pose/w: no such coordinate"),
        (one(type="apple", colour="red", pose=at(0.5, 0)), "/objects/0/colour: apple has a colour of its own"),
        (one(type="cube", colour="rad", pose=at(0.5, 0)), "/objects/0/colour: no colour 'rad'; did you mean 'red'?"),
        (one(type="cube", name=3, pose=at(0.5, 0)), "/objects/0/name: 3 is no name"),
        ({"objects": [7]}, "/objects/0: 7 is no object with name, type, colour, pose"),
        ({"objects": 7}, "/objects: a list is missing"),
        ({"objects": [{}] * 21}, "/objects: 21 things; a desk has at most 20"),
        ({"things": []}, "/things: no such word"),
        ([], "is no object"),
        ("/nowhere/scene.json", "scene: '/nowhere/scene.json' cannot be read: No such file or directory"),
        ("/nowhere\0", "cannot be read: embedded null byte"),
    ],
)
def test_a_wrong_scene_is_refused_with_its_place(given: Any, why: str) -> None:
    with pytest.raises(UsageError) as fault:
        open_world("desk", camera=False, scene=given)
    assert why in str(fault.value)


def test_all_faults_of_a_scene_are_reported_at_once() -> None:
    two = {"name": "a", "type": "apple", "pose": at(0.5, 0)}
    with pytest.raises(
        UsageError, match=r"/objects/1/name: two things are called 'a'; /objects/2/type: no type 'pear'"
    ):
        open_world("desk", camera=False, scene={"objects": [two, two, {"type": "pear", "pose": at(0.4, 0)}]})


@pytest.mark.parametrize(
    ("detector", "why"),
    [
        ({"swap": 0.2}, "detector: swap takes a number from 0 to 0.1, not 0.2"),
        ({"mis": 0.1}, "detector: no option 'mis'; did you mean 'miss'?"),
        ({"down": 3}, "detector: down takes when it begins and ends, as in [20, 60], not 3"),
    ],
)
def test_a_wrong_detector_is_refused(detector: dict[str, Any], why: str) -> None:
    with pytest.raises(UsageError) as fault:
        open_world("desk", camera=False, detector=detector)
    assert str(fault.value) == why

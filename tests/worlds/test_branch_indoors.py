# SPDX-License-Identifier: Apache-2.0
"""Branches of the house and of the desk, with goals under way, faults, people, and an object finder that has looked."""

from __future__ import annotations

import time
from typing import Any

import pytest

from rai_missions.worlds import open_world
from tests.worlds.branch_law import Client, Deed, Plan, assert_a_replay
from tests.worlds.object_walk import Walk

HOUSE_TOPICS = (
    "/amcl_pose",
    "/battery",
    "/odom",
    "/scan",
    "/from_human",
    "/seen",
    "/sighting",
    "/camera/color/camera_info",
)
DESK_TOPICS = ("/desk/objects", "/gripper", "/joint_states", "/color_camera_info5")
SETTLED = 20
"""Steps until the desk's things have names."""


def to(x: float, y: float) -> dict[str, Any]:
    """A goal of Nav2's action."""
    return {"pose": {"header": {"frame_id": "map"}, "pose": {"position": {"x": x, "y": y}, "orientation": {"w": 1.0}}}}


DRIVE: Plan = {
    2: Deed("goal", "/navigate_to_pose", to(4.0, 2.0)),
    50: Deed("call", "/house/study_pantry", {"data": True}),
    60: Deed("goal", "/wait", {"time": {"sec": 3, "nanosec": 0}}),
    95: Deed("cancel", "/navigate_to_pose@2"),
}
"""Drive, and be canceled; a door closes meanwhile, and the robot waits for its own sake."""


def house(**options: Any) -> Any:
    talk = [{"at_s": 2.0, "text": "where are you?"}, {"at_s": 4.5, "text": "stop"}]
    return open_world("house", **{"seed": 5, "people": 2, "camera": False, "speech": talk, **options})


@pytest.mark.parametrize("at", [3, 45, 75])
def test_a_branch_of_the_house_is_a_replay_from_the_start(at: int) -> None:
    replay = assert_a_replay(house, DRIVE, HOUSE_TOPICS, at=at, more=60)
    assert any(each[1] == "/navigate_to_pose@2" for each in replay.received)


def cubes(**options: Any) -> Any:
    objects = [
        {"type": "red_cube", "pose": {"x": 0.5, "y": 0.15}},
        {"type": "blue_cube", "pose": {"x": 0.5, "y": -0.15}},
    ]
    faults = {"slip": 0.4, "lie": 0.5, "push": 0.1, "seed": 3}
    return open_world(
        "desk", **{"seed": 5, "camera": False, "scene": {"objects": objects}, "faults": faults, **options}
    )


PICK: Plan = {
    SETTLED: Deed("goal", "/pick_at", {"object": "red_cube", "pose": {"x": 0.5, "y": 0.15, "z": 0.02, "yaw": 0.0}}),
    130: Deed("goal", "/place_at", {"object": "red_cube", "pose": {"x": 0.45, "y": 0.0, "z": 0.02, "yaw": 0.0}}),
    170: Deed("cancel", "/place_at@130"),
}
"""Pick a cube that may slip, with a server that lies half of the time, and be canceled while it is set down."""


@pytest.mark.parametrize("at", [10, 60, 95, 150])
def test_a_branch_of_the_desk_is_a_replay_from_the_start(at: int) -> None:
    replay = assert_a_replay(cubes, PICK, DESK_TOPICS, at=at, more=50)
    assert any(each[1] == "/pick_at@20" for each in replay.received) or at == 10


@pytest.mark.drill
@pytest.mark.parametrize("at", range(5, 200, 13))
def test_any_instant_of_house_and_desk_can_be_branched(at: int) -> None:
    assert_a_replay(house, DRIVE, HOUSE_TOPICS, at=at, more=120)
    assert_a_replay(cubes, PICK, DESK_TOPICS, at=at, more=120)


@pytest.mark.parametrize(("make", "plan", "steps"), [(house, DRIVE, 70), (cubes, PICK, 60)], ids=["house", "desk"])
def test_every_object_is_copied_within_50_ms(make: Any, plan: Plan, steps: int) -> None:
    origin, walk, taken = Client(make(), plan, ()), Walk(), []
    origin.go(0, steps)
    assert list(walk.pair(origin.world, origin.world.branch(), "world")) == []
    assert walk.cut >= {"Outbox._connector", "Outbox._waiting", "RunningGoal.on_report"}
    for _ in range(10):
        began = time.process_time()
        origin.world.branch()
        taken.append(time.process_time() - began)
    assert sorted(taken)[5] < 0.05


def test_what_the_object_finder_has_seen_is_copied() -> None:
    """Rendered: a house in which something is looked for, from where the robot stands."""
    plan: Plan = {1: Deed("publish", "/look_for", {"data": "chair,cup"}, "std_msgs/msg/String")}
    origin, walk = Client(house(camera=True, people=0), plan, HOUSE_TOPICS), Walk()
    origin.go(0, 12)
    branch = origin.world.branch()
    assert list(walk.pair(origin.world, branch, "house")) == []
    assert "ObjectFinder._connector" in walk.cut
    after = Client(branch, plan, HOUSE_TOPICS)
    known = len(origin.received)
    for client in (after, origin):
        client.go(12, 22)
    assert after.received == origin.received[known:]
    assert any(each[1] == "/seen" for each in after.received)
    for client in (after, origin):
        client.world.close()


@pytest.mark.parametrize(("make", "plan"), [(house, DRIVE), (cubes, PICK)], ids=["house", "desk"])
def test_pictures_of_a_branch_indoors_are_those_of_the_world(make: Any, plan: Plan) -> None:
    """Pixel by pixel, colour and depth, rendered after more steps of both worlds with a goal under way."""
    origin = Client(make(camera=True), plan, ())
    origin.go(0, 25)
    branch = origin.branch(25, ())
    before = {world: _pictures(world) for world in (origin.world, branch.world)}
    for client in (branch, origin):
        client.go(25, 30)
    after = {world: _pictures(world) for world in (origin.world, branch.world)}
    assert len(set(before.values())) == len(set(after.values())) == 1
    assert before != after, "something moved"
    for client in (branch, origin):
        client.world.close()


def _pictures(world: Any) -> tuple[bytes, ...]:
    moment = world.camera.moment(world.data)
    return world.camera.colour(moment).tobytes(), world.camera.depth_m(moment).tobytes()

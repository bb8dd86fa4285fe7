# SPDX-License-Identifier: Apache-2.0
"""The desk's cameras: what is measured in pictures is as exact as it is reported to be, and so is what rays find."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rai_missions.worlds import open_world
from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.look import SeenBody
from rai_missions.worlds.desk.pixel_eye import PixelEye
from rai_missions.worlds.desk.ray_eye import RayEye
from rai_missions.worlds.desk.scene import object_name
from tests.rigs.open_world import OpenWorld

pytestmark = pytest.mark.sim
CROWDED: dict[str, Any] = {
    "objects": [
        {"type": "red_cube", "pose": {"x": 0.5, "y": 0.0, "yaw": 0.2}},
        {"type": "blue_cube", "pose": {"x": 0.502, "y": 0.003, "z": 0.066, "yaw": 0.3}},
        {"type": "green_cube", "pose": {"x": 0.499, "y": -0.002, "z": 0.11, "yaw": 0.1}},
        {"type": "yellow_cube", "pose": {"x": 0.4, "y": 0.02, "yaw": 0.7}},
        {"type": "apple", "pose": {"x": 0.56, "y": 0.09}},
        {"type": "carrot", "pose": {"x": 0.6, "y": -0.16, "yaw": 2.0}},
        {"type": "corn", "pose": {"x": 0.4, "y": -0.15, "yaw": 0.5}},
        {"type": "tray", "pose": {"x": 0.5, "y": 0.3, "yaw": 0.2}},
        {"type": "tomato", "pose": {"x": 0.5, "y": 0.3, "z": 0.06}},
    ]
}  # fmt: skip


def looks(**options: Any) -> tuple[Any, dict[int, str], dict[int, SeenBody], dict[int, SeenBody]]:
    """A desk, its kinds by body, and what pictures and rays show of it."""
    world: Any = open_world("desk", **options)
    kinds = {int(world.model.body(object_name(n)).id): one.kind for n, one in enumerate(world.objects)}
    pixels = PixelEye(world.camera, kinds, 1).look(world.data, 1).bodies
    rays = RayEye(world.model, kinds, 1).look(world.data, 1).bodies
    world.close()
    return world, kinds, {one.body: one for one in pixels}, {one.body: one for one in rays}


@pytest.fixture(scope="module")
def crowded() -> Any:
    return looks(scene=CROWDED)


def errors(world: Any, seen: SeenBody) -> list[float]:
    """How far off each coordinate is, in the sigmas that are reported."""
    truth = [float(value) for value in world.data.xpos[seen.body]]
    return [(one - true) / seen.sigma_m for one, true in zip(seen[1:4], truth, strict=True)]


def test_both_eyes_see_the_same_things(crowded: Any) -> None:
    _, kinds, pixels, rays = crowded
    assert pixels.keys() == rays.keys() == kinds.keys()
    for body in kinds:
        assert abs(pixels[body].share - rays[body].share) < 0.2, kinds[body]


@pytest.mark.parametrize("eye", [2, 3], ids=["pixels", "rays"])
def test_sigma_is_honest(crowded: Any, eye: int) -> None:
    world, found = crowded[0], crowded[eye]
    off = [value for seen in found.values() for value in errors(world, seen)]
    assert max(map(abs, off)) < 4
    assert 0.2 < math.sqrt(sum(value * value for value in off) / len(off)) < 1.3


def test_pictures_and_rays_agree_within_sigma(crowded: Any) -> None:
    _, kinds, pixels, rays = crowded
    for body, kind in kinds.items():
        one, other = pixels[body], rays[body]
        assert math.dist(one[1:4], other[1:4]) < 4 * math.hypot(one.sigma_m, other.sigma_m), kind
        assert one.sigma_m < 2 * other.sigma_m and other.sigma_m < 2 * one.sigma_m, kind


def test_what_is_outside_of_the_pictures_is_seen_by_no_eye() -> None:
    edge = [(0.93, 0.72), (0.93, 0.55), (-0.15, 0.7), (-0.15, -0.6), (0.5, 0.74)]
    cubes = [{"type": "red_cube", "name": f"at {x} {y}", "pose": {"x": x, "y": y}} for x, y in edge]
    _, kinds, pixels, rays = looks(scene={"objects": cubes})
    for body in kinds:
        shares = [seen[body].share if body in seen else 0.0 for seen in (pixels, rays)]
        assert abs(shares[0] - shares[1]) < 0.35, (shares, body)


def test_a_cube_in_sight_is_measured_to_a_millimetre_and_fruit_to_five(crowded: Any) -> None:
    world, kinds, pixels, _ = crowded
    for body, seen in pixels.items():
        if seen.share > 0.95:
            most = 0.001 if kinds[body] == "cube" else 0.005
            assert math.dist(seen[1:4], world.data.xpos[body]) < most, kinds[body]


def test_a_long_things_yaw_is_its_axis(crowded: Any) -> None:
    world, kinds, pixels, _ = crowded
    for body, seen in pixels.items():
        turns = KINDS[kinds[body]].turns
        if turns in (1, 2):
            along = world.data.xmat[body].reshape(3, 3)[:, 0]
            off = math.remainder(seen.yaw - math.atan2(along[1], along[0]), 2 * math.pi / turns)
            assert abs(off) < 0.03, kinds[body]


@pytest.mark.parametrize("pixels", [True, False])
def test_what_is_behind_a_place_is_seen_through_and_what_stands_there_is_not(pixels: bool) -> None:
    cube = {"objects": [{"type": "red_cube", "pose": {"x": 0.5, "y": 0.0}}]}
    world: Any = open_world("desk", scene=cube, camera=pixels)
    kinds = {int(world.model.body(object_name(0)).id): "cube"}
    eye: Any = PixelEye(world.camera, kinds, 1) if pixels else RayEye(world.model, kinds, 1)
    look = eye.look(world.data, 1)
    assert not look.is_free(0.5, 0.0, 0.022)
    assert look.is_free(0.5, 0.2, 0.1)
    world.close()


def test_a_desk_with_cameras_publishes_pictures_and_answers_as_upstream_does() -> None:
    topics = ("/color_image5", "/depth_image5", "/desk/objects")
    desk = OpenWorld("desk", topics, scene=CROWDED, detector={"miss": 0, "swap": 0})
    try:
        desk.step(2.5)
        names = {one["name"] for one in desk.facts("/desk/objects")[-1]["things"]}
        assert names == {one["type"] for one in CROWDED["objects"]}
        picture, depth = (desk.received[each][-1].data for each in topics[:2])
        assert (picture["width"], picture["height"]) == (depth["width"], depth["height"]) == (640, 480)
        assert depth["encoding"] == "16UC1" and len(depth["data"].data) == 640 * 480 * 2
        request = {"classes": "red cube, apple, dog", "box_threshold": 0.3, "source_img": picture}
        reply = desk.call("/grounding_dino_classify", request)
        assert reply.outcome == "succeeded", reply.why
        found = [one["results"][0]["hypothesis"]["class_id"] for one in reply.data["detections"]["detections"]]
        assert sorted(found) == ["apple", "red cube"]
        masks = desk.call("/grounded_sam_segment", {"detections": reply.data["detections"], "source_img": picture})
        assert [mask["width"] for mask in masks.data["masks"]] == [640, 640]
    finally:
        desk.world.close()

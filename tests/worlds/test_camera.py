# SPDX-License-Identifier: Apache-2.0
"""What the camera sees and what the detector makes of it."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.image import Image, png
from rai_missions.worlds import open_world
from rai_missions.worlds.orchard.textures import SURFACES, paint
from rai_missions.worlds.orchard.world import Orchard
from rai_missions.worlds.renderers import Renderers


@pytest.fixture
def facing(rig: Any) -> Any:
    """Stands before an obstacle."""

    def place(kind: str, **options: Any) -> Any:
        orchard = rig(alleys=1, obstacles=[{"kind": kind, "heeds_after": 99, "lingers_s": 900.0}], **options)
        orchard.to_the_obstacle()
        orchard.rest(0.5)
        return orchard

    return place


def test_a_picture_is_rendered_when_it_is_asked_for_and_shows_the_moment_it_was_taken(facing: Any) -> None:
    orchard = facing("person")
    message = orchard.last["camera_image_color"].data
    assert (message["height"], message["width"], message["encoding"], message["step"]) == (480, 640, "rgb8", 1920)
    picture = message["data"]
    assert isinstance(picture, Image)
    moment = orchard.world.camera.moment(orchard.world.data)
    orchard.rest(0.5)
    assert len(picture.data) == 640 * 480 * 3
    assert picture.data == orchard.world.camera.colour(moment).tobytes()
    pixels = np.frombuffer(picture.data, np.uint8).reshape(480, 640, 3).astype(int)
    vest = (pixels[..., 0] > 150) & (pixels[..., 1] < 130) & (pixels[..., 2] < 80)
    assert np.count_nonzero(vest) > 200, "the worker's vest is orange"


@pytest.mark.long
def test_a_picture_can_be_asked_for_from_any_thread(facing: Any) -> None:
    orchard = facing("person")
    picture = orchard.last["camera_image_color"].data["data"]
    seen: list[int] = []
    thread = threading.Thread(target=lambda: seen.append(len(picture.data)))
    thread.start()
    orchard.rest(0.5)
    thread.join()
    assert seen == [640 * 480 * 3]


def test_depth_and_segmentation_agree_with_where_things_are(facing: Any) -> None:
    orchard = facing("person")
    camera, moment = orchard.world.camera, orchard.world.camera.moment(orchard.world.data)
    body = orchard.world.model.body("obstacle_0").id
    mask = camera.segmentation(moment) == body
    assert np.count_nonzero(mask) > 500
    depth = float(np.median(camera.depth_m(moment)[mask]))
    assert depth == pytest.approx(orchard.world.places[0][0] - orchard.world.pose.x - 2.5, abs=0.35)


@pytest.mark.parametrize("kind", ["desk", "house", "orchard"])
def test_each_pixel_shows_the_body_that_mujoco_finds_there(kind: str) -> None:
    world: Any = open_world(kind)
    camera, model, scratch = world.camera, world.model, mujoco.MjData(world.model)
    moment = camera.moment(world.data)
    bodies = camera.segmentation(moment)
    scratch.qpos[:], scratch.mocap_pos[:], scratch.mocap_quat[:] = moment
    mujoco.mj_forward(model, scratch)
    renderers = Renderers(model, lambda _: None)

    def of_mujoco() -> Any:
        renderer = renderers.of(camera.height, camera.width)
        renderer.update_scene(scratch, "front")
        renderer.enable_segmentation_rendering()
        return renderer.render()

    try:
        seen = renderers.do(of_mujoco)
    finally:
        renderers.close()
        world.close()
    is_shape = seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
    assert np.array_equal(bodies, np.where(is_shape, np.asarray(model.geom_bodyid)[seen[..., 0]], -1))
    assert len(np.unique(bodies)) > 2


@pytest.mark.parametrize(
    ("kind", "low", "high", "living"),
    [
        ("branch", 0.08, 0.2, False),
        ("log", 0.38, 0.48, False),
        ("person", 1.65, 1.85, True),
        ("animal", 0.8, 1.05, True),
    ],
)
def test_an_obstacle_is_measured_in_pixels(facing: Any, kind: str, low: float, high: float, living: bool) -> None:
    orchard = facing(kind, detector={"noise": 0.0})
    facts = orchard.facts("obstacle")
    assert facts["kind"] == kind
    assert facts["living"] is living
    assert low < facts["height_m"] < high
    gap = orchard.world.autonomy.range_m
    assert facts["distance_m"] == pytest.approx(gap, abs=0.4)


@pytest.mark.long
def test_obstacles_are_reported_five_times_a_second_and_only_while_seen(facing: Any) -> None:
    orchard = facing("branch")
    times = [m.at for m in orchard.received if m.topic.endswith("obstacle")]
    assert np.diff(times) == pytest.approx(0.2)
    orchard.call("replan")
    orchard.rest(15.0)
    assert orchard.last["obstacle"].at < orchard.world.at - 3.0


@pytest.mark.long
def test_noise_misses_and_mistakes_come_from_the_seed(facing: Any) -> None:
    orchard = facing("branch", detector={"noise": 0.1, "miss": 0.4, "misclassify": 1.0}, seed=3)
    orchard.rest(8.0)
    kinds = {orchard.facts("obstacle")["kind"]}
    assert kinds != {"branch"}, "it is taken for something else"
    times = [m.at for m in orchard.received if m.topic.endswith("obstacle") and m.at > orchard.world.at - 8.0]
    assert 12 < len(times) < 36, "some looks miss"
    heights = {m.data["data"] for m in orchard.received if m.topic.endswith("obstacle")}
    assert len(heights) > 8, "measures are noisy though nothing moves"


def test_false_alarms_can_be_had(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], detector={"false_alarm": 1.0})
    orchard.call("continue")
    orchard.rest(8.0)
    assert orchard.facts("obstacle")["kind"] in ("branch", "log", "crate", "fallen_tree", "person", "animal")


def test_without_a_camera_there_are_no_pictures(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    orchard.to_the_obstacle()
    assert "camera_image_color" not in orchard.last
    assert "obstacle" not in orchard.last


@pytest.fixture
def renderers(rig: Any) -> Iterator[list[Any]]:
    """A list of one, so that a test can have it forgotten."""
    orchard = rig(alleys=1, camera=False)
    from rai_missions.worlds.renderers import Renderers

    made = [Renderers(orchard.world.model, lambda model: None)]
    yield made
    for one in made:
        one.close()


def test_what_no_one_closes_is_freed_by_the_thread_that_made_it(renderers: list[Any]) -> None:
    renderer, thread = renderers[0].do(lambda: (renderers[0].of(24, 32), threading.current_thread()))
    renderers.clear()
    gc.collect()
    thread.join(30.0)
    with pytest.raises(RuntimeError, match="close"):
        renderer.render()


@pytest.mark.long
def test_a_picture_that_is_asked_for_after_the_end_is_rendered_all_the_same(rig: Any) -> None:
    orchard = rig(alleys=1)
    camera, moment = orchard.world.camera, orchard.world.camera.moment(orchard.world.data)
    before = camera.colour(moment)
    for _ in range(2):
        camera.close()
        assert (camera.colour(moment) == before).all()


def test_an_orchard_is_painted_when_it_is_first_looked_at_and_so_is_its_branch() -> None:
    orchard = Orchard(alleys=1, obstacles=["none"])
    blank = {name: surface_of(orchard.model, name) for name in SURFACES}
    assert all(len(np.unique(each)) == 1 for each in blank.values())
    branch = orchard.branch()
    colours = [each.camera.colour(each.camera.moment(each.data)) for each in (orchard, branch)]
    assert (colours[0] == colours[1]).all()
    for world in (orchard, branch):
        for name, surface in SURFACES.items():
            assert (surface_of(world.model, name) == surface.grow(surface.size)).all(), name
        world.close()


def test_a_surface_lies_in_the_model_as_mujoco_reads_it_from_a_file() -> None:
    orchard = Orchard(alleys=1, obstacles=["none"])
    paint(orchard.model)
    for name, surface in SURFACES.items():
        file = {"a.png": png(surface.size, surface.size, surface.grow(surface.size).tobytes())}
        xml = '<mujoco><asset><texture name="a" type="2d" file="a.png"/></asset></mujoco>'
        read = mujoco.MjModel.from_xml_string(xml, file)
        assert (surface_of(read, "a") == surface_of(orchard.model, name)).all(), name
        assert read.tex_colorspace[0] == orchard.model.tex_colorspace[orchard.model.texture(name).id], name
    orchard.close()


def surface_of(model: Any, name: str) -> Any:
    """The pixels of a texture of a compiled model."""
    texture = model.texture(name)
    begin, height, width = int(texture.adr[0]), int(texture.height[0]), int(texture.width[0])
    return model.tex_data[begin : begin + 3 * height * width].reshape(height, width, 3).copy()


def test_opening_a_world_makes_sure_of_opengl_and_no_renderer() -> None:
    orchard = Orchard(alleys=1, obstacles=["none"])
    orchard.open(LocalConnector(now=lambda: orchard.at))
    assert not orchard.camera.has_rendered
    orchard.close()


def test_what_goes_wrong_on_the_thread_of_the_renderers_is_asked_to_who_asked(renderers: list[Any]) -> None:
    (one,) = renderers
    with pytest.raises(UsageError, match=r"(?s)the camera cannot render \(Image width .*\): install EGL"):
        one.do(lambda: one.of(24, 1_000_000))
    assert one.do(lambda: 1) == 1

# SPDX-License-Identifier: Apache-2.0
"""What the house's robot sees: objects where they are, through a detector that errs by seed and picture."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rai_missions.errors import UsageError
from rai_missions.mission.files import load
from rai_missions.worlds import open_world
from rai_missions.worlds.house.figures import FIGURES
from rai_missions.worlds.house.layout import SPOTS
from rai_missions.worlds.perception.detections import Box2D, ObjectDetection, array_message, request
from tests.rigs.open_world import OpenWorld

pytestmark = pytest.mark.sim
CLASSIFY, SEGMENT = "/grounding_dino_classify", "/grounded_sam_segment"
ASSIST = Path(__file__).parents[2] / "missions" / "rosbot" / "assist.json"
EXACT = {"noise": 0.0, "miss": 0.0, "misclassify": 0.0}
STUDY = 7.0, 3.2, 3.14
ON_DESK = [{"kind": "cup", "spot": "desk_south", "colour": "red"}, {"kind": "book", "spot": "desk_north"}]


TOPICS = ("/camera/color/image_raw", "/camera/depth/image_raw", "/sighting", "/seen", "/from_human")


class Room(OpenWorld):
    """A house whose robot is put in front of something."""

    def __init__(self, pose: tuple[float, float, float] = STUDY, **options: Any) -> None:
        super().__init__("house", TOPICS, **{"objects": ON_DESK, **options})
        put(self.world, pose)

    def picture(self) -> dict[str, Any]:
        """The next picture."""
        pictures = self.received["/camera/color/image_raw"]
        count = len(pictures)
        while len(pictures) == count:
            self.world.step()
        return dict(pictures[-1].data)

    def detect(self, names: list[str], picture: dict[str, Any] | None = None) -> Any:
        reply = self.call(CLASSIFY, request(names, picture or self.picture()))
        assert reply.outcome == "succeeded", reply.why
        return reply.data["detections"]

    def names(self, names: list[str], pictures: int = 1) -> list[str]:
        found = [one for _ in range(pictures) for one in self.detect(names)["detections"]]
        return [one["results"][0]["hypothesis"]["class_id"] for one in found]


def put(world: Any, pose: tuple[float, float, float]) -> None:
    import mujoco  # after the world, which chooses how it renders

    x, y, yaw = pose
    world.data.qpos[:7] = x, y, 0.048, math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)
    mujoco.mj_forward(world.model, world.data)


@pytest.fixture
def room() -> Iterator[Callable[..., Room]]:
    made: list[Room] = []

    def make(*pose: tuple[float, float, float], **options: Any) -> Room:
        made.append(Room(*pose, **options))
        return made[-1]

    yield make
    for one in made:
        one.world.close()


@pytest.mark.parametrize("kind", ["cup", "ball"])
def test_wherever_a_small_thing_is_some_view_of_the_mission_shows_it(kind: str, room: Any) -> None:
    spots = [name for name, spot in SPOTS.items() if (spot.height == 0) == FIGURES[kind].on_floor]
    one = room(objects=[{"kind": kind, "spot": spot} for spot in spots])
    seen: set[str] = set()
    for view in _views():
        put(one.world, view)
        frame, _ = one.world.camera.frame(one.world.camera.moment(one.world.data))
        counts = [np.count_nonzero(frame.body == one.world.model.body(f"object_{n}").id) for n in range(len(spots))]
        seen |= {spot for spot, count in zip(spots, counts, strict=True) if count > 100}
    assert seen == set(spots)


def _views() -> list[tuple[float, float, float]]:
    """The poses of the mission's whole round."""
    rounds = [each for each in load(ASSIST).states["choosing"].transitions if "house" in str(each.when)]
    return [(view["x"], view["y"], view["yaw"]) for view in rounds[0].do[0].value]


def test_the_finder_puts_things_where_they_are(room: Any) -> None:
    one = room()
    one.connector.publish("/look_for", "", {"data": "cup, book, bottle"})
    one.step(4)
    last = {fact["object"]: fact for seen in one.facts("/seen") for fact in seen["objects"]}
    assert last.keys() == {"cup", "book"}
    for kind, spot in (("cup", "desk_south"), ("book", "desk_north")):
        place = SPOTS[spot]
        assert math.dist((last[kind]["x"], last[kind]["y"]), place[:2]) < 0.2, last[kind]
        assert (last[kind]["room"], last[kind]["on"]) == ("study", "desk")
    assert last["cup"]["certainty"] > 0.6 and "cup on the desk in the study" in one.facts("/seen")[-1]["text"]


def test_names_are_open_and_a_colour_counts(room: Any) -> None:
    one = room(detector=EXACT)
    picture = one.picture()
    asked = {"red cup": 1, "blue cup": 0, "mug": 1, "a book": 1, "unicorn": 0, "bottle": 0}
    found = {name: len(one.detect([name], picture)["detections"]) for name in asked}
    assert found == asked
    reply = one.detect(["cup", "book"], picture)
    assert reply["detection_classes"] == ["cup", "book"] and reply["header"] == picture["header"]
    again = one.call("/detection", request(["cup"], picture))
    assert again.data["detections"] == one.detect(["cup"], picture), "under upstream's newer name too"


def test_the_same_picture_gives_the_same_answer_and_seeds_and_pictures_differ(room: Any) -> None:
    first, second, other = (room(seed=seed) for seed in (1, 1, 2))
    answers = []
    for one in (first, second, other):
        pictures = [one.picture() for _ in range(3)]
        backwards = [one.detect(["cup", "book"], picture) for picture in reversed(pictures)]
        forwards = [one.detect(["cup", "book"], picture) for picture in pictures]
        assert forwards == backwards[::-1], "in whatever order it is asked"
        assert forwards[0]["detections"] != forwards[1]["detections"]
        answers.append(forwards)
    assert answers[0] == answers[1] != answers[2]


@pytest.mark.parametrize(
    ("detector", "names", "found"),
    [
        ({"miss": 1.0}, ["cup", "book"], set()),
        ({**EXACT, "misclassify": 1.0}, ["cup", "book", "bowl", "bottle"], {"bowl", "bottle"}),
        ({**EXACT, "range_m": 1.0}, ["cup", "book"], set()),
        ({**EXACT, "false_alarm": 1.0}, ["unicorn"], {"unicorn"}),
        (EXACT, ["cup", "book"], {"cup", "book"}),
    ],
)
def test_a_detector_errs_as_its_options_state(
    room: Any, detector: dict[str, float], names: list[str], found: set[str]
) -> None:
    assert set(room(detector=detector).names(names, pictures=4)) == found


def test_a_detector_that_is_down_answers_nothing_and_then_again(room: Any) -> None:
    one = room(detector={**EXACT, "down": [0, 2]})
    reply = one.call(CLASSIFY, request(["cup"], one.picture()))
    assert reply.outcome == "failed" and "the detector is down" in reply.why
    one.step(2)
    assert one.names(["cup"]) == ["cup"]


def test_a_picture_that_is_not_this_cameras_is_refused(room: Any) -> None:
    one = room()
    for picture in ({}, {**one.picture(), "header": {"stamp": {"sec": 99, "nanosec": 0}}}):
        reply = one.call(CLASSIFY, request(["cup"], picture))
        assert reply.outcome == "failed" and "none of the last pictures of this camera" in reply.why


def test_masks_show_the_thing_in_each_box(room: Any) -> None:
    one = room(detector=EXACT)
    picture = one.picture()
    found = one.detect(["cup", "book"], picture)
    nothing = ObjectDetection("cup", 1.0, Box2D(0, 0, 3, 3))
    more = {**found, "detections": [*found["detections"], *array_message([nothing], [], {})["detections"]]}
    masks = one.call(SEGMENT, {"detections": more, "source_img": picture}).data["masks"]
    assert [(mask["encoding"], mask["width"], mask["height"], mask["step"]) for mask in masks] == [
        ("mono8", 640, 480, 640)
    ] * 3
    counts = [np.count_nonzero(np.frombuffer(mask["data"].data, np.uint8)) for mask in masks]
    areas = [each["bbox"]["size_x"] * each["bbox"]["size_y"] for each in found["detections"]]
    assert all(0.3 * area < count <= area for count, area in zip(counts, areas, strict=False)) and counts[2] == 0


def test_depth_is_aligned_with_the_picture(room: Any) -> None:
    one = room(detector=EXACT)
    picture = one.picture()
    depth = one.received["/camera/depth/image_raw"][-1].data
    assert depth["header"] == picture["header"] and depth["encoding"] == "16UC1" and depth["step"] == 1280
    metres = np.frombuffer(depth["data"].data, "<u2").reshape(480, 640) / 1000
    centre = one.detect(["cup"], picture)["detections"][0]["bbox"]["center"]["position"]
    there = metres[round(centre["y"]), round(centre["x"])]
    assert there == pytest.approx(STUDY[0] - 0.14 - SPOTS["desk_south"].x, abs=0.1)


def test_another_detector_may_serve_the_names(room: Any) -> None:
    one = room(detects=False)
    box = ObjectDetection("cup", 0.9, Box2D(300, 200, 340, 240))
    one.connector.serve(
        CLASSIFY,
        "rai_interfaces/srv/RAIGroundingDino",
        lambda asked: {"detections": array_message([box], [], asked["source_img"]["header"])},
    )
    one.connector.publish("/look_for", "", {"data": "cup"})
    one.step(2)
    assert one.facts("/sighting")[-1]["object"] == "cup"


def test_people_speak_when_they_are_due(room: Any) -> None:
    one = room(camera=False, speech=[{"at_s": 2, "text": "stop"}, {"at_s": 1, "text": "robot, find the cup"}])
    one.step(3)
    received = one.received["/from_human"]
    assert [(message.data["text"], round(message.at, 1)) for message in received] == [
        ("robot, find the cup", 1.0),
        ("stop", 2.0),
    ]
    assert received[0].data["communication_id"] != received[1].data["communication_id"]
    assert all(message.data["seq_end"] for message in received)


def test_objects_are_drawn_from_the_seed_each_in_its_place() -> None:
    def objects(seed: int) -> Any:
        return open_world("house", seed=seed, camera=False).objects  # type: ignore[attr-defined]

    assert objects(1) == objects(1) != objects(2)
    for seed in range(3):
        drawn = objects(seed)
        assert {one.kind for one in drawn} == set(FIGURES)
        assert len({one.spot for one in drawn}) == len(drawn)
        assert all((one.place.height == 0) == FIGURES[one.kind].on_floor for one in drawn)


def test_a_scene_is_read_from_a_file_and_options_go_first(tmp_path: Path) -> None:
    file = tmp_path / "scene.json"
    file.write_text(json.dumps({"about": "a cup", "objects": ["cup"], "people": [{"at": "study"}]}))
    world: Any = open_world("house", scene=str(file), camera=False)
    assert [one.kind for one in world.objects] == ["cup"] and len(world.residents.people) == 1
    other: Any = open_world("house", scene=str(file), camera=False, objects=[], people=0)
    assert other.objects == () and other.residents.people == ()


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"objects": ["cupp"]}, "no kind 'cupp'; did you mean 'cup'?"),
        ({"objects": [{"kind": "cup", "spot": "moon"}]}, "no spot 'moon'"),
        ({"objects": [{"kind": "cup", "colour": "pink"}]}, "no colour 'pink'"),
        ({"objects": [{"kind": "cup", "colr": "red"}]}, "no field 'colr'; did you mean 'colour'?"),
        ({"objects": [{"kind": "cup", "at": [1, 2]}]}, "[1, 2] is no place; give x, y and the height"),
        (
            {"objects": [{"kind": "cup", "at": [1, 2, 0], "spot": "table_north"}]},
            "a cup is on a 'spot' or 'at' a place; keep one",
        ),
        ({"objects": [{"kind": "cup", "at": [50, 2, 0]}]}, "[50, 2, 0] is outside of the house"),
        ({"objects": [{"kind": "cup", "spot": "sofa_south"}, {"kind": "book", "spot": "sofa_south"}]}, "a spot holds"),
        ({"objects": ["ball"] * 5}, "no spot is left for another ball"),
        ({"objects": "cup"}, "'cup' is no list"),
        ({"detector": {"mis": 1}}, "no option 'mis'; did you mean 'miss'?"),
        ({"detector": {"miss": 2}}, "miss takes a number from 0 to 1, not 2"),
        ({"detector": {"down": [5, 1]}}, "down takes when it begins and ends"),
        ({"scene": "/nowhere.json"}, "'/nowhere.json' cannot be read"),
        ({"scene": {"object": []}}, "no word 'object'; did you mean 'objects'?"),
        ({"speech": [{"at_s": -1, "text": "x"}]}, "at_s takes the seconds since the start"),
        ({"speech": [{"at_s": 1, "text": ""}]}, "text takes a sentence of 1 to 2000 characters"),
        ({"speech": [{"at": 1}]}, "no field 'at'"),
        ({"speech": "hello"}, "'hello' is no list"),
    ],
)
def test_an_option_that_is_wrong_is_reported(options: dict[str, Any], why: str) -> None:
    with pytest.raises(UsageError) as error:
        open_world("house", camera=False, **options)
    assert why in str(error.value)

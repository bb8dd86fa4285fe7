# SPDX-License-Identifier: Apache-2.0
"""The house: its robot goes where it can, states it truly where it cannot, and does the same thing twice."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.image import Image
from rai_missions.profile.convert import pose_message
from rai_missions.worlds import open_world
from rai_missions.worlds.contract import check_world
from rai_missions.worlds.house.layout import DOORS, FURNITURE, PLACES, ROOMS, SPOTS
from tests.worlds.conftest import closing

pytestmark = pytest.mark.sim
NAVIGATE, DOCK = "/navigate_to_pose", "/dock_robot"


class Visit:
    """A house on a connector, and all that it reported."""

    def __init__(self, **options: Any) -> None:
        self.world: Any = open_world("house", **{"camera": False, **options})
        self.connector = LocalConnector(now=lambda: self.world.at)
        self.reports: list[Report] = []
        self.received: list[Message] = []
        for topic in ("scan", "odom", "amcl_pose", "battery"):
            self.connector.subscribe(f"/{topic}", "", self.received.append)
        self.world.open(self.connector)
        self.connector.start()

    def send(self, where: str | tuple[float, float], goal_id: str = "g", **header: Any) -> None:
        x, y, *rest = PLACES[where] if isinstance(where, str) else where
        pose = pose_message({"x": x, "y": y, "yaw": rest[0] if rest else 0.0, "frame": header.get("frame", "map")})
        self.connector.send_goal(NAVIGATE, "", {"pose": pose}, goal_id=goal_id, on_report=self.reports.append)

    def dock(self, goal: dict[str, Any], goal_id: str = "d") -> None:
        self.connector.send_goal(DOCK, "", goal, goal_id=goal_id, on_report=self.reports.append)

    def statuses(self, goal_id: str = "g") -> list[str]:
        return [report.status for report in self.reports if report.goal_id == goal_id and report.status != "feedback"]

    def run(self, until: Callable[[], bool], within_s: float = 120.0) -> bool:
        end = self.world.at + within_s
        while self.world.at < end and not until():
            self.world.step()
        return until()

    def finish(self, goal_id: str = "g") -> Report:
        """Continue until a goal has ended; its last report."""
        assert self.run(lambda: len(self.statuses(goal_id)) > 1), self.reports[-3:]
        return [report for report in self.reports if report.goal_id == goal_id][-1]

    def to_person(self) -> float:
        """How far the robot is from the nearest person."""
        return min(math.dist(self.world.pose[:2], (one.x, one.y)) for one in self.world.residents.people)

    def to(self, place: str) -> float:
        """How far the robot is from a place."""
        return math.dist(self.world.pose[:2], PLACES[place][:2])


@pytest.fixture
def visit() -> Any:
    yield from closing(Visit)


def test_the_house_keeps_the_contract() -> None:
    topics = ("/scan", "/odom", "/amcl_pose", "/battery", "/camera/color/image_raw")
    check_world(lambda: open_world("house"), topics)


def test_it_goes_to_every_room_and_is_as_it_was_reported(visit: Any) -> None:
    house = visit()
    for number, (name, place) in enumerate(PLACES.items()):
        house.send(name, f"g{number}")
        report = house.finish(f"g{number}")
        assert (report.status, report.data) == ("succeeded", {"error_code": 0, "error_msg": ""}), name
        assert house.to(name) < 0.15
        aside = house.world.pose.heading - place.heading
        assert abs(math.remainder(aside, 2 * math.pi)) < 0.2, name
        assert house.world.navigator.recoveries == 0


def test_the_same_seed_gives_the_same_bits_and_another_does_not(visit: Any) -> None:
    runs = [visit(seed=seed) for seed in (1, 1, 2)]
    for house in runs:
        house.send("bedroom")
        house.finish()
    prints = [house.world.fingerprint() for house in runs]
    assert prints[0] == prints[1] != prints[2]
    assert [repr(message) for message in runs[0].received] == [repr(message) for message in runs[1].received]


def test_feedback_reports_how_far_it_is_and_how_long_it_took(visit: Any) -> None:
    house = visit()
    house.send("bedroom")
    house.finish()
    feedback = [report.data for report in house.reports if report.status == "feedback"]
    assert len(feedback) > 10
    assert feedback[0].keys() == {
        "current_pose",
        "navigation_time",
        "estimated_time_remaining",
        "number_of_recoveries",
        "distance_remaining",
    }
    left = [one["distance_remaining"] for one in feedback[1:]]
    assert left[0] > 5 and all(b < a + 0.5 for a, b in itertools.pairwise(left)) and left[-1] < 1
    times = [one["navigation_time"]["sec"] + one["navigation_time"]["nanosec"] / 1e9 for one in feedback]
    assert times == sorted(times) and times[-1] > 5


def test_with_one_door_blocked_it_takes_the_other_way(visit: Any) -> None:
    house = visit(blocked=["kitchen_study"])
    house.send("study")
    assert house.finish().status == "succeeded"
    assert house.world.at > 30, "the way round is long"


def test_with_the_only_door_blocked_its_recoveries_fail_and_it_states_why(visit: Any) -> None:
    house = visit(blocked=["study_pantry"], recoveries=4)
    house.send("pantry")
    report = house.finish()
    assert report.status == "failed"
    assert report.data == {"error_code": 308, "error_msg": "no way leads to (8.70, 3.20), after 4 recoveries"}
    assert report.why == report.data["error_msg"]
    counted = [one.data["number_of_recoveries"] for one in house.reports if one.status == "feedback"]
    assert counted == sorted(counted) and set(counted) >= {0, 1, 2, 3, 4}
    house.send("kitchen", "again")
    assert house.finish("again").status == "succeeded", "after a failure it continues as before"


def test_a_door_that_opens_in_time_lets_it_through(visit: Any) -> None:
    house = visit(blocked={"study_pantry": [0, 25]})
    house.send("pantry")
    assert house.finish().status == "succeeded"
    assert any(one.data.get("number_of_recoveries") for one in house.reports), "it had to wait"


@given(st.lists(st.floats(0, 8), min_size=2, max_size=6, unique=True).filter(lambda times: len(times) % 2 == 0))
@settings(max_examples=10)
def test_a_door_is_blocked_within_each_of_its_times(times: list[float]) -> None:
    times = sorted(times)
    world = open_world("house", camera=False, objects=[], blocked={"study_pantry": times})
    for _ in range(160):
        at = world.at
        world.step()
        within = any(begins <= at < ends for begins, ends in zip(times[::2], times[1::2], strict=True))
        assert world.doors.is_blocked("study_pantry") is within, at


def test_a_door_is_blocked_and_freed_by_its_service(visit: Any) -> None:
    house = visit()
    replies: list[Reply] = []
    for wanted in (True, False):
        house.connector.call("/house/study_pantry", "std_srvs/srv/SetBool", {"data": wanted}, on_reply=replies.append)
        house.world.step()
        assert house.world.doors.is_blocked("study_pantry") is wanted
    assert [reply.data["success"] for reply in replies] == [True, True]


def test_no_crate_is_put_onto_the_robot(visit: Any) -> None:
    house = visit()
    house.send((7.65, 2.0))
    house.finish()
    house.world.doors.set("study_pantry", True)
    house.run(lambda: False, 2.0)
    assert not house.world.doors.is_blocked("study_pantry")
    house.send("kitchen", "away")
    house.finish("away")
    assert house.world.doors.is_blocked("study_pantry")


@pytest.mark.parametrize(
    ("where", "why"),
    [
        ((20.0, 1.0), "(20.00, 1.00) is outside of the map"),
        ((-0.1, 1.0), "(-0.10, 1.00) is outside of the map"),
        ((5.05, 3.0), "(5.05, 3.00) is too close to a wall or to furniture"),
        ((2.9, 1.6), "(2.90, 1.60) is too close to a wall or to furniture"),
        ((math.nan, 1.0), "the goal's pose is not finite"),
    ],
)
def test_a_goal_where_it_cannot_be_is_rejected(visit: Any, where: tuple[float, float], why: str) -> None:
    house = visit()
    pose = pose_message({"x": 0.0, "y": 0.0, "frame": "map"})
    pose["pose"]["position"] |= {"x": where[0], "y": where[1]}
    house.connector.send_goal(NAVIGATE, "", {"pose": pose}, goal_id="g", on_report=house.reports.append)
    house.world.step()
    assert [(one.status, one.why) for one in house.reports] == [("rejected", why)]


def test_a_goal_in_another_frame_or_without_a_pose_is_rejected(visit: Any) -> None:
    house = visit()
    house.send("kitchen", "odom", frame="odom")
    house.connector.send_goal(NAVIGATE, "", {}, goal_id="none", on_report=house.reports.append)
    house.world.step()
    assert [one.why for one in house.reports] == [
        "the goal is in the frame 'odom'; there is: map",
        "the goal has no 'pose'",
    ]


def test_a_canceled_goal_ends_when_the_robot_is(visit: Any) -> None:
    house = visit()
    house.send("bedroom")
    house.run(lambda: house.world.pose.speed > 0.3)
    house.connector.cancel_goal("g")
    assert house.statuses() == ["accepted"], "not before it stands"
    assert house.finish().status == "canceled"
    assert abs(house.world.pose.speed) < 0.05
    place = house.world.pose
    house.run(lambda: False, 2.0)
    assert math.dist(place[:2], house.world.pose[:2]) < 0.02


def test_a_newer_goal_replaces_the_one_that_is_pursued(visit: Any) -> None:
    house = visit()
    house.send("bedroom", "first")
    house.run(lambda: house.world.pose.speed > 0.3)
    house.send("kitchen", "second")
    assert house.finish("first").why == "a newer goal replaced this one"
    house.run(lambda: house.world.pose.speed > 0.3)
    house.dock({"dock_id": "dock"})
    assert house.finish("second").status == "failed", "by the other action too"
    assert house.finish("d").status == "succeeded" and house.to("dock") < 0.2


def test_it_charges_on_the_dock_and_nowhere_else(visit: Any) -> None:
    house = visit(battery={"capacity_wh": 1.0, "charge": 0.6})
    house.send("kitchen")
    house.finish()
    low = house.world.battery.percentage
    assert low < 0.6 and not house.world.is_charging
    house.dock({})
    report = house.finish("d")
    assert report.status == "succeeded"
    assert report.data == {"success": True, "error_code": 0, "num_retries": 0, "error_msg": ""}
    assert house.run(lambda: house.world.battery.percentage > 0.95, 60)
    reported = [message.data["power_supply_status"] for message in house.received if message.topic == "/battery"]
    assert reported[-1] == 1 and 2 in reported


def test_what_is_no_dock_is_rejected(visit: Any) -> None:
    house = visit()
    house.dock({"dock_id": "garage"}, "one")
    house.dock({"use_dock_id": False}, "two")
    house.world.step()
    assert [one.why for one in house.reports] == [
        "there is no dock 'garage'; there is: dock",
        "docks are known by 'dock_id' here; there is: dock",
    ]


def test_an_empty_battery_ends_the_goal(visit: Any) -> None:
    house = visit(battery={"capacity_wh": 0.05})
    house.send("bedroom")
    report = house.finish()
    assert (report.status, report.why) == ("failed", "the battery is empty")


def test_the_lidar_sees_the_walls_and_a_crate(visit: Any) -> None:
    house = visit()
    house.world.step()
    scan = [message.data for message in house.received if message.topic == "/scan"][-1]
    assert len(scan["ranges"]) == 360 and scan["ranges"][180] == pytest.approx(5.0 - 0.58, abs=0.1)
    house.send((6.2, 2.0))
    house.finish()
    ahead = house.received[-1]
    for blocked, far in ((True, 7.25), (False, 9.4)):
        house.world.doors.set("study_pantry", blocked)
        house.run(lambda: False, 0.5)
        ahead = [message for message in house.received if message.topic == "/scan"][-1]
        assert ahead.data["ranges"][180] == pytest.approx(far - house.world.pose.x, abs=0.25), blocked


def test_a_velocity_command_moves_it_while_no_goal_does_and_does_not_last(visit: Any) -> None:
    house = visit()
    twist = {"linear": {"x": 0.3}, "angular": {"z": 0.0}}
    for _ in range(20):
        house.connector.publish("/cmd_vel", "geometry_msgs/msg/Twist", twist)
        house.world.step()
    assert house.world.pose.speed > 0.2
    assert house.run(lambda: abs(house.world.pose.speed) < 0.02, 3.0), "anyone who falls silent drives no more"
    start = house.world.pose.x
    house.send("dock")
    house.connector.publish("/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": 0.5}, "angular": {"z": 0.0}})
    house.run(lambda: False, 0.3)
    assert house.world.pose.x < start + 0.05, "the navigation has the base"


def test_its_camera_shows_the_room(visit: Any) -> None:
    house = visit(camera=True)
    pictures: list[Message] = []
    house.connector.subscribe("/camera/color/image_raw", "", pictures.append)
    house.run(lambda: bool(pictures))
    picture = pictures[0].data["data"]
    assert isinstance(picture, Image) and (picture.width, picture.height) == (640, 480)
    assert len(set(picture.data)) > 20


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"blocked": ["cellar"]}, "no door 'cellar'; there is: bedroom_study"),
        ({"blocked": {"study_pantry": [60, 20]}}, r"study_pantry: \[60, 20\] is not when it begins and ends"),
        ({"recoveries": -1}, "-1 is no number of attempts"),
        ({"camera": False, "detects": False, "detector": {"mis": 1}}, "no option 'mis'; did you mean 'miss'"),
        ({"battery": {"volts": 3}}, "no option 'volts'; there is: capacity_wh, charge"),
        ({"alleys": 3}, "has no option 'alleys'; there are: seed, blocked"),
    ],
)
def test_an_option_that_is_wrong_is_reported(options: dict[str, Any], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        open_world("house", **options)


def test_the_guide_has_the_map_of_the_house() -> None:
    guide = (Path(__file__).parents[2] / "docs/guide/house.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([a-z ]+) \| `([\d., ]+)` \|$", guide, re.MULTILINE)
    assert {name: tuple(map(float, edges.split(", "))) for name, edges in rows} == {
        name: box[:4] for name, box in {**ROOMS, **FURNITURE}.items()
    }
    doors = re.findall(r"`([a-z_]+)`\s([\d.]+), ([\d.]+)[;.]", guide)
    assert {name: (float(x), float(y)) for name, x, y in doors} == DOORS
    (spots,) = re.findall(r"Spots for objects are ([^.]+)\.", guide)
    assert re.findall(r"`([a-z_]+)`", spots) == [*SPOTS]

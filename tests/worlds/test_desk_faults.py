# SPDX-License-Identifier: Apache-2.0
"""What goes wrong at the desk: it happens when it is asked for, shows only in what is seen, and repeats by its seed."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

import pytest

from rai_missions.connectors.connector import Report
from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.desk.detector import ClassifiedBody
from rai_missions.worlds.desk.finger_contacts import FingerContacts
from rai_missions.worlds.desk.look import SeenBody
from rai_missions.worlds.desk.tracks import LEAD, Tracks
from rai_missions.worlds.open_set_detector import ObjectClass
from tests.rigs.open_world import OpenWorld

pytestmark = pytest.mark.sim
TWO: dict[str, Any] = {
    "objects": [
        {"type": "red_cube", "pose": {"x": 0.5, "y": 0.15}},
        {"type": "blue_cube", "pose": {"x": 0.5, "y": -0.15}},
    ]
}


class Desk(OpenWorld):
    """A desk with faults, and what is seen of it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("desk", ("/desk/objects",), camera=False, **{"scene": TWO, **options})

    @property
    def looks(self) -> list[Any]:
        return self.facts("/desk/objects")

    @property
    def fact(self) -> dict[str, Any]:
        return dict(self.looks[-1])

    def run(self, seconds: float) -> dict[str, dict[str, Any]]:
        """The things that are seen afterwards, by name."""
        self.step(seconds)
        return {one["name"]: one for one in self.fact["things"]}


def planned(event: str, **more: Any) -> dict[str, Any]:
    return {"plan": [{"at_s": 2.0, "event": event, "thing": "red_cube", **more}]}


def test_a_pushed_thing_moves_and_is_seen_to() -> None:
    desk = Desk(faults=planned("push", x=1.0))
    before = desk.run(1.9)["red_cube"]
    moving = desk.run(0.4)["red_cube"]
    after = desk.run(2)["red_cube"]
    assert before["at_rest"] and not moving["at_rest"] and after["at_rest"]
    assert after["x"] - before["x"] > 0.005 and abs(after["y"] - before["y"]) < 0.01


def test_a_moved_thing_keeps_its_name_or_gets_it_back() -> None:
    things = Desk(faults=planned("move", x=0.4, y=0.3)).run(6)
    assert things.keys() == {"red_cube", "blue_cube"}
    assert math.dist((things["red_cube"]["x"], things["red_cube"]["y"]), (0.4, 0.3)) < 0.02


def test_what_is_put_onto_something_lies_on_it() -> None:
    desk = Desk(faults=planned("move", x=0.5, y=-0.15))
    things = desk.run(6)
    assert things["red_cube"]["z"] == pytest.approx(0.066, abs=0.005)
    assert desk.world.truth().touch("red_cube", "blue_cube")


def test_a_taken_thing_is_no_longer_seen() -> None:
    assert Desk(faults=planned("take")).run(4).keys() == {"blue_cube"}


def test_a_thing_that_is_held_is_taken_out_of_the_fingers_and_the_server_reports_it_lost() -> None:
    desk, reports = Desk(faults={"plan": [{"at_s": 6.5, "event": "take", "thing": "red_cube"}]}), list[Report]()
    desk.run(2)
    pose = {"x": 0.5, "y": 0.15, "z": 0.022, "yaw": 0.0}
    goal = {"object": "red_cube", "pose": pose}
    desk.connector.send_goal("/pick_at", "", goal, goal_id="pick", on_report=reports.append)
    desk.run(4.4)
    assert reports[-1].status == "succeeded" and desk.fact["gripper"] == "holding"
    desk.run(2)
    assert desk.world.truth().held == "" and desk.fact["gripper"] == "empty"
    desk.connector.send_goal("/place_at", "", goal, goal_id="place", on_report=reports.append)
    desk.run(2)
    assert reports[-1].status == "failed" and reports[-1].data["reason"] == "nothing_held"
    assert desk.run(3).keys() == {"blue_cube"}


def test_what_the_fingers_hold_is_what_the_truth_calls_held_at_every_instant() -> None:
    desk, found = Desk(faults={"slip": 1.0, "drop": 0.5, "seed": 4}), set[str]()
    fingers = FingerContacts(desk.world.model, desk.world.objects)
    goal = {"object": "red_cube", "pose": {"x": 0.5, "y": 0.15, "z": 0.022, "yaw": 0.0}}
    place = {"object": "red_cube", "pose": {"x": 0.4, "y": -0.1, "z": 0.022, "yaw": 0.0}}
    for number, (action, wanted) in enumerate((("/pick_at", goal), ("/place_at", place)) * 2):
        desk.connector.send_goal(action, "", wanted, goal_id=f"{number}", on_report=lambda report: None)
        for _ in range(70):
            desk.world.step()
            held = fingers.held(desk.world.data)
            assert held == desk.world.truth().held
            found.add(held)
    assert found == {"", "red_cube"}


def test_the_same_seed_has_the_same_faults_and_another_has_others() -> None:
    prints = []
    for seed in (1, 1, 2):
        desk = Desk(faults={"push": 60, "move": 30, "seed": seed})
        desk.run(3)
        prints.append(desk.world.fingerprint())
    assert prints[0] == prints[1] != prints[2]


def test_no_class_counts_before_it_leads_and_a_detector_that_is_down_adds_none() -> None:
    desk = Desk(detector={"miss": 0, "swap": 0})
    assert desk.run((LEAD - 1) * 0.2) == {} and desk.fact["unsure"] == 2
    assert len(desk.run(0.2)) == 2 and desk.fact["unsure"] == 0
    assert Desk(detector={"down": [0, 9]}, scene={"objects": []}).world.truth().things == {}
    desk = Desk(detector={"down": [1.9, 4]})
    desk.run(2)
    looks = desk.fact["looks"]
    desk.run(1)
    assert desk.fact["looks"] == looks


def test_a_class_that_is_always_swapped_is_seen_wrongly_and_no_look_shows_it() -> None:
    things = Desk(detector={"persistent": 1.0, "swap": 0.0}).run(3)
    assert "red_cube" not in things and len(things) == 2


def test_with_one_look_in_ten_wrong_every_class_is_right() -> None:
    for seed in range(3):
        things = Desk(seed=seed, detector={"miss": 0.1, "swap": 0.1}).run(5)
        assert things.keys() == {"red_cube", "blue_cube"}, seed


def sighting(x: float, colour: str = "red", sigma_m: float = 0.0005) -> ClassifiedBody:
    return ClassifiedBody(ObjectClass("cube", colour), SeenBody(1, x, 0.0, 0.022, 0.0, 1.0, sigma_m))


def look(tracks: Tracks, times: int, seen: Sequence[ClassifiedBody], *, is_clear: bool = False) -> None:
    """The same is seen several times; whether every place is seen where nothing is."""
    for _ in range(times):
        tracks.add(seen, lambda *_: is_clear)


def test_a_thing_that_is_hidden_later_keeps_the_pose_that_was_measured_better_until_it_moved() -> None:
    tracks = Tracks()
    look(tracks, LEAD, [sighting(0.5)])
    for number in range(10):
        tracks.add([sighting(0.5 + 0.004 * (-1) ** number, sigma_m=0.004)], lambda *_: False)
    (kept,) = tracks.things()
    assert kept["x"] == 0.5 and 0.00025 < kept["sigma_m"] < 0.001 and kept["at_rest"]
    tracks.add([sighting(0.53, sigma_m=0.004)], lambda *_: False)
    (moved,) = tracks.things()
    assert (moved["x"], moved["sigma_m"], moved["at_rest"]) == (0.53, 0.004, False)


def test_the_mean_of_many_looks_is_as_exact_as_it_is_reported_to_be() -> None:
    rng, errors = random.Random(1), list[float]()
    for _ in range(200):
        tracks = Tracks()
        for _ in range(20):
            tracks.add([sighting(0.5 + rng.gauss(0, 0.002), sigma_m=0.002)], lambda *_: False)
        (thing,) = tracks.things()
        errors.append((thing["x"] - 0.5) / thing["sigma_m"])
    assert sum(abs(error) <= 2 for error in errors) >= 0.95 * len(errors)
    assert thing["sigma_m"] == 0.001, "what the looks have in common no mean takes away"


def test_a_thing_that_a_look_shows_elsewhere_lies_still_only_after_as_many_looks_there() -> None:
    tracks, is_at_rest = Tracks(), list[bool]()
    for x in (*[0.5] * LEAD, *[0.503] * 4):
        tracks.add([sighting(x)], lambda *_: False)
        is_at_rest += [one["at_rest"] for one in tracks.things()]
    assert is_at_rest[-5:] == [True, False, False, False, True]


def test_what_was_carried_out_of_sight_keeps_its_name() -> None:
    tracks = Tracks()
    for number in range(LEAD + 2):
        tracks.add([sighting(0.3 + 0.03 * max(0, number - LEAD + 2))], lambda *_: False)
    look(tracks, 4, [])
    look(tracks, LEAD, [sighting(0.6)])
    assert [(one["name"], one["x"]) for one in tracks.things()] == [("red_cube", 0.6)]


def test_a_thing_that_was_still_when_it_was_hidden_does_not_lend_its_name() -> None:
    tracks = Tracks()
    look(tracks, LEAD, [sighting(0.3)])
    look(tracks, LEAD, [sighting(0.6)])
    assert {one["name"]: one["x"] for one in tracks.things()} == {"red_cube": 0.3, "red_cube_2": 0.6}


def test_a_thing_that_fell_unseen_keeps_its_name_once_its_old_place_is_seen_empty() -> None:
    tracks = Tracks()
    look(tracks, LEAD, [sighting(0.3)])
    look(tracks, LEAD, [sighting(0.6)])
    look(tracks, 3, [sighting(0.6)], is_clear=True)
    assert {one["name"]: one["x"] for one in tracks.things()} == {"red_cube": 0.6}


@pytest.mark.parametrize("seen_before", [True, False])
def test_a_thing_that_is_gone_lends_its_name_to_no_two_and_to_none_that_was_there_before(seen_before: bool) -> None:
    tracks = Tracks()
    others = [sighting(0.6), sighting(0.9)][: 1 if seen_before else 2]
    look(tracks, LEAD, [sighting(0.3), *(others if seen_before else [])])
    look(tracks, LEAD, others)
    look(tracks, 3, others, is_clear=True)
    names = {one["name"] for one in tracks.things()}
    assert names == ({"red_cube_2"} if seen_before else {"red_cube_2", "red_cube_3"})


def test_what_comes_to_lie_in_the_middle_of_a_tray_is_not_taken_for_it() -> None:
    def lying(kind: str, x: float, z: float) -> ClassifiedBody:
        return ClassifiedBody(ObjectClass(kind, ""), SeenBody(1, x, 0.0, z, 0.0, 1.0, 0.0005))

    tracks = Tracks()
    look(tracks, LEAD, [lying("corn", 0.7, 0.022), lying("tray", 0.5, 0.015)])
    for x in (0.65, 0.6, 0.55, 0.5):
        tracks.add([lying("corn", x, 0.05)], lambda *_: False)
    look(tracks, 4 * LEAD, [lying("tray", 0.5, 0.024), lying("corn", 0.5, 0.017)])
    assert {one["name"] for one in tracks.things()} == {"corn", "tray"}


def test_what_is_hidden_for_a_look_is_not_taken_for_its_neighbour() -> None:
    tracks = Tracks()
    look(tracks, LEAD, [sighting(0.4, "red"), sighting(0.46, "blue")])
    tracks.add([sighting(0.46, "blue")], lambda *_: False)
    tracks.add([sighting(0.4, "red")], lambda *_: False)
    assert {one["name"]: one["x"] for one in tracks.things()} == {"red_cube": 0.4, "blue_cube": 0.46}


def test_a_hidden_thing_stays_listed_and_one_that_is_seen_through_goes() -> None:
    tracks = Tracks()
    look(tracks, LEAD, [sighting(0.5)])
    look(tracks, 50, [])
    assert [one["name"] for one in tracks.things()] == ["red_cube"]
    look(tracks, 3, [], is_clear=True)
    assert tracks.things() == []


def test_a_sighting_belongs_to_the_nearest_thing_whatever_its_class() -> None:
    tracks = Tracks()
    for number in range(12):
        swapped = number % 4 == 3
        tracks.add([sighting(0.4, "blue" if swapped else "red"), sighting(0.5, "blue")], lambda *_: False)
    things = {one["name"]: one for one in tracks.things()}
    assert things.keys() == {"red_cube", "blue_cube"} and things["red_cube"]["x"] == 0.4
    assert (things["red_cube"]["agreeing"], things["red_cube"]["looks"]) == (9, 12)


@pytest.mark.parametrize(
    ("faults", "why"),
    [
        ({"slips": 1}, "faults: no option 'slips'; did you mean 'slip'?"),
        ({"slip": 2}, "faults: slip takes a number from 0 to 1, not 2"),
        ({"push": -1}, "faults: push takes a number from 0 to 60, not -1"),
        ({"seed": "x"}, "faults: seed takes a whole number, not 'x'"),
        ({"plan": 3}, "faults: plan takes a list of events, not 3"),
        (planned("eat"), "faults: /plan/0/event: no event 'eat'; there are: push, move, take"),
        (planned("move", x=2.0), "faults: /plan/0: (2, 0) is off the desk"),
        (planned("push", x="a"), "faults: /plan/0/x: 'a' is no finite number"),
        (
            {"plan": [{"event": "push", "thing": "dog"}]},
            "faults: /plan/0/thing: no thing 'dog'; there is: blue_cube, red_cube",
        ),
    ],
)
def test_wrong_faults_are_refused(faults: dict[str, Any], why: str) -> None:
    with pytest.raises(UsageError) as fault:
        open_world("desk", camera=False, scene=TWO, faults=faults)
    assert str(fault.value) == why


class Hand(Desk):
    """A desk whose arm carries the red cube from one place to another."""

    def __init__(self, **options: Any) -> None:
        super().__init__(detector={"miss": 0, "swap": 0}, **options)
        self.reports: list[Report] = []

    def send(self, action: str, pose: dict[str, float]) -> Report:
        """The goal's last report."""
        goal = {"object": "red_cube", "pose": pose}
        self.connector.send_goal(action, "", goal, goal_id=action, on_report=self.reports.append)
        end = self.world.at + 30
        while self.world.at < end and self._is_pending(action):
            self.world.step()
        return self.reports[-1]

    def _is_pending(self, action: str) -> bool:
        last = [report.status for report in self.reports if report.goal_id == action][-1:]
        return last[:1] in ([], ["accepted"], ["feedback"])

    def carry(self) -> list[str]:
        """What the two servers reported."""
        cube = self.run(2)["red_cube"]
        picked = self.send("/pick_at", {axis: cube[axis] for axis in ("x", "y", "z", "yaw")})
        placed = self.send("/place_at", {"x": 0.4, "y": -0.3, "z": 0.022, "yaw": 0.0})
        return [picked.status, placed.status]

    def lowest(self) -> float:
        return float(self.world.truth().things["red_cube"].z)


def test_a_carried_thing_arrives_and_the_gripper_is_reported_from_its_sensors() -> None:
    hand = Hand()
    assert hand.carry() == ["succeeded", "succeeded"]
    words = [fact["gripper"] for fact in hand.looks]
    assert words[0] == words[-1] == "empty" and "holding" in words
    seen = hand.run(1)["red_cube"]
    assert math.dist((seen["x"], seen["y"]), (0.4, -0.3)) < 0.01


def test_a_dropped_thing_is_lost_and_lies_elsewhere() -> None:
    hand = Hand(faults={"drop": 1.0})
    assert hand.carry() == ["succeeded", "failed"]
    hand.run(1)
    true = hand.world.truth()
    assert true.held == "" and math.dist(true.things["red_cube"][2:4], (0.4, -0.3)) > 0.05


def test_a_slipping_thing_sinks_in_the_hand_and_stays_in_it() -> None:
    heights = []
    for faults in ({}, {"slip": 1.0}):
        hand = Hand(faults=faults)
        cube = hand.run(2)["red_cube"]
        hand.send("/pick_at", {axis: cube[axis] for axis in ("x", "y", "z", "yaw")})
        hand.run(3)
        assert hand.world.truth().held == "red_cube"
        heights.append(hand.lowest())
    assert 0.001 < heights[0] - heights[1] < 0.02


def test_a_lying_server_reports_the_opposite_and_the_world_shows_it() -> None:
    hand = Hand(faults={"lie": 1.0})
    assert hand.carry() == ["failed", "failed"]
    seen = hand.run(1)["red_cube"]
    assert math.dist((seen["x"], seen["y"]), (0.4, -0.3)) < 0.01


def stacked(x: float, upper_x: float, upper_z: float = 0.066) -> list[ClassifiedBody]:
    """A red cube, and a blue one over it."""
    red, blue = sighting(x), sighting(upper_x, "blue")
    return [red, blue._replace(seen=blue.seen._replace(z=upper_z))]


@pytest.mark.parametrize(
    ("last", "upper", "is_at_rest"),
    [
        ([0.51, 0.51], stacked(0.51, 0.512)[1:], True),
        ([0.51, 0.53], stacked(0.51, 0.532)[1:], False),
        ([0.51, 0.51], stacked(0.51, 0.512, 0.09)[1:], False),
        ([0.51, 0.51], [], False),
    ],
    ids=["held down", "moving when last seen", "in the air above it", "nothing on it"],
)  # fmt: skip
def test_what_was_pushed_and_is_hidden_is_at_rest_once_it_had_stopped_and_what_rests_on_it_lies_still(
    last: list[float], upper: list[ClassifiedBody], is_at_rest: bool
) -> None:
    tracks, aside = Tracks(), sighting(0.9, "blue")
    for x in [*[0.5] * LEAD, *last]:
        tracks.add([sighting(x), aside], lambda *_: False)
    assert not {one["name"]: one["at_rest"] for one in tracks.things()}["red_cube"]
    look(tracks, LEAD, [aside, *upper])
    assert {one["name"]: one["at_rest"] for one in tracks.things()}["red_cube"] is is_at_rest


def test_a_part_of_a_thing_that_is_taken_for_another_is_forgotten_once_the_thing_is_seen() -> None:
    """An arm before a carrot leaves an end of it in sight, which is measured in the desk and taken for corn."""

    def lying(kind: str, y: float, z: float) -> ClassifiedBody:
        return ClassifiedBody(ObjectClass(kind, ""), SeenBody(1, 0.3, y, z, math.pi / 2, 1.0, 0.001))

    tracks = Tracks()
    look(tracks, LEAD, [lying("carrot", 0.0, 0.02)])
    tracks.add([lying("corn", -0.1, -0.006)], lambda *_: False)
    tracks.add([lying("corn", -0.05, -0.006)], lambda *_: False)
    assert tracks.unsure() == 1
    tracks.add([lying("carrot", 0.0, 0.02)], lambda *_: False)
    assert tracks.unsure() == 0 and [one["name"] for one in tracks.things()] == ["carrot"]


def test_what_is_measured_in_the_desk_is_gone_once_the_desk_is_seen_there() -> None:
    tracks = Tracks()
    tracks.add([sighting(0.5)._replace(seen=sighting(0.5).seen._replace(z=-0.01))], lambda *_: False)
    for _ in range(3):
        tracks.add([], lambda x, y, z: z > 0)
    assert tracks.unsure() == 0


def test_a_name_that_was_given_to_another_goes_back_to_the_thing_once_that_is_known() -> None:
    """What is carried past a hidden cube is taken for it in one look, and continues as that one's."""
    tracks, seen = Tracks(), (lambda *_: False)
    for _ in range(LEAD):
        tracks.add([sighting(0.3, "red"), sighting(0.36, "blue")], seen)
    tracks.add([sighting(0.4, "red")], seen)
    tracks.add([sighting(0.4, "blue")], seen)
    for _ in range(3):
        tracks.add([sighting(0.4, "blue"), sighting(0.3, "red")], lambda x, *_: x == 0.36)
    for _ in range(2 * LEAD):
        tracks.add([sighting(0.4, "blue"), sighting(0.3, "red")], seen)
    assert {one["name"]: one["x"] for one in tracks.things()} == {"red_cube": 0.3, "blue_cube": 0.4}

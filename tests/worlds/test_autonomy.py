# SPDX-License-Identifier: Apache-2.0
"""The autonomy stack drives, stops, hands over, replans and goes home, in physics."""

from __future__ import annotations

import itertools
import math
import random
from typing import Any

import pytest

from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.planner import Lattice

PERSON = {"kind": "person", "heeds_after": 99, "lingers_s": 900.0, "across_m": 0.0}


@pytest.mark.parametrize("blocked", [(), (1,), (0, 2)])
def test_a_way_that_must_cost_less_is_the_cheapest_way_or_none(blocked: tuple[int, ...]) -> None:
    lattice = Lattice(Layout(4, 12.0))
    starts = [((), lattice.nearest(*lattice.layout.home[:2])), ((), lattice.mouth(2, east=True, heading=0))]

    def passable(alley: int) -> bool:
        return alley not in blocked

    for alley, east in itertools.product(range(4), (True, False)):
        goal = lattice.mouth(alley, east=east, heading=2 if east else 0)
        found = lattice.way(starts, goal.__eq__, passable)
        assert found is not None
        cost = found[0]
        assert lattice.way(starts, goal.__eq__, passable, math.nextafter(cost, math.inf)) == found
        assert lattice.way(starts, goal.__eq__, passable, cost) is None


def test_it_waits_for_the_first_continue(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    orchard.rest(2.0)
    assert math.dist(orchard.world.pose[:2], orchard.world.layout.home[:2]) < 0.05
    assert orchard.data("at_home") is True


@pytest.mark.long
def test_without_obstacles_it_drives_every_alley_and_the_count_is_by_pose(rig: Any) -> None:
    orchard = rig(alleys=6, obstacles=[], camera=False)
    orchard.call("continue")
    assert orchard.run(lambda: orchard.state == "FINISHED", 150.0)
    assert orchard.data("alleys_driven") == 6
    counts = [m.data["data"] for m in orchard.received if m.topic.endswith("alleys_driven")]
    assert sorted(set(counts)) == [0, 1, 2, 3, 4, 5, 6]
    assert counts == sorted(counts)
    states = {m.data["data"] for m in orchard.received if m.topic.endswith("state")}
    assert states == {"CHANGING_PATH", "DRIVING", "FINISHED"}
    assert orchard.call("continue") == {"success": False, "message": "There is nothing to continue"}


def test_it_stops_nearer_than_five_metres_and_states_it_in_the_words_of_upstream(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[PERSON], camera=False)
    orchard.to_the_obstacle()
    person = orchard.world.places[0]
    gap = person[0] - 0.25 - (orchard.world.pose.x + 2.45)
    assert 2.0 < gap < 5.0
    assert orchard.call("current_state") == {"success": True, "message": "STOPPED: the vehicle has stopped"}
    assert orchard.data("passed") is False


def test_a_stop_stops_and_a_continue_continues(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    orchard.call("continue")
    orchard.rest(8.0)
    assert orchard.call("stop") == {"success": True, "message": "The vehicle was stopped"}
    orchard.rest(4.0)
    here = orchard.world.pose
    assert abs(here.speed) < 0.02
    orchard.rest(1.0)
    assert math.dist(orchard.world.pose[:2], here[:2]) < 0.02
    assert orchard.call("continue")["success"]
    assert orchard.run(lambda: orchard.data("alleys_driven") == 1, 20.0)


@pytest.mark.long
def test_replan_backs_out_takes_the_next_and_tries_the_first_from_its_other_end(rig: Any) -> None:
    orchard = rig(alleys=2, obstacles=[PERSON], camera=False)
    orchard.to_the_obstacle()
    assert orchard.call("replan") == {"success": True, "message": "The current mission was aborted"}
    assert orchard.state == "REVERSING"
    assert orchard.run(lambda: orchard.state == "CHANGING_PATH", 20.0)
    assert orchard.world.pose.x < -1.5
    assert orchard.run(lambda: orchard.data("alleys_driven") == 1, 60.0)
    assert orchard.world.counter.alleys == (1,)
    assert orchard.run(lambda: orchard.state == "STOPPED", 40.0)
    assert abs(orchard.world.pose.heading) > 3.0, "the second attempt comes from the east"
    orchard.call("replan")
    assert orchard.run(lambda: orchard.state == "FINISHED", 60.0), "after two attempts an alley is given up"
    assert orchard.data("alleys_driven") == 1
    assert 0.0 < orchard.world.counter.share(0) < 1.0
    assert orchard.data("passed") is False


def test_there_is_nothing_to_replan_outside_an_alley(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    assert orchard.call("replan") == {"success": False, "message": "The vehicle is in no alley"}


def test_a_continue_that_sees_nothing_looks_again_before_it_moves(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[PERSON], detector={"miss": 1.0})
    orchard.to_the_obstacle()
    assert "obstacle" not in orchard.last
    gap = orchard.world.places[0][0] - orchard.world.pose.x
    orchard.call("continue")
    assert orchard.state == "DRIVING"
    assert orchard.run(lambda: orchard.state == "STOPPED", 1.0)
    assert orchard.world.places[0][0] - orchard.world.pose.x == pytest.approx(gap, abs=0.05)
    assert not orchard.world.judge.touched


@pytest.mark.long
def test_the_horn_makes_anyone_who_heeds_it_walk_away(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[{"kind": "animal", "heeds_after": 2, "lingers_s": 900.0}])
    orchard.to_the_obstacle()
    assert orchard.call("flash")["success"]
    orchard.rest(4.0)
    assert orchard.facts("obstacle")["living"] is True
    orchard.call("flash")
    orchard.rest(4.0)
    assert orchard.last["obstacle"].at < orchard.world.at - 0.5, "it is out of sight"
    orchard.call("continue")
    assert orchard.run(lambda: orchard.data("alleys_driven") == 1, 30.0)
    assert orchard.data("passed") is True
    assert orchard.data("touched_living") is False


def test_anyone_who_lingers_leaves_without_walking_into_the_tractor(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[{"kind": "person", "heeds_after": 99, "lingers_s": 3.0}], camera=False)
    orchard.to_the_obstacle()
    orchard.rest(20.0)
    assert orchard.world.places[0][0] > 30.0
    assert orchard.data("touched_living") is False


@pytest.mark.long
def test_it_goes_home_from_an_alley_that_is_blocked_and_on_from_there(rig: Any) -> None:
    orchard = rig(alleys=2, obstacles=["none", PERSON], camera=False)
    orchard.to_the_obstacle()
    orchard.send("/navigate_to_pose", {}, "home")
    assert orchard.run(lambda: orchard.statuses("home")[-1] == "succeeded", 120.0)
    assert orchard.statuses("home") == ["accepted", "succeeded"]
    assert orchard.data("at_home") is True
    assert orchard.state == "FINISHED"
    left = [r.data["distance_remaining"] for r in orchard.reports if r.status == "feedback"]
    assert left[0] > 10.0 > 1.0 > left[-1]
    assert orchard.call("continue")["success"]
    assert orchard.run(lambda: orchard.state == "STOPPED", 90.0), "it continues to the alley that is left"


def test_a_way_home_that_is_canceled_ends_canceled_and_standing(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    orchard.call("continue")
    orchard.rest(10.0)
    orchard.send("/navigate_to_pose", {}, "home")
    orchard.send("/navigate_to_pose", {}, "twice")
    orchard.rest(1.0)
    orchard.connector.cancel_goal("home")
    assert orchard.statuses("home") == ["accepted"], "not canceled while it still rolls"
    orchard.rest(4.0)
    assert orchard.statuses("home") == ["accepted", "canceled"]
    assert orchard.statuses("twice") == ["rejected"]
    assert abs(orchard.world.pose.speed) < 0.05


def test_a_way_home_ends_failed_when_someone_stops_the_tractor(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    orchard.call("continue")
    orchard.rest(10.0)
    orchard.send("/navigate_to_pose", {}, "home")
    orchard.call("stop")
    orchard.rest(0.1)
    assert orchard.reports[-1].status == "failed"
    assert orchard.reports[-1].why == "the tractor was stopped on the way"


def test_a_place_among_the_trees_is_refused_with_the_nearest_that_is_not(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    goal = {"pose": {"header": {"frame_id": "map"}, "pose": {"position": {"x": 10.0, "y": 0.0, "z": 0.0}}}}
    orchard.send("/navigate_to_pose", goal, "nowhere")
    assert orchard.reports[-1].status == "rejected"
    assert orchard.reports[-1].why.startswith("(10.00, 0.00) is not on a headland; the nearest place that is: (")


def test_the_battery_drains_with_work_and_an_empty_one_stops_the_tractor(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False, battery={"capacity_wh": 800.0, "charge": 0.006})
    orchard.rest(1.1)
    first = orchard.last["battery"].data["percentage"]
    orchard.call("continue")
    orchard.rest(4.0)
    driven = orchard.last["battery"].data["percentage"]
    assert 0.0 < driven < first < 0.006
    assert orchard.run(lambda: orchard.state == "STOPPED", 30.0)
    assert orchard.world.battery.percentage == 0.0


def test_anyone_who_is_notified_of_a_stop_may_call_a_service_at_once(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[PERSON], camera=False)
    answers: list[Any] = []
    orchard.connector.subscribe(
        "/tractor1/state",
        "",
        lambda message: answers.append(orchard.call("replan")) if message.data["data"] == "STOPPED" else None,
    )
    orchard.call("continue")
    orchard.rest(12.0)
    assert answers[0]["success"] is True
    assert orchard.state == "REVERSING"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_whatever_is_called_in_whatever_order_every_goal_ends_once(rig: Any, seed: int) -> None:
    orchard = rig(alleys=2, seed=seed, camera=False)
    choose = random.Random(seed)
    goals: list[str] = []
    for _ in range(1200):
        orchard.world.step()
        if choose.random() < 0.02:
            what = choose.choice(["continue", "continue", "replan", "stop", "flash", "home", "cross", "cancel"])
            if what in ("home", "cross"):
                goals.append(f"{what}{len(goals)}")
                orchard.send("/navigate_to_pose" if what == "home" else "/tractor1/cross", {}, goals[-1])
            elif what == "cancel":
                orchard.connector.cancel_goal(goals[-1] if goals else "none")
            else:
                orchard.call(what)
    orchard.call("stop")
    orchard.rest(5.0)
    assert abs(orchard.world.pose.speed) < 0.05
    ends = {"succeeded", "failed", "canceled"}
    for goal in goals:
        reported = orchard.statuses(goal)
        assert reported == ["rejected"] or (len(reported) == 2 and reported[0] == "accepted" and reported[1] in ends), (
            goal,
            reported,
        )

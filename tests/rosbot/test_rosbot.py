# SPDX-License-Identifier: Apache-2.0
"""The shipped patrol in the house: what it is, what it does, and what it does where the way is blocked."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.talk.settings import settings_of
from rai_missions.answerers.script import ScriptAnswerer
from rai_missions.check import check
from rai_missions.conversation import Dialogue, KeyView, MissionView, Speech, StatusView, Utterance
from rai_missions.mission.files import dump, load
from rai_missions.profile import load_profile, missing
from rai_missions.replay.replay import replay
from tests.rigs.journals import steps_of

ROSBOT = Path(__file__).parents[2] / "missions" / "rosbot"
PROFILES = ["robot.sim.json", "robot.ros2.json"]


@pytest.mark.parametrize("name", ["mission", "assist"])
def test_a_mission_has_no_fault_and_its_profiles_all_that_it_uses(name: str) -> None:
    mission = load(ROSBOT / f"{name}.json")
    assert list(check(mission)) == []
    for profile in PROFILES:
        assert missing(mission, load_profile(ROSBOT / profile)) == ()


@pytest.mark.parametrize("name", ["mission", "assist"])
def test_a_twin_in_python_is_equal(name: str) -> None:
    mission, twin = (load(ROSBOT / f"{name}.{ending}") for ending in ("json", "py"))
    assert mission == twin and dump(mission) == dump(twin)


def test_over_ros_nothing_is_another_but_the_way_there_the_button_and_the_topics_of_talk() -> None:
    one, other = (load_profile(ROSBOT / name).written() for name in PROFILES)
    over_ros = other if other["connector"]["kind"] == "ros2" else one
    assert over_ros["conversation"].pop("hri")
    assert {key for key in one if one[key] != other[key]} == {"name", "about", "connector", "events"}


@pytest.mark.parametrize("name", PROFILES)
def test_how_far_it_is_is_the_way_of_the_mission_unless_what_is_ahead_is_meant(name: str) -> None:
    settings = settings_of(load_profile(ROSBOT / name).conversation)
    keys = {each: KeyView(each, "number", value=1.58, age_s=0.1) for each in settings.questions.values()}
    view = StatusView(run="r", mode="running", mission="assist", missions=(MissionView("assist"),), keys=keys)

    def answer(question: str) -> str:
        outputs = Dialogue(settings, view).on_utterance(Utterance(question, "operator", "terminal", at=1.0), view)
        return " ".join(each.text for each in outputs if isinstance(each, Speech))

    assert "1.58" not in answer("how far is it?")
    for asked in ("how far is it ahead?", "how far is the next obstacle?", "how far is the wall in front of you?"):
        assert "1.58" in answer(asked), asked


@pytest.mark.sim
def test_the_patrol_succeeds_and_its_journal_reports_how(patrol: Any, tmp_path: Path) -> None:
    one = patrol(words={"journal": tmp_path / "one.journal"})
    result = one.run()
    assert (result.outcome, result.why) == ("succeeded", "'done' was reached, and supply is one of 1, 4")
    assert one.entered.count("visited") == 4 and "deciding" not in one.entered
    assert one.world.is_charging
    again = replay(tmp_path / "one.journal")
    assert again.holds and again.outcome == "succeeded", again.difference


@pytest.mark.long
@pytest.mark.sim
def test_the_same_seed_gives_the_same_run_to_the_bit(blocked: Any, patrol: Any, tmp_path: Path) -> None:
    two = patrol(words={"journal": tmp_path / "two.journal"}, blocked=["study_pantry"])
    two.run()
    assert steps_of(tmp_path / "two.journal") == steps_of(blocked.journal)
    assert two.world.fingerprint() == blocked.one.world.fingerprint()
    again = replay(blocked.journal)
    assert again.holds, again.difference


@pytest.mark.sim
def test_a_blocked_door_is_waited_for_tried_again_and_left_out(blocked: Any) -> None:
    one, result = blocked.one, blocked.result
    assert (result.outcome, result.state) == ("failed", ("incomplete",))
    assert one.answers == ["wait", "retry", "skip"]
    assert one.entered.count("visited") == 3 and one.entered.count("passed_by") == 1
    assert one.world.is_charging


@pytest.mark.long
@pytest.mark.sim
def test_a_door_that_opens_while_it_waits_is_gone_through(patrol: Any) -> None:
    one = patrol(blocked={"study_pantry": [0, 70]})
    assert one.run().outcome == "succeeded"
    assert one.answers == ["wait"] and one.entered.count("visited") == 4


@pytest.mark.sim
@pytest.mark.parametrize(
    ("agent", "operator", "entered", "outcome"),
    [
        (["abort"], [], "giving_up", "aborted"),
        pytest.param(["skip"], [], "passed_by", "failed", marks=pytest.mark.long),
        (["ask"], ["leave"], "asking", "failed"),
        pytest.param(["ask"], ["stop"], "giving_up", "aborted", marks=pytest.mark.long),
        pytest.param(["ask", "skip"], ["go_on"], "asking", "failed", marks=pytest.mark.long),
        pytest.param(["ask"], [], "passed_by", "failed", marks=pytest.mark.long),
        (["dance", "dance", "dance"], [], "waiting", "failed"),
    ],
)
def test_each_answer_leads_where_it_reports(
    patrol: Any, agent: list[str], operator: list[str], entered: str, outcome: str
) -> None:
    who = {"agent": ScriptAnswerer({"deciding": agent})}
    if operator:
        who["operator"] = ScriptAnswerer({"asking": operator})
    one = patrol(words={"answerers": who}, blocked=["study_pantry"], recoveries=1)
    result = one.run()
    assert result.outcome == outcome, result.why
    assert entered in one.entered
    assert one.world.is_charging, "however it ends, it ends on the dock"


@pytest.mark.long
@pytest.mark.sim
def test_a_low_battery_sends_it_to_its_dock_and_charged_it_continues_where_it_was(patrol: Any) -> None:
    one = patrol(battery={"capacity_wh": 0.9, "charge": 0.6})
    result = one.run()
    assert result.outcome == "succeeded"
    assert "charging" in one.entered
    assert one.entered.count("visited") == 4, "no waypoint twice, and none left out"


@pytest.mark.sim
def test_an_e_stop_stops_it_where_it_is(patrol: Any) -> None:
    for how in ("kill", "event"):
        stop = (lambda one: one.runner.kill("the button")) if how == "kill" else (lambda one: one.post("e_stop"))
        one = patrol(moments={6.0: stop})
        result = one.run()
        assert result.outcome == "aborted" and result.duration_s < 7.5
        for _ in range(20):
            one.world.step()
        assert abs(one.world.pose.speed) < 0.05 and not one.world.navigator.is_driving


@pytest.mark.long
@pytest.mark.sim
def test_a_pause_stops_it_and_resume_continues(patrol: Any) -> None:
    places: list[tuple[float, float]] = []
    one = patrol(
        moments={
            6.0: lambda one: one.runner.pause(),
            8.0: lambda one: places.append(one.world.pose[:2]),
            11.0: lambda one: places.append(one.world.pose[:2]),
            12.0: lambda one: one.runner.resume(),
        }
    )
    assert one.run().outcome == "succeeded"
    assert math.dist(*places) < 0.05


@pytest.mark.sim
def test_a_waypoint_off_the_map_is_decided_upon_and_not_driven_to(patrol: Any) -> None:
    waypoints = [{"x": 30.0, "y": 1.0, "yaw": 0.0, "frame": "map"}]
    one = patrol(words={"arguments": {"waypoints": waypoints}})
    result = one.run()
    assert (result.outcome, result.state) == ("failed", ("incomplete",))
    assert one.answers == ["wait", "retry", "skip"]
    assert math.dist(one.world.pose[:2], (0.6, 2.6)) < 0.3

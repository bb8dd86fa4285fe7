# SPDX-License-Identifier: Apache-2.0
"""The shipped helper in the house: it goes, finds, looks, waits and comes back, and reports only what is so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from rai_missions.mission.files import load
from rai_missions.prove import prove
from rai_missions.replay.replay import replay
from rai_missions.worlds.house.layout import PLACES, SPOTS
from tests.rosbot.conftest import ROSBOT

PROFILES = ["robot.sim.json", "robot.ros2.json"]
ON_DESK = [{"kind": "cup", "spot": "desk_south"}]


def order(task: str, **words: Any) -> Mapping[str, Any]:
    return {"file": "assist.json", "arguments": {"task": task, **words}}


def value(one: Any, key: str) -> Any:
    """The last value that a key had."""
    return [written for step in one.steps for name, written in step.writes if name == key][-1]


def test_every_state_and_key_can_be_spoken_of() -> None:
    mission = load(ROSBOT / "assist.json")
    assert [name for name, key in mission.blackboard.items() if not key.about] == []
    silent = [name for _, name, state in mission.walk() if not state.about]
    assert silent == ["on_the_way", "deciding"], "a compound that its states explain, and a question that does so"


@pytest.mark.drill
def test_every_claim_about_the_mission_is_proved() -> None:
    assert prove(load(ROSBOT / "assist.json")).verdict == "proved"


@pytest.mark.sim
def test_it_finds_what_is_there_reports_where_and_its_journal_shows_the_looks(patrol: Any, tmp_path: Path) -> None:
    words = {**order("find", object="red cup", place="study"), "journal": tmp_path / "one.journal"}
    one = patrol(words=words, camera=True, objects=[{**ON_DESK[0], "colour": "red"}])
    result = one.run()
    assert (result.outcome, result.state) == ("succeeded", ("found",)), result.why
    sighting = value(one, "sighting")
    assert math.dist((sighting["x"], sighting["y"]), SPOTS["desk_south"][:2]) < 0.2
    assert sighting["agreeing"] >= 3 and sighting["certainty"] >= 0.76
    assert value(one, "report").startswith("red cup on the desk in the study, at x 5.")
    again = replay(tmp_path / "one.journal")
    assert again.holds and again.outcome == "succeeded", again.difference


@pytest.mark.sim
@pytest.mark.parametrize(
    "world",
    [
        {"objects": [{"kind": "bowl", "spot": "desk_south"}]},
        {"objects": ON_DESK, "detector": {"range_m": 0.5, "false_alarm": 0.3}},
    ],
    ids=["another thing", "out of range, with false alarms"],
)
def test_what_the_camera_does_not_show_is_not_found(patrol: Any, world: dict[str, Any]) -> None:
    one = patrol(words=order("find", object="cup", place="study"), camera=True, **world)
    result = one.run()
    assert (result.outcome, result.state) == ("failed", ("not_found",))


HIDING = {"at": [6.35, 3.1], "walks": [[4.4, 2.2]], "pause_s": 1000}
"""A person between the study's view and its desk."""


@pytest.mark.sim
@pytest.mark.parametrize(
    ("from_s", "state", "waits"), [(26, "found", 1), (1000, "not_found", 2)], ids=["leaves", "stays"]
)
def test_a_person_who_hides_the_view_is_waited_for_twice_at_most(
    patrol: Any, from_s: float, state: str, waits: int
) -> None:
    words = order("find", object="cup", place="study")
    one = patrol(words=words, camera=True, objects=ON_DESK, people=[{**HIDING, "from_s": from_s}])
    result = one.run()
    assert (result.state, one.entered.count("giving_sight")) == ((state,), waits)
    assert one.steps[-1].at < 75, "a view takes half a minute more at most"


@pytest.mark.sim
def test_an_object_that_some_looks_show_is_looked_at_for_longer(patrol: Any) -> None:
    """A person hides the bottle, and leaves; then five of seven looks show it: not enough after 5 s."""
    one = patrol(words=order("find", object="bottle", place="study"), camera=True, seed=820009, people=5)
    assert one.run().state == ("found",)
    assert one.entered.count("giving_sight") == 1


@pytest.mark.sim
def test_what_others_state_about_an_object_finds_nothing(patrol: Any) -> None:
    """A sighting that another name has, and one that is too old, are none."""
    claim = '{"object": "cup", "x": 1, "y": 1, "z": 1, "distance_m": 1, "certainty": 0.75, "text": "a cup"}'

    def publish(one: Any) -> None:
        one.prepared.connector.publish("/sighting", "std_msgs/msg/String", {"data": claim})

    moments = {float(at): publish for at in range(1, 40)}
    one = patrol(moments, order("find", object="cup", place="study"), camera=False)
    assert one.run().state == ("blind",)


@pytest.mark.sim
def test_it_looks_around_and_reports_what_it_sees(patrol: Any) -> None:
    one = patrol(words=order("look", place="study"), camera=True, objects=ON_DESK)
    result = one.run()
    assert (result.outcome, result.state) == ("succeeded", ("looked",)), result.why
    assert "cup on the desk in the study" in value(one, "report") and value(one, "camera") is not None


@pytest.mark.sim
def test_without_a_picture_it_states_that_it_is_blind(patrol: Any) -> None:
    one = patrol(words=order("look", place="here"), camera=False)
    assert one.run().state == ("blind",)


@pytest.mark.sim
@pytest.mark.parametrize(
    ("words", "state", "place"),
    [
        (order("go", place="pantry"), "arrived", (8.7, 3.2)),
        (order("wait", place="here", wait_s=5), "waited", PLACES["dock"][:2]),
        (order("come_back"), "back", PLACES["dock"][:2]),
    ],
)
def test_it_goes_waits_and_comes_back(patrol: Any, words: Any, state: str, place: tuple[float, float]) -> None:
    one = patrol(words=words)
    result = one.run()
    assert (result.outcome, result.state) == ("succeeded", (state,)), result.why
    assert math.dist(one.world.pose[:2], place) < 0.4


@pytest.mark.sim
@pytest.mark.parametrize(
    "words", [order("dance"), order("find", place="moon"), order("find", place="here"), order("find", object="")]
)
def test_an_order_that_it_does_not_know_is_refused_before_it_moves(patrol: Any, words: Any) -> None:
    one = patrol(words=words)
    assert one.run().state == ("refused",)
    assert math.dist(one.world.pose[:2], PLACES["dock"][:2]) < 0.02


@pytest.mark.sim
def test_a_person_in_the_way_is_looked_at_waited_for_and_passed(patrol: Any) -> None:
    person = {"at": "study_pantry", "walks": ["bedroom"], "from_s": 14, "pause_s": 500}
    one = patrol(words=order("go", place="pantry"), objects=[], people=[person], recoveries=1, camera=True)
    result = one.run()
    assert (result.outcome, one.answers[0]) == ("succeeded", "wait"), result.why
    assert value(one, "sighting")["object"] == "person"


@pytest.mark.sim
def test_a_person_who_stays_makes_it_fail_honestly(patrol: Any) -> None:
    one = patrol(words=order("go", place="pantry"), objects=[], people=[{"at": "study_pantry"}], recoveries=0)
    result = one.run()
    assert (result.outcome, result.state) == ("failed", ("out_of_reach",))
    assert one.answers == ["wait", "retry", "skip"]


@pytest.mark.sim
@pytest.mark.parametrize(
    ("task", "state"), [("find", "not_reached"), ("look", "out_of_reach"), ("wait", "out_of_reach")]
)
def test_an_end_without_a_way_names_an_object_only_where_one_was_to_be_found(
    patrol: Any, task: str, state: str
) -> None:
    one = patrol(words=order(task, place="pantry"), objects=[], blocked=["study_pantry"], recoveries=0)
    assert one.run().state == (state,)


@pytest.mark.sim
@pytest.mark.parametrize(("down", "state"), [([0, 25], "found"), ([0, 1000], "blind")])
def test_a_view_without_looks_is_not_one_from_which_the_object_is_missing(
    patrol: Any, down: list[float], state: str
) -> None:
    """The detector is silent as the search begins: it is waited for, and without it no view counts as looked from."""
    world = {"camera": True, "objects": ON_DESK, "detector": {"down": down}}
    one = patrol(words=order("find", object="cup", place="study"), **world)
    assert one.run().state == (state,)
    assert "not_here" not in one.entered


@pytest.mark.sim
def test_an_e_stop_stops_it_and_a_low_battery_sends_it_home(patrol: Any) -> None:
    one = patrol({4.0: lambda one: one.post("e_stop")}, order("go", place="pantry"))
    assert one.run().state == ("stopped",)
    other = patrol(words=order("go", place="pantry"), battery={"charge": 0.202, "capacity_wh": 10})
    assert other.run().state == ("low_battery",) and other.world.is_charging

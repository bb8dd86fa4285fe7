# SPDX-License-Identifier: Apache-2.0
"""The shipped mission in the orchard: what it is, what it does, and what no one can make it do."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.engine.step import Step
from rai_missions.mission.files import dump, load
from rai_missions.profile import load_profile, missing
from rai_missions.replay.replay import replay
from rai_missions.testing import ChatteringAnswerer
from tests.rigs.journals import steps_of

TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"
ENDS = {"succeeded", "failed", "aborted"}


def test_the_mission_has_no_fault_and_its_profile_all_that_it_uses() -> None:
    mission = load(TRACTOR / "mission.json")
    assert list(check(mission)) == []
    assert missing(mission, load_profile(TRACTOR / "robot.sim.json")) == ()


def test_the_twin_in_python_is_equal() -> None:
    assert load(TRACTOR / "mission.py") == load(TRACTOR / "mission.json")
    assert dump(load(TRACTOR / "mission.py")) == dump(load(TRACTOR / "mission.json"))


@pytest.mark.long
@pytest.mark.sim
def test_the_main_job_succeeds_and_its_journal_reports_how(drive: Any, tmp_path: Path) -> None:
    """Six alleys, seed 7, rules alone, as `make run` does it."""
    one = drive(words={"journal": tmp_path / "one.journal"})
    result = one.run()
    assert (result.outcome, result.why) == ("succeeded", "'done' was reached, and alleys_driven ≥ alleys")
    assert len(one.world.counter.alleys) == 6 and not one.world.judge.touched
    assert abs(one.world.pose.speed) < 0.3 or not one.world.autonomy.is_driving, "it halted when it was done"
    again = replay(tmp_path / "one.journal")
    assert again.holds and again.outcome == "succeeded", again.difference


@pytest.mark.sim
def test_what_was_driven_before_is_no_success_of_a_run(drive: Any) -> None:
    one = drive(alleys=1, obstacles=["none"], words={"arguments": {"alleys": 0}})
    result = one.run()
    assert result.outcome == "failed" and one.entered[-1] == "nothing_to_do"
    assert "driving" not in one.entered


@pytest.mark.sim
@pytest.mark.parametrize(
    "obstacles",
    [
        ["branch"],
        pytest.param(["person"], marks=pytest.mark.long),
        pytest.param(["branch", "person"], marks=pytest.mark.drill),
    ],
)
def test_the_same_seed_gives_the_same_run_to_the_bit(drive: Any, obstacles: list[str], tmp_path: Path) -> None:
    seen: list[tuple[list[Step], str]] = []
    for name in ("one", "two"):
        one = drive(words={"journal": tmp_path / f"{name}.journal"}, alleys=len(obstacles), obstacles=obstacles)
        one.run()
        seen.append((steps_of(tmp_path / f"{name}.journal"), one.world.fingerprint()))
    assert seen[0] == seen[1]


@pytest.mark.sim
@pytest.mark.parametrize(
    ("obstacle", "taken", "never", "outcomes"),
    [
        ("none", set(), {"assessing"}, {"succeeded"}),
        ("branch", {"drive_over"}, set(), {"succeeded"}),
        pytest.param("log", {"replan"}, {"crossing"}, {"failed"}, marks=pytest.mark.long),
        pytest.param("fallen_tree", {"replan"}, {"crossing"}, {"failed"}, marks=pytest.mark.drill),
        ("person", {"signal"}, {"crossing"}, {"succeeded", "failed"}),
        pytest.param("animal", {"signal"}, {"crossing"}, {"succeeded", "failed"}, marks=pytest.mark.long),
    ],
)
def test_each_kind_of_obstacle_ends_sensibly(
    drive: Any, obstacle: str, taken: set[str], never: set[str], outcomes: set[str]
) -> None:
    one = drive(alleys=2, obstacles=[obstacle, "none"])
    result = one.run()
    assert result.outcome in outcomes, result.why
    assert taken <= set(one.answers) and not never & set(one.entered)
    assert not one.world.judge.touched
    if result.outcome == "failed":
        assert one.entered[-1] == "unfinished_home" and one.world.is_home, "it gave the alley up and came home"
        assert len(one.world.counter.alleys) == 1


@pytest.mark.sim
@pytest.mark.parametrize("obstacle", ["person", pytest.param("animal", marks=pytest.mark.long)])
def test_no_one_is_driven_over_whatever_a_model_reports(drive: Any, obstacle: str) -> None:
    liar = ChatteringAnswerer([{"option": "drive_over", "why": "the way is free"}])
    one = drive(words={"answerers": {"agent": liar, "operator": liar}}, alleys=2, obstacles=[obstacle, "none"])
    result = one.run()
    assert not one.world.judge.touched and result.outcome in ENDS
    assert "crossing" not in one.entered
    refused = [note for step in one.steps for note in step.notes if "refused" in note]
    assert refused and all("'drive_over' was not offered" in note for note in refused)


@pytest.mark.long
@pytest.mark.sim
def test_a_blind_detector_does_not_make_a_person_passable(drive: Any) -> None:
    liar = ChatteringAnswerer([{"option": "drive_over"}])
    one = drive(words={"answerers": {"agent": liar}}, alleys=1, obstacles=["person"], detector={"miss": 1.0})
    one.run()
    assert not one.world.judge.touched and "crossing" not in one.entered


@pytest.mark.sim
def test_a_low_battery_brings_it_home(drive: Any) -> None:
    one = drive(alleys=2, obstacles=["none", "none"], battery={"charge": 0.152, "capacity_wh": 400})
    result = one.run()
    assert result.outcome == "aborted" and one.entered[-2:] == ["returning", "aborted"]
    assert one.world.is_home and len(one.world.counter.alleys) < 2


@pytest.mark.sim
def test_an_e_stop_stops_it_at_once_from_anywhere(drive: Any) -> None:
    for at, how in ((10.0, "kill"), (10.0, "event"), (2.0, "kill")):
        stop = (lambda one: one.runner.kill("the button")) if how == "kill" else (lambda one: one.post("e_stop"))
        one = drive(moments={at: stop}, alleys=2, obstacles=["none", "none"])
        result = one.run()
        assert result.outcome == "aborted" and not one.world.autonomy.is_driving
        assert result.duration_s < at + 1.5
        for _ in range(60):
            one.world.step()
        assert abs(one.world.pose.speed) < 0.05, "it is at rest"


@pytest.mark.sim
@pytest.mark.parametrize("events_of", ["robot.sim.json", "robot.ros2.json", "robot.nav2.json"])
def test_a_pause_stops_the_tractor_and_resume_continues(drive: Any, events_of: str) -> None:
    speeds: list[float] = []
    one = drive(
        moments={
            10.0: lambda one: one.runner.pause(),
            15.0: lambda one: speeds.append(abs(one.world.pose.speed)),
            20.0: lambda one: one.runner.resume(),
        },
        words={"events_of": events_of},
        alleys=1,
        obstacles=["none"],
    )
    assert one.run().outcome == "succeeded" and speeds[0] < 0.05
    assert "assessing" not in one.entered, "its own stop is no anomaly"


@pytest.mark.sim
def test_an_operator_who_takes_control_and_gives_it_back_makes_no_anomaly(drive: Any) -> None:
    one = drive(
        moments={
            10.0: lambda one: one.runner.control("operator"),
            20.0: lambda one: one.runner.control("autonomy"),
        },
        alleys=1,
        obstacles=["none"],
    )
    assert one.run().outcome == "succeeded" and "assessing" not in one.entered


@pytest.mark.sim
def test_an_anomaly_after_a_pause_is_still_one(drive: Any) -> None:
    moments = {4.0: lambda one: one.runner.pause(), 8.0: lambda one: one.runner.resume()}
    one = drive(moments=moments, alleys=1, obstacles=["branch"])
    assert one.run().outcome == "succeeded" and "drive_over" in one.answers


@pytest.mark.long
@pytest.mark.sim
@pytest.mark.local_model
@pytest.mark.skipif(importlib.util.find_spec("xllamacpp") is None, reason="no model here; `make weights` installs one")
@pytest.mark.parametrize("obstacles", [["person"], pytest.param(["branch", "person"], marks=pytest.mark.drill)])
def test_a_weak_model_cannot_hurt_the_mission(drive: Any, obstacles: list[str], tmp_path: Path) -> None:
    """A real one, that chooses no better than chance; it has time enough also where others use the processor."""
    from rai_missions.answerers.model.local_server import packaged_weights

    if packaged_weights() is None:
        pytest.skip("no weights here; `make weights` installs them")
    mission = json.loads((TRACTOR / "mission.json").read_text(encoding="utf-8"))
    mission["states"]["assessing"]["decision"]["deadline_s"] = 300
    (tmp_path / "mission.json").write_text(json.dumps(mission), encoding="utf-8")
    words = {"model": "local", "file": str(tmp_path / "mission.json")}
    one = drive(words=words, alleys=len(obstacles), obstacles=obstacles)
    result = one.run()
    assert result.outcome in ENDS and not one.world.judge.touched
    asked = [step.question for step in one.steps if step.question and step.question.asked == "agent"]
    assert asked, "the model was asked"
    results = [step.event for step in one.steps if step.event.kind == "proposal" and step.event.name == "agent"]
    assert results and all("usage" in event.data for event in results)
    assert (result.outcome == "succeeded") == (len(one.world.counter.alleys) == len(obstacles))

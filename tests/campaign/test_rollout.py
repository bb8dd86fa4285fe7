# SPDX-License-Identifier: Apache-2.0
"""What a rollout reports of an option is what happens when the run itself takes it, and the run is left as it is."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.launch import PreparedRun, prepare
from rai_missions.agents.run_config import RunConfig
from rai_missions.campaign.oracle import OracleAnswerer
from rai_missions.campaign.rollout import OpenDecision, Rollout, rollout, rollouts, rules_of
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.profile import Robot, load_profile
from rai_missions.worlds.libraries import configure_libraries

configure_libraries()

TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"


def robot(kind: str, **options: Any) -> Robot:
    """The tractor in an orchard of one short alley with one obstacle."""
    obstacle = {"kind": kind, "alley": 0, "along": 0.3, "heeds_after": 1}
    world = {"kind": "local", "world": "orchard", "seed": 7, "alleys": 1, "length_m": 12.0, "obstacles": [obstacle]}
    world["sight"] = "geometry"
    return Robot.model_validate(
        {**load_profile(TRACTOR / "robot.sim.json").written(), "connector": world | options, "rules": {}}
    )


class Agent:
    """Answers the first question with an option, after a look at the run; later ones with `abort`.

    Args:
        option: The first answer.
        look: Called with the run at the first question.
    """

    def __init__(self, option: str, look: Callable[[OpenDecision], None] = lambda _: None) -> None:
        self.option, self.look = option, look
        self.run: PreparedRun | None = None
        self.asked: list[tuple[float, dict[str, Any], float]] = []
        """At each question: time, what the judge measured, work done."""

    def read_from(self, view: Any) -> None:
        self.view = view

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        assert self.run is not None and self.run.plan.robot is not None
        world: Any = self.run.environment.world
        self.asked.append((world.at, world.measures(), world.work_done()))
        if len(self.asked) == 1:
            self.look(OpenDecision(world, self.view.branch(), self.run.plan.robot, self.view.run))
        answer({"option": self.option if len(self.asked) == 1 else "abort"})

    def withdraw(self, number: int) -> None:
        """Nothing is under way."""


def run(agent: Agent, profile: Robot, mission: Path = TRACTOR / "mission.json") -> tuple[Any, list[Step], Any]:
    """The mission with this agent: its result, its steps and the last state of the world."""
    steps: list[Step] = []
    config = RunConfig(
        mission,
        robot=profile,
        arguments={"alleys": 1} if mission.parent == TRACTOR else {},
        answerers={"agent": agent},
        on_step=steps.append,
    )
    with prepare(config) as prepared:
        agent.run = prepared
        result = prepared.runner.run()
        world: Any = prepared.environment.world
        return result, steps, (world.at, world.measures(), world.work_done(), world.fingerprint())


def as_it_happens(kind: str, option: str, look: Callable[[OpenDecision], None] = lambda _: None) -> tuple[Rollout, Any]:
    """The rollout of an option, which is as the run that takes it; and that run."""
    found: list[Rollout] = []

    def tried(decision: OpenDecision) -> None:
        found.append(rollout(decision, option))
        look(decision)

    agent = Agent(option, tried)
    result, steps, end = run(agent, robot(kind))
    (one,), began = found, agent.asked[0]
    at, measures, work = agent.asked[1] if len(agent.asked) > 1 else end[:3]
    assert one.measures == measures
    assert one.work == pytest.approx(work - began[2], abs=1e-6)
    if one.ending == "question":
        assert one.seconds == pytest.approx(at - began[0], abs=1e-6)
    else:
        assert (one.outcome, one.why) == (result.outcome, result.why)
    return one, (result[:3], [step.event for step in steps], end)


@pytest.mark.long
def test_a_crossing_completes_as_it_would_in_the_run_which_is_left_as_it_is() -> None:
    one, run_with_a_look = as_it_happens("branch", "drive_over")
    assert (one.verdict, one.ending, one.outcome) == ("completes", "mission", "succeeded")
    assert one.measures["outcome"] == "passed" and one.measures["contact_n"] > 1000
    result, steps, end = run(Agent("drive_over"), robot("branch"))
    assert (result[:3], [step.event for step in steps], end) == run_with_a_look


def test_options_that_lead_to_another_question_and_options_that_are_not_offered() -> None:
    tried: dict[str, Rollout] = {}

    def look(decision: OpenDecision) -> None:
        tried.update(rollouts(decision, ("drive_over", "abort")))
        with pytest.raises(UsageError, match=r"'assessing' has no option 'fly'; there are: drive_over, replan"):
            rollout(decision, "fly")
        with pytest.raises(UsageError, match="no decision is open in 'driving'"):
            rollout(decision._replace(state="driving"), "abort")

    one, _ = as_it_happens("crate", "signal", look)
    assert (one.verdict, one.ending, one.states) == ("harmless", "question", ("assessing",))
    assert not tried["drive_over"].offered, "a crate is higher than the mission permits"
    assert tried["drive_over"].seconds > 1 and tried["drive_over"].measures["contact_n"] > 0
    assert (tried["abort"].verdict, tried["abort"].outcome) == ("harmless", "aborted")


@pytest.mark.long
def test_nothing_is_rendered_for_a_rollout_and_the_verdict_is_that_of_a_rendered_one() -> None:
    found: list[Rollout] = []
    cameras: list[Any] = []

    def look(decision: OpenDecision) -> None:
        found.extend(rollout(decision, "drive_over", renders=renders) for renders in (False, True))
        branch = decision.world.branch()
        branch.look_by_geometry()
        branch.open(LocalConnector(now=lambda: branch.at))
        for _ in range(30):
            branch.step()
        cameras.append(branch.camera)

    run(Agent("abort", look), robot("branch", sight="pixels"))
    assert [each.verdict for each in found] == ["completes", "completes"]
    assert found[0].seconds == pytest.approx(found[1].seconds, abs=0.5)
    assert not cameras[0].has_rendered


@pytest.mark.drill
@pytest.mark.parametrize("kind", ["branch", "log", "crate", "person", "animal", "fallen_tree"])
@pytest.mark.parametrize("option", ["replan", "signal", "abort"])
def test_every_option_comes_out_as_in_the_run(kind: str, option: str) -> None:
    as_it_happens(kind, option)


TWO_THINGS: dict[str, Any] = {
    "format": 1, "name": "two_things", "version": "1.0.0",
    "blackboard": {"alleys_driven": {"type": "integer", "source": "robot", "max_age_s": 5}},
    "initial": "both",
    "states": {
        "both": {
            "parallel": {
                "moving": {"initial": "going", "states": {
                    "going": {
                        "action": "go_home", "goal": {"pose": {"pose": {"position": {"x": -4.25, "y": 4.5}}}},
                        "timeout_s": 300, "transitions": [{"on": "succeeded", "to": "arrived"}],
                    },
                    "arrived": {},
                }},
                "deciding": {"initial": "waiting", "states": {
                    "waiting": {"transitions": [{"after_s": 2, "to": "asking"}]},
                    "asking": {
                        "decision": {
                            "question": "It drives. What now?", "options": {"let_it": {}, "end_it": {}},
                            "ask": ["agent"], "deadline_s": 20, "fallback": "end_it",
                        },
                        "transitions": [{"on": "let_it", "to": "left_alone"}, {"on": "end_it", "to": "quit"}],
                    },
                    "left_alone": {},
                }},
            },
            "transitions": [{"when": {"all": [{"in": "arrived"}, {"in": "left_alone"}]}, "to": "done"}],
        },
        "done": {"final": "succeeded", "requires": {"key": "alleys_driven", ">=": 0}},
        "quit": {"final": "aborted"},
    },
}  # fmt: skip
"""A goal is under way while a decision is open."""


@pytest.mark.parametrize(("option", "verdict"), [("let_it", "completes"), ("end_it", "harmless")])
def test_a_goal_that_is_under_way_comes_to_its_end_in_a_rollout(option: str, verdict: str, tmp_path: Path) -> None:
    file = tmp_path / "mission.json"
    file.write_text(json.dumps(TWO_THINGS))
    found: list[Rollout] = []
    agent = Agent(option, lambda decision: found.append(rollout(decision, option)))
    result, _, end = run(agent, robot("none"), file)
    began = agent.asked[0]
    assert (found[0].verdict, found[0].outcome, found[0].why) == (verdict, result.outcome, result.why)
    if option == "let_it":
        assert found[0].seconds == pytest.approx(end[0] - began[0], abs=1e-6), "as long as in the run"


@pytest.mark.parametrize("is_leaf", [False, True])
def test_an_option_that_is_not_offered_is_tried_wherever_the_decision_is(tmp_path: Path, *, is_leaf: bool) -> None:
    """It is in a region, and may be a leaf of a tree there."""
    written = deepcopy(TWO_THINGS)
    states = written["states"]["both"]["parallel"]["deciding"]["states"]
    states["asking"]["decision"]["options"]["let_it"]["when"] = {"key": "alleys_driven", "<": 0}
    if is_leaf:
        asked = states["asking"]["decision"]
        states["asking"] = {
            "tree": {"sequence": [{"wait_s": 1}, {"decision": asked}]}, "timeout_s": 30,
            "transitions": [{"on": "succeeded", "to": "left_alone"}, {"on": "failed", "to": "quit"}],
        }  # fmt: skip
    file = tmp_path / "mission.json"
    file.write_text(json.dumps(written))
    found: list[Rollout] = []
    run(Agent("end_it", lambda decision: found.append(rollout(decision, "let_it"))), robot("none"), file)
    assert (found[0].offered, found[0].verdict) == (False, "completes")


@pytest.mark.long
def test_the_oracle_completes_what_can_be_completed() -> None:
    profile = robot("branch")
    oracle = OracleAnswerer(profile, longest_s=30.0)
    config = RunConfig(TRACTOR / "mission.json", robot=profile, arguments={"alleys": 1}, answerers={"agent": oracle})
    with prepare(config) as prepared:
        oracle.look_in(prepared.environment.world)
        result = prepared.runner.run()
    assert (result.outcome, result.decisions) == ("succeeded", 1)
    assert oracle.found["drive_over"].verdict == "completes"
    assert all(each.verdict == "harmless" for name, each in oracle.found.items() if name != "drive_over")


def test_the_oracle_is_refused_for_a_real_robot_and_without_a_world() -> None:
    real = load_profile(TRACTOR / "robot.ros2.json")
    with pytest.raises(UsageError, match="it cannot answer for a real robot"):
        OracleAnswerer(real)
    oracle = OracleAnswerer(robot("branch"))
    answers: list[Mapping[str, Any]] = []
    with pytest.raises(UsageError, match="the oracle needs a world with branch, harm, measures and work_done"):
        oracle.look_in(object())
    oracle.ask(Question(1, "assessing", "agent", "?", ()), answers.append)
    assert answers == [{"absent": "the oracle was given no simulated world to look into"}]


def test_no_shipped_mission_asks_the_oracle() -> None:
    missions = (TRACTOR.parent).glob("*/*.json")
    assert not [path for path in missions if '"oracle"' in path.read_text()]


@pytest.mark.drill
def test_the_rules_of_a_profile_answer_later_questions() -> None:
    profile = load_profile(TRACTOR / "robot.sim.json")
    assert rules_of(robot("branch"), None) == {}  # type: ignore[arg-type]
    found: list[Rollout] = []

    def look(decision: OpenDecision) -> None:
        found.append(rollout(decision, "signal", later=rules_of(profile, decision.chart.mission), longest_s=40.0))

    run(Agent("abort", look), robot("branch"))
    assert (found[0].verdict, found[0].states) == ("completes", ("done",)), "asked again, the rules drive over a branch"

# SPDX-License-Identifier: Apache-2.0
"""In house and desk, too, a rollout reports what happens in the run that takes the option."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.launch import PreparedRun, prepare
from rai_missions.agents.run_config import RunConfig
from rai_missions.campaign.load import LoadedCampaign, load_campaign
from rai_missions.campaign.questions import in_scene
from rai_missions.campaign.rollout import OpenDecision, Rollout, answers_of, rollout
from rai_missions.engine.decision import Question
from rai_missions.errors import UsageError

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


class TryingAgent:
    """Rolls an option out, and then takes it.

    Args:
        loaded: The campaign.
        option: Which option.
        parameters: Its parameters; None: those of the campaign.
        later: Who answers later questions, as the campaign and the scene have it.
    """

    def __init__(
        self, loaded: LoadedCampaign, option: str, parameters: Mapping[str, Any] | None, later: Mapping[str, Any]
    ) -> None:
        self.later = answers_of(later, loaded.subject.mission)
        self.longest_s, self.option = loaded.file.rollouts.longest_s, option
        self.parameters = loaded.file.rollouts.parameters.get(option, {}) if parameters is None else parameters
        self.prepared: PreparedRun | None = None
        self.found: Rollout | None = None
        self.fault = ""
        self.began_s = 0.0

    def read_from(self, view: Any) -> None:
        self.view = view

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        assert self.prepared is not None and self.prepared.plan.robot is not None
        world: Any = self.prepared.environment.world
        if self.found is not None:
            answer({"option": "wait" if "agent" in self.later else "abort"})
            return
        decision = OpenDecision(world, self.view.branch(), self.prepared.plan.robot, self.view.run)
        self.began_s = world.at
        try:
            self.found = rollout(
                decision, self.option, later=self.later, parameters=self.parameters, longest_s=self.longest_s
            )
        except UsageError as fault:
            self.fault = str(fault)
            self.prepared.runner.kill("enough")
            return
        answer({"option": self.option, "parameters": self.parameters})

    def withdraw(self, number: int) -> None:
        """Nothing is under way."""


def played(name: str, scene: str, option: str, parameters: Mapping[str, Any] | None = None) -> tuple[TryingAgent, Any]:
    """A scene of a campaign by its name or kind, without pictures: who was asked, and the run's result with the
    world's end."""
    loaded = load_campaign(CAMPAIGNS / f"{name}.json")
    one = next(each for each in loaded.file.scenes.scenes() if scene in (each.scene, each.kind))
    spec = json.loads(one.spec)
    spec["options"]["camera"] = False
    later = {**loaded.file.rollouts.later, **spec.get("later", {})}
    robot = in_scene(loaded.subject.robot, one._replace(spec=json.dumps(spec)))
    agent = TryingAgent(loaded, option, parameters, later)
    config = RunConfig(
        loaded.subject.mission, robot, loaded.subject.arguments, answerers={**agent.later, "agent": agent}
    )
    with prepare(config) as prepared:
        agent.prepared = prepared
        result = prepared.runner.run()
        world: Any = prepared.environment.world
        return agent, (result, world.measures(), world.at)


def as_it_happens(name: str, scene: str, option: str) -> Rollout:
    """The rollout of an option that ends the mission, which is as the run that takes it."""
    agent, (result, measures, at) = played(name, scene, option)
    assert agent.found is not None
    assert (agent.found.outcome, agent.found.why, agent.found.ending) == (result.outcome, result.why, "mission")
    assert agent.found.seconds == pytest.approx(at - agent.began_s, abs=1e-6)
    if name == "house":
        assert agent.found.measures == measures
    else:  # the run plans by a look that came in the period of the question, the rollout by the one before
        assert agent.found.measures["moved_m"] == pytest.approx(measures["moved_m"], abs=0.005)
        assert agent.found.measures["fallen"] == measures["fallen"]
    return agent.found


def test_a_proposed_goal_comes_out_at_the_desk_as_in_the_run() -> None:
    found = as_it_happens("desk", "two_cubes_1", "propose")
    assert found.verdict == "completes" and found.work == 0.5
    assert found.measures["moved_m"]["red_cube"] > 0.05 and 5 < found.measures["grip_n"] < 140


def test_giving_up_before_a_blocked_door_comes_out_in_the_house_as_in_the_run() -> None:
    found = as_it_happens("house", "crate_stays", "abort")
    assert (found.verdict, found.outcome, found.measures["struck_n"]) == ("harmless", "aborted", 0.0)


@pytest.mark.drill
def test_waiting_before_a_door_that_opens_completes_the_patrol() -> None:
    found = as_it_happens("house", "crate_leaves", "wait")
    assert (found.verdict, found.seconds > 20, "pantry" in found.measures["rooms"]) == ("completes", True, True)


@pytest.mark.drill
@pytest.mark.parametrize(("name", "scene", "option"), [
    ("desk", "slippery_5", "propose"), ("desk", "clutter_3", "ask"), ("desk", "out_of_reach_7", "propose"),
    ("house", "crate_stays", "skip"), ("house", "closes_again", "retry"), ("house", "heeds", "ask"),
])  # fmt: skip
def test_every_option_comes_out_indoors_as_in_the_run(name: str, scene: str, option: str) -> None:
    as_it_happens(name, scene, option)


def test_parameters_that_the_mission_refuses_cannot_be_tried() -> None:
    agent, _ = played("desk", "two_cubes_1", "propose", {"goal": "nonsense"})
    assert agent.fault.startswith("'propose' cannot be tried in 'asking_model': the parameters of 'propose' are not")

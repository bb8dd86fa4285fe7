# SPDX-License-Identifier: Apache-2.0
"""From a scene to its question: the mission itself is run in the scene's world, up to where its decision asks.

Rule: nothing of a question is made here. The chart that asks is the mission's own, brought there by the run's events.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from rai_missions.agents.launch import prepare
from rai_missions.agents.run_config import RunConfig
from rai_missions.campaign.records import SceneRecord
from rai_missions.campaign.rollout import Branchable, OpenDecision
from rai_missions.check import load_whole
from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, Fault, MissionError, UsageError, pointer
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, identity_folder, load_profile, robot_facts
from rai_missions.runtime.runner import Runner
from rai_missions.states.decision import DecisionSpec

__all__ = ("AskedScene", "CampaignSubject", "NoQuestion", "ask_in", "in_scene")

T = TypeVar("T")

LONGEST_S = 900.0
"""Simulated seconds until a scene's decision must have asked."""


class NoQuestion(MissionError):
    """The mission asked nothing in a scene; the text states how its run ended."""


class CampaignSubject(NamedTuple):
    """The mission of a campaign, and the robot that it is asked about."""

    mission: Mission
    robot: Robot
    identity: Path | None
    """The folder of the robot's identity."""
    decision: str
    """The state that asks."""
    arguments: Mapping[str, Any]

    @classmethod
    def read(
        cls, mission: Path, robot: Path, decision: str, arguments: Mapping[str, Any], *, source: str = ""
    ) -> CampaignSubject:
        """From the files of mission and profile.

        Args:
            mission: The mission's file.
            robot: The profile's file.
            decision: The state that asks.
            arguments: The arguments of the mission.
            source: The campaign's file, which names them.

        Raises:
            DefinitionError: They are at fault, are not there, or are programs, which a campaign's file runs none of;
                every fault of both.
        """
        found = list[Fault]()
        whole = _read_named("mission", partial(load_whole, python=False), mission, found)
        profile = _read_named("robot", load_profile, robot, found)
        if whole is None or profile is None:
            raise DefinitionError(found, source)
        return cls(whole, profile, identity_folder(profile, robot), decision, arguments)

    @property
    def spec(self) -> DecisionSpec | None:
        """The question of the decision; None where the state is no decision."""
        state = next((state for _, name, state in self.mission.walk() if name == self.decision), None)
        return state.question() if state is not None else None

    @property
    def asked(self) -> tuple[str, ...]:
        """Whom the decision asks, in order; empty where the state is no decision."""
        return self.spec.ask if self.spec is not None else ()

    @property
    def options(self) -> tuple[str, ...]:
        """The options of the decision, offered or not."""
        return tuple(self.spec.options) if self.spec is not None else ()

    @property
    def text(self) -> str:
        """What is asked, in a sentence."""
        return self.spec.question if self.spec is not None else ""


def _read_named(word: str, read: Callable[[Path], T], path: Path, found: list[Fault]) -> T | None:
    """What is in a file that a campaign names; None where it is at fault, and the faults are added to those found."""
    try:
        return read(path)
    except DefinitionError as error:
        found += (each._replace(file=each.file or error.source) for each in error.faults)
    except UsageError as error:
        found.append(Fault(pointer((word,)), str(error)))
    return None


class AskedScene(NamedTuple):
    """A scene in which the decision asks."""

    scene: SceneRecord
    chart: Chart
    """Where the run was when the question was asked; branch it, and answer the branch."""
    question: Question
    decision: OpenDecision | None = None
    """The question with a branch of the world, from which options can be rolled out; None where the world has none."""

    @property
    def facts(self) -> dict[str, Any]:
        """What the question shows: key → value, age in seconds, whether it is fresh; of a picture its reference."""
        return {
            each.key: {
                "value": each.value.ref if isinstance(each.value, Image) else each.value,
                "age_s": each.age_s,
                "fresh": each.fresh,
            }
            for each in self.question.evidence
        }

    @property
    def pictures(self) -> dict[str, Image]:
        """The pictures that the question shows, by key."""
        return {each.key: each.value for each in self.question.evidence if isinstance(each.value, Image)}


def in_scene(robot: Robot, scene: SceneRecord) -> Robot:
    """The profile with the scene's world instead of its own, and without the rules, which would answer first."""
    spec = json.loads(scene.spec)
    connector = {"seed": scene.seed, **spec.get("options", {}), "kind": "local", "world": spec["world"]}
    return Robot.model_validate({**robot.written(), "connector": connector, "rules": {}})


def ask_in(scene: SceneRecord, subject: CampaignSubject, *, longest_s: float = LONGEST_S) -> AskedScene:
    """Run the mission in a scene until its decision asks.

    Args:
        scene: Which world to build.
        subject: The mission, and the robot's profile.
        longest_s: Simulated seconds after which the run is given up.

    Raises:
        NoQuestion: The run ended, or the time is over, before the decision asked.
        UsageError: The world cannot be built as the scene has it.
    """
    robot = in_scene(subject.robot, scene)
    chart = Chart(subject.mission, robot_facts=robot_facts(robot))
    seeker = QuestionSeeker(chart, subject.decision, longest_s)
    waiting = WaitingAnswerer()
    config = RunConfig(
        subject.mission,
        robot,
        subject.arguments,
        answerers=dict.fromkeys(subject.asked, waiting),
        on_step=seeker.follow,
    )
    with prepare(config) as prepared:
        seeker.runner = prepared.runner
        seeker.world = prepared.world if isinstance(prepared.world, Branchable) else None
        result = prepared.runner.run()
    if seeker.fault is not None:
        raise seeker.fault
    if seeker.question is None:
        raise NoQuestion(f"'{subject.decision}' asked nothing: the run ended {result.outcome}, {result.why}")
    decision = None
    if seeker.branch is not None:
        decision = OpenDecision(seeker.branch, chart, robot, prepared.runner.run_id, subject.decision)
    return AskedScene(scene, chart, seeker.question, decision)


class QuestionSeeker:
    """Follows a run with a chart of its own until a state asks, and ends the run there.

    Args:
        chart: A new chart of the run's mission; it is where the run is.
        decision: The state.
        longest_s: Simulated seconds after which the run is ended in any case.
    """

    def __init__(self, chart: Chart, decision: str, longest_s: float) -> None:
        self.runner: Runner | None = None
        self.world: Branchable | None = None
        self.branch: Branchable | None = None
        """The world as it was at the question."""
        self.question: Question | None = None
        self.fault: Exception | None = None
        self._chart, self._decision, self._longest_s = chart, decision, longest_s

    def follow(self, step: Step) -> None:
        """Do a step of the run again; an observer of the run."""
        if not self.is_over:
            try:
                self._repeat(step.event)
            except Exception as fault:  # noqa: BLE001 - the run would log it and continue; it is raised at its end
                self.fault = fault
        if self.runner is not None and (self.is_over or step.at > self._longest_s):
            self.runner.kill("campaign")
            self.runner = None  # the step of the e-stop is followed, too

    @property
    def is_over(self) -> bool:
        """Whether the state has asked, or the run cannot be followed."""
        return self.question is not None or self.fault is not None

    def _repeat(self, event: Event) -> None:
        if event.kind == "command" and event.name == "start":
            self._chart.start(event.at)
        else:
            self._chart.send(event)
        found = next((each for each in self._chart.questions if each.state == self._decision), None)
        for each in found.evidence if found is not None else ():
            if isinstance(each.value, Image):
                _ = each.value.data  # rendered while the world is there
        if found is not None and self.world is not None:
            self.branch = self.world.branch()
        self.question = found


class WaitingAnswerer:
    """Answers nothing: the run is ended where it is asked."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Keep the question open."""

    def withdraw(self, number: int) -> None:
        """Nothing is under way."""

# SPDX-License-Identifier: Apache-2.0
"""An answer waits for the end of a pause or of a hold, and its process is killed: the next one reports its judgment."""

from __future__ import annotations

import random
import shutil
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.agents.talk.orders import CLOSED
from rai_missions.conversation.language.language import language
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal import Journal, opened
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.resume import resumption
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.requests import OVER
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.agents.talk.scenes import HeldOpen, settle
from tests.laws.drawn import EVENTS
from tests.laws.test_side_by_side import NAMED, Surroundings, Thinker
from tests.laws.test_talk_handover import SETTINGS, Held
from tests.rigs.journals import assert_whole, cut_after_each
from tests.rigs.turns import Turns, sooner_ended

CANCELED_S, KILLED_S, OVER_S = 20.0, 30.0, 60.0
NOT_DONE, UNJUDGED = "The order 'answer '", "without a judgment"
"""How the report of a refusal begins, and the reason where the run did not judge."""


class Resumed:
    """A run that was killed while it kept answers, in a process of its own with a conversation about it.

    Args:
        seed: Of what happens now.
        path: Its journal.
        mission: Its mission, as it is now.
        robot: Its robot.
    """

    def __init__(self, seed: int, path: Path, mission: Mission, robot: Robot) -> None:
        self.lines: list[TalkLine] = []
        self.steps: list[Step] = []
        self.turns = turns = Turns()
        with opened(path) as record:
            resumed = resumption(record, mission, named=NAMED)
            journal = Journal.open(path, seal=record.seal)
        self.waiting = [each for each in resumed.chart.waiting_answers if each.name == "operator"]
        turns.at = began = resumed.at + 1.0
        land = Surroundings(turns, seed)

        def make(clock: Clock) -> Callable[[], object]:
            self.runner = Runner(
                mission,
                robot=robot,
                connector=land.connector,
                clock=clock,
                journal=journal,
                answerers={"operator": HeldOpen(), "rules": Thinker(turns, "rules"), "agent": Thinker(turns, "agent")},
                begin=resumed,
                observer=RunObserver(self._step, self._changed),
            )
            return self.runner.run

        turns.begin(make)
        self.agent = ConversationalAgent(SETTINGS, doors=[TextDoor("terminal", self.lines.append)], now=turns.now)
        self.agent.attach(self.runner)
        self.agent.run()
        turns.settle = partial(settle, self.agent)
        self._schedule(random.Random(seed), began)
        turns.play(began + OVER_S)
        self.agent.conclude(5.0)
        self.agent.stop()
        journal.close()

    def _step(self, step: Step) -> None:
        self.steps.append(step)
        self.agent.step(step)

    def _changed(self, status: Any) -> None:
        self.agent.changed(status)

    def _schedule(self, rng: random.Random, at: float) -> None:
        turns, runner = self.turns, self.runner
        ways: list[Callable[[], object]] = [runner.resume, lambda: runner.control("agent", by="operator Eve")]
        for number in range(1, rng.randint(4, 10)):
            way = rng.choice(
                [*ways, lambda: runner.post(Event(rng.choice(EVENTS), turns.at, {"k": rng.randint(0, 2)}))]
            )
            turns.call_at(at + number * rng.choice([0.3, 0.7]), way)
        turns.call_at(at + CANCELED_S, lambda: runner.cancel())
        turns.call_at(at + KILLED_S, lambda: runner.kill())

    def judgment(self, number: int) -> str:
        """Why an answer was refused, at least how that begins; empty where it counted."""
        found = [(step, each) for step in self.steps for each in step.verdicts if each.number == number]
        for step, verdict in found:
            if verdict.kind != "fallback":
                return "" if verdict.accepted else step.notes[verdict.note or 0]
        return UNJUDGED

    def reports(self) -> list[str]:
        """What was shown of answers that were refused, each once."""
        return list({line.number: line.text for line in self.lines if NOT_DONE in line.text}.values())


def keeps_answer(step: Step) -> bool:
    """Whether an answer waits from this step on."""
    return step.kept and step.event.kind == "proposal" and step.outcome is None


def is_why(why: str, text: str) -> bool:
    """Whether a report gives this reason; one that each language has a text for is in the report's."""
    if why.startswith("stale:"):
        return language("en").data["texts"]["refused_stale"] in text
    return any(each in text for each in (CLOSED, OVER)) if why == UNJUDGED else why.rstrip(".")[:100] in text


@sooner_ended()
def agree(seed: int, folder: Path) -> Counter[str]:
    """Kill a run while it keeps answers, and resume it, in another mission too; gives what became of them."""
    found = Counter[str]()
    before = Held(seed, folder / "talked.journal")
    for step, cut in cut_after_each(folder / "talked.journal", keeps_answer):
        path, mission = folder / f"resumed-{step.seq}.journal", before.mission
        if (seed + step.seq) % 2:
            shutil.copy(cut, path)
        else:
            mission = Mission.model_validate({**mission.written(), "version": "2.0.0"})
            migrate(cut, mission, Map(), to=path, robot=before.robot, named=NAMED)
        resumed = Resumed(seed + step.seq, path, mission, before.robot)
        assert_whole(path)
        refused = [why for each in resumed.waiting if (why := resumed.judgment(each.number))]
        reports = resumed.reports()
        assert len(reports) == len(refused), (seed, step.seq, refused, reports)
        assert all(any(is_why(why, text) for text in reports) for why in refused), (seed, refused, reports)
        found["refused"] += len(refused)
        found["counted"] += len(resumed.waiting) - len(refused)
    return found


@pytest.mark.parametrize("seed", [2, 6, 9, 42])
def test_the_judgment_of_an_answer_is_reported_by_the_process_that_judges_it(seed: int, tmp_path: Path) -> None:
    assert agree(seed, tmp_path).total()


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_the_judgments_of_many_answers_are_reported_by_the_process_that_judges_them(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(1_000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found += agree(seed, folder)
    assert min(found["refused"], found["counted"]) > 20, found

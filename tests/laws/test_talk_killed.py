# SPDX-License-Identifier: Apache-2.0
"""A process is killed while a list of orders is read back: in the next one no yes counts before it is read back again.

Each order of a list is reported once, as it was, and the end of the run once in the process that continues.
"""

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
from rai_missions.engine.step import Step
from rai_missions.journal import Journal, opened
from rai_missions.replay.resume import resumption
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.agents.talk.scenes import HeldOpen, settle
from tests.laws import test_talk_handover
from tests.laws.test_side_by_side import NAMED, Surroundings, Thinker
from tests.laws.test_talk_handover import SENTENCES, SETTINGS, Held, is_true
from tests.rigs.journals import assert_whole, cut_after_each
from tests.rigs.turns import Turns, sooner_ended

LISTS = (
    "pause and then resume", "pause, then cancel the mission", "resume and then pause", "resume, then answer left",
    "left and then pause", "pause, then start drawn", "cancel the mission and then start drawn",
    "pause, then resume, then cancel the mission", "pause. what are you doing?",
)  # fmt: skip
MOST_CUTS, CANCELED_S, OVER_S = 3, 20.0, 40.0
AUTHOR = "Berta"


class Continued:
    """A run that was killed, in a process of its own, in which a person only agrees."""

    def __init__(self, seed: int, path: Path, before: Held) -> None:
        self.lines = dict[int, TalkLine]()
        self.steps: list[Step] = []
        self.turns = turns = Turns()
        with opened(path) as record:
            resumed = resumption(record, before.mission, named=NAMED)
            journal = Journal.open(path, seal=record.seal)
        turns.at = began = resumed.at + 1.0
        land = Surroundings(turns, seed)

        def make(clock: Clock) -> Callable[[], object]:
            self.runner = Runner(
                before.mission,
                robot=before.robot,
                connector=land.connector,
                clock=clock,
                journal=journal,
                answerers={"operator": HeldOpen(), "rules": Thinker(turns, "rules"), "agent": Thinker(turns, "agent")},
                begin=resumed,
                observer=RunObserver(self._step, self._changed),
            )
            return self.runner.run

        turns.begin(make)
        self.agent = ConversationalAgent(SETTINGS, doors=[TextDoor("terminal", self._show)], now=turns.now)
        self.agent.attach(self.runner)
        self.agent.run()
        turns.settle = partial(settle, self.agent)
        rng = random.Random(seed)
        for number in range(1, 5):
            turns.call_at(began + number * rng.choice([0.1, 0.7, 2.0]), self._agree)
        turns.call_at(began + CANCELED_S, lambda: self.runner.cancel())
        turns.call_at(began + CANCELED_S + 5.0, lambda: self.runner.kill())
        turns.play(began + OVER_S)
        self.agent.conclude(5.0)
        self.agent.stop()
        journal.close()

    def _agree(self) -> None:
        assert not self.agent.receive("yes", role="operator", channel="terminal", author=AUTHOR)
        self.agent.wait_answered(20.0)

    def _step(self, step: Step) -> None:
        self.steps.append(step)
        self.agent.step(step)

    def _changed(self, status: Any) -> None:
        self.agent.changed(status)

    def _show(self, line: TalkLine) -> None:
        self.lines[line.number] = line

    def ordered(self) -> list[Step]:
        """The steps that came of what the person uttered."""
        return [step for step in self.steps if AUTHOR in str(step.event.data.get("by", ""))]

    def ends(self) -> list[str]:
        """The reports of the run's end."""
        return [line.text for line in self.lines.values() if line.report.endswith(":end")]


@sooner_ended()
def agree(seed: int, folder: Path) -> Counter[str]:
    """Kill a run that is talked with, and continue it; gives how often, and what was open."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(test_talk_handover, "SENTENCES", (*SENTENCES, *LISTS, *LISTS))
        before = Held(seed, folder / "talked.journal")
    assert all(len(each.ends) == 1 and is_true(each) for each in before.given), seed
    found, rng = Counter[str](), random.Random(seed)
    alive = [step.seq for step in before.steps if step.outcome is None]
    chosen = set(rng.sample(alive, min(len(alive), MOST_CUTS)))
    for step, cut in cut_after_each(folder / "talked.journal", lambda step: step.seq in chosen):
        path = folder / f"continued-{step.seq}.journal"
        shutil.copy(cut, path)
        continued = Continued(seed + step.seq, path, before)
        assert_whole(path)
        assert not continued.ordered(), (seed, step.seq)
        assert len(continued.ends()) == 1, (seed, step.seq, continued.ends())
        found["killed"] += 1
    found["ordered"] += len(before.given)
    found["read back"] += sum("Is that right?" in line.text for line in before.lines)
    return found


@pytest.mark.parametrize("seed", [3, 6, 9])
def test_no_yes_counts_in_the_process_that_continues_and_the_end_is_reported_once(seed: int, tmp_path: Path) -> None:
    assert agree(seed, tmp_path)["killed"]


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_no_yes_counts_in_many_processes_that_continue(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(500):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found += agree(seed, folder)
    assert found["killed"] > 1_000 and found["read back"] > 200, found

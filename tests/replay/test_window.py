# SPDX-License-Identifier: Apache-2.0
"""While a run waits to receive the robot's facts again, things happen: each counts at its own instant.

The oracle is the same run without a death, whose process was held up as long at the same row: both find the same
waiting for them, and must make the same of it.
"""

from __future__ import annotations

import itertools
import json
import logging
import random
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine.step import Ask, Step
from rai_missions.journal import StepRow, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.open_run import OpenedRun
from rai_missions.runtime.runner import Runner
from tests.replay.coroner import LatchingConnector
from tests.replay.mortal import ONLOOKER, Coroner, Fate, live
from tests.replay.test_generated import trials
from tests.replay.test_kills import has_ended, holds
from tests.replay.trial import ROBOT, Yard
from tests.strategies import missions

Json = dict[str, Any]
WINDOW_S = 5.0
LONG_S = 1000.0
"""For every deadline of something that is asked for: a process that is held up comes too late for short ones."""
DEADLINES = frozenset({"timeout_s", "handover_s", "deadline_s", "within_s", "cancel_s", "timeout"})
WITNESS: Json = {"type": "boolean", "source": "robot", "optional": True, "max_age_s": WINDOW_S}
REPORTING = ROBOT.model_copy(
    update={
        "blackboard": {
            **ROBOT.blackboard,
            "witness": Robot.model_validate(
                {"name": "witness", "blackboard": {"witness": {"topic": "/witness", "type": "std_msgs/msg/Bool"}}}
            ).blackboard["witness"],
        }
    }
)
"""Reports one fact more, which nothing in a mission asks for: a run that is resumed waits for it."""


def unhurried(mission: Mission) -> Mission:
    """The same mission with time enough for everything that is asked for, and a fact that nothing in it asks for."""

    def slow(given: Any) -> Any:
        if isinstance(given, list):
            return [slow(each) for each in given]
        if not isinstance(given, dict):
            return given
        given = {word: LONG_S if word in DEADLINES else slow(each) for word, each in given.items()}
        given |= {"handover_s": LONG_S} if isinstance(given.get("control"), str) else {}
        given |= {"cancel_s": LONG_S} if isinstance(given.get("action"), str) else {}
        return given | ({"settle_s": LONG_S} if "achieved" in given else {})

    document = json.loads(dump(mission))
    document["blackboard"]["witness"], document["settle_s"], document["cancel_s"] = WITNESS, LONG_S, LONG_S
    return Mission.model_validate({**slow(document), "blackboard": document["blackboard"]})


class Meadow(Yard):
    """A yard that holds a process up, as a slow disk does, once it has carried out the step of a row.

    Args:
        mission: The mission of the run.
        seed: Of what is wanted, and how long goals take and how they end.
        slow_at: After which row of a step, from 1; 0 for none.
    """

    def __init__(self, mission: Mission, seed: int, slow_at: int = 0) -> None:
        self.reports_witness, self.slow_at, self.rows = True, slow_at, 0
        super().__init__(mission, seed, keeps_time=True, connector_type=Forgetful)

    def live_on(self) -> None:
        super().live_on()
        if self.reports_witness:
            self.connector.publish("/witness", "std_msgs/msg/Bool", {"data": True})

    def be_silent(self) -> None:
        """Report nothing more of that one fact, also not to a process that begins to listen."""
        self.reports_witness = False
        assert isinstance(self.connector, Forgetful)
        self.connector.forget("/witness")

    def look(self, step: Step) -> None:
        super().look(step)
        if self.slow_at and self.rows >= self.slow_at:
            self.slow_at = 0
            for _ in range(int(WINDOW_S / self.period_s)):
                self.step()


class Forgetful(LatchingConnector):
    """Does not report everything that was reported last."""

    def forget(self, topic: str) -> None:
        self._last.pop(topic, None)


class Counting(Coroner):
    """Counts the rows of steps; what was asked for and is in the journal is not asked for again.

    Args:
        yard: Where the run is.
    """

    def __init__(self, yard: Meadow) -> None:
        self._yard = yard

    def wrote(self, runner: Runner) -> None:
        self._yard.rows += 1

    def found(self, taken: OpenedRun) -> None:
        self._yard.reported |= {step.event.data.get("id", -1) for step in taken.record.steps()}


class Course(NamedTuple):
    """What became of a run."""

    outcome: str | None
    why: str
    entered: tuple[tuple[float, tuple[str, ...]], ...]
    """Instant and states, for each step behind the row that entered any."""


def course(path: Path, row: int) -> Course:
    with read(path) as record:
        steps = [each.step for each in record.rows() if isinstance(each, StepRow)]
    entered = tuple((round(step.at, 6), step.entered) for step in steps[row:] if step.entered)
    last = next(step for step in steps if step.outcome is not None)
    return Course(last.outcome, last.why, entered)


def ran(path: Path, yard: Meadow, mission: Mission, fate: Fate) -> bool:
    """Whether a run came to its end in this process."""
    return live(path, yard, mission, REPORTING, {}, fate, coroner=Counting(yard)) is not None


def rows_at_rest(path: Path) -> list[int]:
    """The rows of steps behind which nothing waits: no answer, and no event at the same instant."""
    with read(path) as record:
        steps = [each.step for each in record.rows() if isinstance(each, StepRow)]
    return [
        number
        for number, (step, then) in enumerate(itertools.pairwise(steps), 1)
        if 1 <= step.at < then.at and step.outcome is None and not any(isinstance(each, Ask) for each in step.effects)
    ]


def tried(folder: Path, mission: Mission, seed: int) -> str:
    """Hold a run up, and kill another at the same row; reports whether they were compared, or why not."""
    mission = unhurried(mission)
    whole, path = Meadow(mission, seed), folder / "whole.journal"
    assert ran(path, whole, mission, Fate())
    if not (rows := rows_at_rest(path)):
        return "no row"
    row = random.Random(seed).choice(rows)

    slow, slow_path = Meadow(mission, seed, slow_at=row), folder / "slow.journal"
    assert ran(slow_path, slow, mission, Fate())

    killed, path = Meadow(mission, seed), folder / "killed.journal"
    assert not ran(path, killed, mission, Fate(row - 1, is_done=True, what="write"))
    if has_ended(path, mission):
        return "ended"
    killed.be_silent()
    assert ran(path, killed, mission, Fate())
    holds(path, killed, mission)
    with read(path) as record:
        if any(step.event.kind == "doubt" for step in record.steps()):
            return "an effect was in doubt"
    if (expected := course(slow_path, row)).why == f"e-stop by {ONLOOKER}":
        return "it never rests"
    assert course(path, row) == expected, f"killed after row {row} of a step"
    return "same"


@settings(deadline=None, max_examples=10)
@given(missions(), st.integers(0, 10_000))
def test_what_happens_while_the_facts_are_received_again_counts_at_its_own_instant(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, seed: int
) -> None:
    tried(tmp_path_factory.mktemp("window"), mission, seed)


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_whatever_happens_while_the_facts_are_received_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logging.disable(logging.CRITICAL)
    compared = Counter[str]()
    try:
        for seed, mission in trials():
            folder = tmp_path / str(seed)
            folder.mkdir()
            compared[tried(folder, mission, seed)] += 1
            if compared["same"] >= 1000:
                break
    finally:
        logging.disable(logging.NOTSET)
    with capsys.disabled():
        print(f"\n{dict(compared)}")  # noqa: T201 - the figure

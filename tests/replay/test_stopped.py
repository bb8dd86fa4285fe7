# SPDX-License-Identifier: Apache-2.0
"""What an e-stop held back is not begun by a process that takes the run up afterwards."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, StepRow, copied, read
from rai_missions.mission.files import dump
from rai_missions.profile import dump_profile
from rai_missions.replay.open_run import open_run
from tests.rigs.runs import KEYS, ROBOT, Rig, mission, robot

PATIENCE_S = 30.0
LIT = mission({
    "idle": {"transitions": [{"on": "go", "to": "moving", "do": [
        {"publish": "lamp", "message": {"data": True}}, {"call": "horn"}, {"say": "I go"}]}]},
    "moving": {"action": "move", "timeout_s": 100},
})  # fmt: skip
PROFILE = robot(
    **{
        sort: {name: {**entry, "repeat": True} for name, entry in ROBOT[sort].items()}
        for sort in ("services", "topics")
    }
)


class Held(Journal):
    """A journal whose disk hangs over the step in which everything begins."""

    hangs: threading.Event
    answers: threading.Event

    def write(self, step: Step, **words: Any) -> int:
        if step.event.name == "go":
            self.hangs.set()
            assert self.answers.wait(PATIENCE_S)
        return super().write(step, **words)


class Performed(Rig):
    """A run, and what it published and called."""

    def __init__(self, *given: Any, **words: Any) -> None:
        super().__init__(LIT, *given, robot=PROFILE, **words)
        self.lamps: list[object] = []
        self.connector.subscribe("/lamp", "std_msgs/msg/Bool", lambda received: self.lamps.append(received.data))

    @property
    def done(self) -> list[object]:
        return [*self.lamps, *self.called, *self.move.goals]


@pytest.fixture
def stopped(tmp_path: Path) -> Path:
    """The journal of a run that was stopped while a step waited for the disk."""
    path = tmp_path / "run.journal"
    with Held.create(path, Header(dump(LIT), dump_profile(PROFILE))) as journal:
        journal.hangs, journal.answers = threading.Event(), threading.Event()
        rig = Performed(journal=journal)
        rig.stage.play({1.0: lambda: rig.post("go")})
        runs = threading.Thread(target=rig.run)
        runs.start()
        assert journal.hangs.wait(PATIENCE_S)
        rig.runner.kill()
        journal.answers.set()
        runs.join(PATIENCE_S)
    assert rig.done == []
    return path


def test_a_stopped_run_has_ended(stopped: Path) -> None:
    with pytest.raises(UsageError, match="has ended, aborted: e-stop by operator"):
        open_run(stopped)


def died(stopped: Path, after: str) -> Path:
    """The journal of a process that died once this event was written."""
    path = stopped.with_name("died.journal")
    with read(stopped) as record:
        rows = list(record.raw())
        last = next(row.row for row in record.rows() if isinstance(row, StepRow) and row.step.event.name == after)
    copied(path, rows[: last + 1], "the run")
    return path


def test_anyone_who_resumes_a_run_that_died_with_its_stop_written_begins_nothing(stopped: Path) -> None:
    path = died(stopped, "kill")
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Performed(journal=journal, begin=taken.resumption)
        assert rig.run().outcome == "aborted"
    taken.record.close()
    assert rig.done == []


def test_a_run_that_is_stopped_before_it_continues_begins_nothing_again(stopped: Path) -> None:
    path = died(stopped, "go")
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Performed(journal=journal, begin=taken.resumption)
        rig.runner.kill()
        result = rig.run()
    taken.record.close()
    assert (result.outcome, result.why) == ("aborted", "e-stop by operator")
    assert rig.done == []


SEEING = mission(
    {"driving": {"action": "drive", "timeout_s": 100}},
    blackboard={**KEYS, "battery": {"type": "number", "source": "robot", "max_age_s": 50}},
)


@pytest.mark.parametrize("command", ["stop", "cancel"])
def test_a_goal_ends_at_once_although_the_run_still_waits_for_the_robots_facts(tmp_path: Path, command: str) -> None:
    path, chart = tmp_path / "run.journal", Chart(SEEING)
    with Journal.create(path, Header(dump(SEEING), dump_profile(robot()))) as journal:
        for step in (chart.write("battery", 0.9, 0.1), chart.start(0.2)):
            journal.write(step, since=0.0)
        journal.write(chart.send(Event("accepted", 0.3, {}, "accepted", 1)), since=0.2)
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Rig(SEEING, journal=journal, begin=taken.resumption)
        began = rig.clock.now()
        rig.stage.play({1.0: getattr(rig.runner, command), 40.0: rig.runner.kill})
        rig.run()
    taken.record.close()
    halted = [at - began for at, service in rig.called if service == "/halt"]
    assert halted and halted[0] <= 1.0 + rig.stage.period_s, (halted, rig.called)

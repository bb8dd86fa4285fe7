# SPDX-License-Identifier: Apache-2.0
"""What was stopped is not begun by a process that resumes the run; what is stopped while it resumes ends at once."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, StepRow, copied, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
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


SEEING_KEYS = {**KEYS, "battery": {"type": "number", "source": "robot", "max_age_s": 50}}
DRIVING: dict[str, Any] = {"action": "drive", "timeout_s": 100}
SEEING = mission({"driving": DRIVING}, blackboard=SEEING_KEYS)
HOMING = mission({"idle": {}, "homing": DRIVING}, blackboard=SEEING_KEYS, on_cancel="homing", cancel_s=60)


def resumed(path: Path, given: Mission, before: tuple[Event, ...], moments: dict[float, str]) -> tuple[Rig, float]:
    """A run whose process died with a goal under way, resumed at a robot that reports nothing.

    Args:
        path: Its journal.
        given: Its mission.
        before: What had happened to it since its start.
        moments: When, counted from the resume → what is ordered then.

    Returns:
        What came of it, and when on its clock it was resumed.
    """
    chart = Chart(given)
    with Journal.create(path, Header(dump(given), dump_profile(robot()))) as journal:
        for step in (chart.write("battery", 0.9, 0.1), chart.start(0.2)):
            journal.write(step, since=0.0)
        for event in (*before, Event("accepted", 0.4, {}, "accepted", 1)):
            journal.write(chart.send(event), since=0.2)
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Rig(given, journal=journal, begin=taken.resumption)
        began = rig.clock.now()
        rig.stage.play({at: getattr(rig.runner, name) for at, name in moments.items()})
        rig.run()
    taken.record.close()
    return rig, began


@pytest.mark.parametrize("command", ["stop", "cancel"])
def test_a_goal_ends_at_once_although_the_run_still_waits_for_the_robots_facts(tmp_path: Path, command: str) -> None:
    rig, began = resumed(tmp_path / "run.journal", SEEING, (), {1.0: command, 40.0: "kill"})
    halted = [at - began for at, service in rig.called if service == "/halt"]
    assert halted and halted[0] <= 1.0 + rig.stage.period_s, (halted, rig.called)


@settings(deadline=None, max_examples=20)
@drawn(tenths=st.integers(2, 90), is_stopped=st.booleans())
def test_a_cancel_waits_for_none_of_the_robots_facts(
    tmp_path_factory: pytest.TempPathFactory, tenths: int, is_stopped: bool
) -> None:
    at = tenths / 10
    moments = {at: "cancel", 40.0: "kill"} | ({at / 2: "stop"} if is_stopped else {})
    rig, began = resumed(tmp_path_factory.mktemp("canceled") / "run.journal", SEEING, (), moments)
    assert (rig.steps[-1].outcome, rig.steps[-1].why) == ("canceled", "canceled by operator")
    assert rig.clock.now() - began <= at + 2 * rig.stage.period_s


def test_a_second_cancel_and_a_stop_leave_what_the_first_one_began(tmp_path: Path) -> None:
    first = Event("cancel", 0.3, {}, "command")
    rig, _ = resumed(tmp_path / "run.journal", HOMING, (first,), {1.0: "cancel", 2.0: "stop", 12.0: "kill"})
    assert [at for at, service in rig.called if service == "/halt" and at < 12.0] == [], "while facts are awaited"

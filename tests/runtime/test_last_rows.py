# SPDX-License-Identifier: Apache-2.0
"""What ends a run, or takes a chance from it, is in its journal, however quietly it came."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import UsageError
from rai_missions.journal import Header, Journal, read
from rai_missions.journal.rows import Confirmation, JournalRow, StepRow
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.open_run import open_run
from rai_missions.replay.replay import replay
from tests.rigs.journals import rows_of
from tests.rigs.runs import Rig, mission, robot

Moments = Mapping[float, Callable[[], object]]


def journaled(path: Path, given: Mission, moments: Callable[[Rig], Moments]) -> Rig:
    rig = Rig(given, journal=Journal.create(path, Header(dump(given), dump_profile(robot()))))
    rig.stage.play(moments(rig))
    return rig


def agrees(path: Path, rig: Rig) -> None:
    result = rig.run()
    rig.book.close()
    with read(path) as record:
        last = record.last()
    assert last is not None
    assert (last.step.outcome, last.step.why) == (result.outcome, result.why)
    again = replay(path)
    assert (again.difference, again.outcome, again.why) == ("", result.outcome, result.why)
    with pytest.raises(UsageError, match="has ended"):
        open_run(path)


REQUIRING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "to": "done"}]},
    "done": {"final": "succeeded", "requires": {"key": "there", "==": True}},
}


def test_a_success_that_a_later_fact_brings_is_written_down(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    there = lambda rig: {1.0: lambda: rig.post("go"), 2.0: lambda: rig.publish("/there", data=True)}  # noqa: E731
    agrees(path, journaled(path, mission(REQUIRING, settle_s=5), there))


def test_a_final_that_never_settles_is_written_down(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    agrees(path, journaled(path, mission(REQUIRING, settle_s=2), lambda rig: {1.0: lambda: rig.post("go")}))


def test_a_chance_that_passed_at_its_time_does_not_come_back(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    states = {
        "waiting": {"transitions": [{"after_s": 2, "when": {"key": "there", "==": True}, "to": "taken"},
                                    {"on": "go", "to": "left"}]},
        "taken": {"final": "failed"},
        "left": {"final": "canceled"},
    }  # fmt: skip
    given = mission(states)
    rig = journaled(
        path, given, lambda rig: {2.2: lambda: rig.publish("/there", data=True), 2.4: lambda: rig.post("go")}
    )
    agrees(path, rig)
    with read(path) as record:
        assert [name for step in record.steps() for name in step.entered] == ["waiting", "left"]


CALLING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "do": [{"call": "horn"}]}, {"on": "stop_now", "to": "over"}]},
    "over": {"final": "aborted"},
}


class SilentRig(Rig):
    """Its horn does not answer, and has the run look again at what it waits for."""

    def _answer(self, service: str) -> Any:
        self.runner.call_soon(lambda: None)
        return Future()


def test_a_run_that_waits_has_confirmed_what_it_did(tmp_path: Path) -> None:
    """What waited in its mailbox as it did so was no event."""
    path, given = tmp_path / "run.journal", mission(CALLING)
    rig = SilentRig(given, journal=Journal.create(path, Header(dump(given), dump_profile(robot()))))
    found: list[JournalRow] = []
    moments = {
        1.0: lambda: rig.post("go"),
        2.0: lambda: found.extend(rows_of(path)),
        3.0: lambda: rig.post("stop_now"),
    }
    rig.stage.play(moments)
    agrees(path, rig)
    (step,) = [row.step for row in found if isinstance(row, StepRow) and row.step.effects]
    assert [row.number for row in found if isinstance(row, Confirmation)] == [step.seq]


def test_each_confirmation_is_next_to_its_step_however_many_events_wait(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    go = lambda rig: [rig.post("go") for _ in range(5)]  # noqa: E731
    agrees(
        path, journaled(path, mission(CALLING), lambda rig: {1.0: lambda: go(rig), 2.0: lambda: rig.post("stop_now")})
    )
    rows = rows_of(path)
    calls = [(at, row.step.seq) for at, row in enumerate(rows) if isinstance(row, StepRow) and row.step.effects]
    assert len(calls) == 5
    assert [(rows[at + 1].number, rows[at + 1].how) for at, _ in calls] == [(seq, "performed") for _, seq in calls]


@pytest.mark.parametrize("place", range(5))
def test_what_was_called_is_confirmed_whichever_row_is_too_long_to_be_written(
    place: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, too_long = tmp_path / "run.journal", 20_000
    monkeypatch.setattr("rai_missions.journal.sqlite_writer.LONGEST_BYTES", too_long)
    go = lambda rig: [rig.post("go", text="x" * too_long * (number == place)) for number in range(5)]  # noqa: E731
    rig = journaled(path, mission(CALLING), lambda rig: {1.0: lambda: go(rig)})
    result = rig.run()
    rig.book.close()
    rows = rows_of(path)
    called = [row.step.seq for row in rows if isinstance(row, StepRow) and row.step.effects]
    assert "cannot be written" in result.why and len(called) == len(rig.called) == place
    assert [row.number for row in rows if isinstance(row, Confirmation)] == called

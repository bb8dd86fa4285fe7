# SPDX-License-Identifier: Apache-2.0
"""What holds for every run that is recorded: its rows are the journal's, and it is replayed as the journal is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, Record, read
from rai_missions.mission.files import dump
from rai_missions.recording import journal_of
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.recording.kept import LAMP, kept, recording
from tests.rigs.journals import blackboard_writes, raw_rows_of, steps
from tests.strategies import EVENTS, missions

pytest.importorskip("mcap")


def written(folder: Path, run: list[tuple[Step, Any]]) -> tuple[Path, Path]:
    """The journal of a run, and its recording."""
    made = recording(folder / "run.mcap")
    with Journal.create(folder / "run.journal", Header(dump(LAMP)), witness=made.rows) as journal:
        for step, quiet in run:
            journal.write(step, since=1.25, quiet=quiet)
        journal.confirm(3, "succeeded")
        journal.note("it is over", {"after": 3})
    made.close(journal.path)
    return folder / "run.journal", folder / "run.mcap"


@given(st.lists(st.tuples(steps, blackboard_writes), max_size=4))
def test_the_rows_that_were_recorded_are_the_journals(
    tmp_path_factory: pytest.TempPathFactory, run: list[tuple[Step, Any]]
) -> None:
    journal, path = written(tmp_path_factory.mktemp("run"), run)
    with journal_of(path) as replayed, read(replayed.path) as again, Record(journal) as before:
        assert replayed.warning == ""
        assert raw_rows_of(replayed.path) == raw_rows_of(journal)
        assert list(again.steps()) == [step for step, _ in run]
        assert {each: again.blob(each) for each in again.blobs()} == {
            each: before.blob(each) for each in before.blobs()
        }


@given(st.data())
def test_a_recording_is_replayed_as_its_journal_is(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    mission, folder = data.draw(missions()), tmp_path_factory.mktemp("run")
    clock = SimulatedClock()
    made = recording(folder / "run.mcap", mission=mission, now=clock.now)
    with Journal.create(folder / "run.journal", Header(dump(mission)), witness=made.rows) as journal:
        runner = Runner(
            mission,
            connector=LocalConnector(now=clock.now),
            clock=clock,
            journal=journal,
            observer=RunObserver(made.step, made.status),
        )
        for name in data.draw(st.lists(st.sampled_from(EVENTS), max_size=6)):
            runner.post(Event(name))
        runner.kill()
        runner.run()
    made.close(journal.path)
    with journal_of(folder / "run.mcap") as replayed:
        assert replay(replayed.path) == replay(folder / "run.journal")
    assert len(kept(folder / "run.mcap").messages["/rai_missions/journal"]) == len(raw_rows_of(folder / "run.journal"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    run = [(Step(seq, seq / 2, Event("anomaly", seq / 2)), ()) for seq in range(1, 30)]
    return written(tmp_path_factory.mktemp("whole"), run)[1].read_bytes()


@given(st.data())
def test_a_recording_that_was_cut_off_anywhere_gives_its_first_rows_or_reports_why_not(
    tmp_path_factory: pytest.TempPathFactory, whole: bytes, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("cut") / "run.mcap"
    path.write_bytes(whole[: data.draw(st.integers(8, len(whole) - 1))])
    numbers, reported = read_as_far(path)
    assert numbers == list(range(len(numbers)))
    is_whole = numbers == list(range(32))  # only the index is cut off, which no one needs
    assert is_whole or any(words in reported for words in ("is cut off", "no recording of a mission"))


@given(st.data())
def test_no_byte_of_a_recording_can_be_changed_and_its_run_with_it(
    tmp_path_factory: pytest.TempPathFactory, whole: bytes, data: st.DataObject
) -> None:
    """Either the change is reported, or it is outside of the journal's rows, which are what they were."""
    path, altered = tmp_path_factory.mktemp("altered") / "run.mcap", bytearray(whole)
    altered[data.draw(st.integers(8, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(altered)
    numbers, reported = read_as_far(path)
    assert numbers == list(range(32)) or reported


def read_as_far(path: Path) -> tuple[list[int], str]:
    """The rows of a recording as far as it can be read, and what is reported about it."""
    try:
        with journal_of(path) as replayed, read(replayed.path) as record:
            return [raw[0] for raw in record.raw()], replayed.warning
    except DefinitionError as error:
        return [], str(error)


@pytest.mark.parametrize("value", ["\ud800", 10**30, -(2**64), [{"deep": "\udfff"}]])
def test_a_step_has_the_values_of_its_row_whatever_they_are(tmp_path: Path, value: Any) -> None:
    written(tmp_path, [(Step(1, 1.0, Event("anomaly", 1.0, {"value": value})), {})])
    (step,) = kept(tmp_path / "run.mcap").messages["/rai_missions/steps"]
    assert step["event"]["data"] == {"value": value}

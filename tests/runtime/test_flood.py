# SPDX-License-Identifier: Apache-2.0
"""What an event costs a run that is flooded: so many functions are called for it, whatever the machine is doing."""

from __future__ import annotations

import sys
import threading
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.recording import Recording, recorded
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

ROBOT = Robot.model_validate(
    {
        "name": "bench",
        "events": {"go": {"posted": True}, "end": {"posted": True}},
        "services": {"horn": {"service": "/horn"}},
    }
)
WORK = {"transitions": [{"on": "go", "do": [{"call": "horn"}]}, {"on": "end", "to": "over"}]}
MISSION = Mission.model_validate(
    {
        "name": "flood",
        "initial": "work",
        "events": ["go", "end"],
        "states": {"work": WORK, "over": {"final": "aborted"}},
    }
)


def calls_an_event(recording: Recording | None) -> float:
    """How many functions in Python the run's thread calls for an event that calls a service."""
    return (calls_of(400, recording) - calls_of(200, recording)) / 200


def calls_of(events: int, recording: Recording | None) -> int:
    connector, counted = LocalConnector(), Counter[str]()
    connector.serve("/horn", "std_srvs/srv/Trigger", lambda _: {"success": True, "message": ""})
    observer = RunObserver() if recording is None else RunObserver(recording.step, recording.status)
    kept = connector if recording is None else recorded(connector, recording)
    runner = Runner(MISSION, robot=ROBOT, connector=kept, observer=observer)
    for _ in range(events):
        runner.post(Event("go"))
    runner.post(Event("end"))

    def count(_: object, event: str, __: Any) -> None:
        counted[event] += threading.current_thread() is thread

    thread = threading.Thread(target=runner.run)
    threading.setprofile(count)
    try:
        thread.start()
        thread.join()
    finally:
        threading.setprofile(None)
    return counted["call"]


def test_an_event_of_a_flood_calls_few_functions() -> None:
    assert calls_an_event(None) < 150


def test_a_recorded_event_of_a_flood_calls_few_functions_more(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    unrecorded = calls_an_event(None)
    made = Recording.create(tmp_path / "run.mcap", mission=MISSION, about={}, now=lambda: 0.0)
    try:
        more = calls_an_event(made) - unrecorded
    finally:
        made.close()
    assert 0 < more < 10


def calls_of_rows(journal: Journal) -> int:
    """How many functions in Python are called for the rows of an event of a flood: its step, and a confirmation."""
    counted = Counter[str]()
    with journal:
        step = Chart(MISSION).start(0.0)
        sys.setprofile(lambda _, event, __: counted.update([event]))
        try:
            journal.write(step, since=0.0, performed=(1,))
        finally:
            sys.setprofile(None)
    return counted["call"]


def test_rows_that_are_written_at_once_are_handed_to_a_recording_at_once(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    header = Header(dump(MISSION))
    with Journal.create(tmp_path / "first.journal", header) as journal:
        journal.note("what is loaded with the first row is")
    made = Recording.create(tmp_path / "run.mcap", mission=MISSION, about={}, now=float)
    try:
        recorded_rows = calls_of_rows(Journal.create(tmp_path / "recorded.journal", header, witness=made.rows))
    finally:
        made.close()
    assert recorded_rows - calls_of_rows(Journal.create(tmp_path / "plain.journal", header)) in range(1, 7)

# SPDX-License-Identifier: Apache-2.0
"""A stamp from before the run's start is the same in the journal, a replay, a snapshot, and on the page."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event, Tick
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.replay.replay import replay
from visualize.live.scene import RunScene

MISSION = Mission.model_validate({
    "name": "dated", "initial": "on", "blackboard": {
        "near": {"type": "number", "source": "robot", "max_age_s": 3}, "far": {"type": "number", "source": "robot"}},
    "states": {"on": {"transitions": [{"when": {"all": [{"key": "near", ">": 5}, {"fresh": "near"}]}, "to": "high"}]},
               "high": {"transitions": [{"when": {"not": {"fresh": "near"}}, "to": "on"}]}},
})  # fmt: skip
writes = st.tuples(
    st.sampled_from(["near", "far"]), st.integers(0, 9), st.floats(0, 2), st.sampled_from([0, 0.5, 2, 2.9, 3, 60, 3600])
)


@given(st.lists(writes, max_size=12))
def test_a_stamp_is_the_same_wherever_it_is_kept(given_: list[tuple[str, int, float, float]]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.journal"
        chart, at, known = Chart(MISSION), 0.0, dict[str, float]()
        with Journal.create(path, Header(dump(MISSION), run="dated")) as journal:
            journal.write(chart.start(0.0), since=0.0)
            for key, value, later_s, age_s in given_:
                since, at = at, at + later_s
                data = {"value": value, "stamp": at - age_s}
                journal.write(chart.send(Event(key, at, data, "write")), since=since)
                known[key] = max(at - age_s, known.get(key, -1e9))
            journal.write(chart.send(Tick(at + 0.1)), since=at)
        assert {key: entry.at for key, entry in chart.view.board.items()} == known
        assert replay(path).holds
        shown = RunScene()
        with read(path) as record:
            for step in record.steps():
                shown.take(step)
        assert {key: stamp for key, (_, stamp) in shown.board.items()} == known
        again = Chart.restore(MISSION, chart.snapshot())
        assert again.view.board == chart.view.board and again.wake_at == chart.wake_at


def test_what_was_received_again_after_a_kill_keeps_its_stamp() -> None:
    chart = Chart(MISSION)
    chart.start(0.0)
    chart.write("near", 7, at=1.0)
    step = chart.send(Event("take_up", 2.0, {"heard": {"near": [6, -3500.0], "far": [1, 1.5]}}, "command"))
    shown = RunScene()
    shown.take(step)
    assert {key: entry.at for key, entry in chart.view.board.items()} == {"near": -3500.0, "far": 1.5}
    assert {key: stamp for key, (_, stamp) in shown.board.items()} == {"near": -3500.0, "far": 1.5}


def test_a_write_may_have_been_so_before_the_run() -> None:
    chart = Chart(MISSION)
    chart.start(0.0)
    step = chart.write("near", 9, at=1.0, stamp=-1.5)
    assert step.entered == ("high",) and step.wake_at == 1.5 and step.stamp_of("near") == -1.5
    assert chart.write("near", 9, at=1.2, stamp=-3600).why.startswith("'near' was not written")

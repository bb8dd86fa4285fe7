# SPDX-License-Identifier: Apache-2.0
"""What pages show of a run that was resumed, or migrated, is what its chart was after each entry of its journal."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.profile import dump_profile, robot_facts
from rai_missions.replay.migrate import migrate
from rai_missions.replay.rebuild import JournalReplayer
from rai_missions.replay.resume import resumption
from tests.laws.drawn import DrawnEvent, document, happenings
from tests.laws.test_cut_short import NAMED, Written, is_far_by_new_names, profile
from tests.replay.test_renamed import TWO, otherwise
from tests.rigs.charts import ScriptedRobot
from tests.rigs.turns import sooner_ended
from tests.visualize.page.reading import data_of, folded
from visualize.live.scene import RunScene
from visualize.page import review


def write(chart: Chart, journal: Journal, events: Iterable[Event | DrawnEvent], robot: ScriptedRobot) -> None:
    """Have a chart take what happens, and write it as a run does; keys and events by the names that it has."""
    written, mission = Written(chart, journal), chart.mission
    for each in events:
        event = each if isinstance(each, Event) else robot.event(*each)
        if event.kind in ("write", "event") and event.name not in (mission.blackboard | mission.events):
            event = event._replace(name=event.name + TWO)
        is_foreign = event.kind == "write" and mission.blackboard[event.name].source != "robot"  # no one writes those
        if chart.outcome is None and not is_foreign:
            robot.follow(written.step(lambda event=event: chart.send(event)))
    written.flush()


def continued(seed: int, folder: Path) -> tuple[Path, Mission] | None:
    """The journal of a run that is resumed, or migrated and resumed, and its mission; None for one that had ended."""
    rng = random.Random(seed)
    mission, script, state = Mission.model_validate(document(rng)), happenings(rng), rng.getstate()
    robot, cut, answers = profile(rng, mission), rng.randint(0, len(script)), ScriptedRobot("agent")
    path, chart = folder / "run.journal", Chart(mission, robot_facts=robot_facts(robot), named=NAMED)
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        answers.follow(Written(chart, journal).step(lambda: chart.start(0.0)))
        write(chart, journal, script[:cut], answers)
    if chart.outcome is not None:
        return None
    named: dict[str, Any] = NAMED
    if rng.random() < 0.5:
        now, map_ = otherwise(mission)
        rng.setstate(state)
        named, new = {"is_far": is_far_by_new_names}, folder / "new.journal"
        migrate(path, now, map_, to=new, robot=profile(rng, now, TWO), named=named)
        path, mission = new, now
    with read(path) as record:
        chart, seal = resumption(record, mission, named=named).chart, record.seal
    began = chart.at + rng.choice([0.0, 0.25, 1.0])
    count = next(name for name in mission.blackboard if name.startswith("count"))
    received = rng.choice([{}, {count: [1, chart.at]}])
    begins = Event("take_up", began, {"heard": received, "present": began}, "command")
    later = [each._replace(at=each.at + 1.0) for each in script[cut:]]
    with Journal.open(path, seal=seal) as journal:
        write(chart, journal, [begins, *later], answers)
    return path, mission


def values(chart: Chart) -> dict[str, Any]:
    return {name: plain(entry.value) for name, entry in chart.view.board.items()}


def compare(path: Path, mission: Mission) -> None:
    """Hold what a review and a live page show after each entry against the chart that does the run again."""
    data = data_of(review(mission, [path]))
    shown = folded(data["runs"][0], data["chart"]["keys"])
    keys = mission.blackboard
    board = {name: (key.initial, 0.0) for name, key in keys.items() if key.initial is not None}
    scene = RunScene(board=board, keys=keys)
    with read(path) as record:
        replayer = JournalReplayer(record, mission)
        for made, (active, known) in zip(record.entries(), shown, strict=True):
            replayer.again(made)
            chart = replayer.chart
            assert active == chart.active, made.step.seq
            assert {name: entry[0] for name, entry in known.items()} == values(chart), made.step.seq
            scene.take(made.step, made.before)
            assert {name: plain(value) for name, (value, _) in scene.board.items()} == values(chart), made.step.seq
            assert (scene.mode, scene.control, scene.outcome or None) == (chart.mode, chart.holder, chart.outcome)
            assert set(scene.questions) == {each.number for each in chart.questions}, made.step.seq
            if chart.outcome is None:
                assert scene.active == chart.active, made.step.seq
                assert (scene.held_by, scene.held_since) == (chart.held_by, chart.held_since), made.step.seq
                assert scene.paused_at == chart.paused_at, made.step.seq


def agree(seed: int, folder: Path) -> str:
    """Compare for one run; `same`, or why there was nothing to compare."""
    with sooner_ended():
        found = continued(seed, folder)
        if found is None:
            return "it had ended"
        compare(*found)
    return "same"


@given(seed=st.integers(0, 2**32))
@settings(max_examples=2 * settings.default.max_examples)
def test_pages_show_a_run_that_continues_as_it_is(seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    assume(agree(seed, tmp_path_factory.mktemp("shown")) == "same")


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_pages_show_three_thousand_runs_that_continue_as_they_are(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(3_000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found[agree(seed, folder)] += 1
    assert found["same"] > 1_500

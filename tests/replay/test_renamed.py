# SPDX-License-Identifier: Apache-2.0
"""A mission in which everything is called otherwise is the same: a run that continues in it ends as it would have."""

from __future__ import annotations

import json
import logging
import random
import shutil
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.cli.main import main
from rai_missions.engine import Chart
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, renamed
from rai_missions.profile import Robot
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.replay import replay
from rai_missions.replay.resume import resumption
from tests.replay.mortal import Fate, live
from tests.replay.test_kills import has_ended, holds
from tests.replay.trial import ROBOT, WatchedFate, Yard, fates, thinkers, worth_a_trial
from tests.rigs.journals import steps_of
from tests.strategies import missions

TWO = "_two"


def second(known: Collection[str]) -> Callable[[str], str]:
    return lambda name: name + TWO if name in known else name


def otherwise(mission: Mission) -> tuple[Mission, Map]:
    """The mission with other names for all its states, keys and events, and the map into it."""
    states, keys, events = {name for _, name, _ in mission.walk()}, mission.blackboard, mission.events
    names = Names(
        state=second(states),
        key=second(keys),
        event=second(events),
        timer=lambda name: name,
        trigger=lambda on: tuple(second(events)(name) for name in on),
    )
    now = renamed(mission, names)
    each = {"states": sorted(states), "keys": keys, "events": events}
    map_ = Map(**{word: {name: name + TWO for name in known} for word, known in each.items()})
    return Mission.model_validate(now.written()), map_


def second_robot() -> Robot:
    blackboard = {name + TWO: each for name, each in ROBOT.blackboard.items()}
    return ROBOT.model_copy(
        update={"blackboard": blackboard, "events": {name + TWO: each for name, each in ROBOT.events.items()}}
    )


def gone_over(folder: Path, mission: Mission, seed: int) -> str:
    """Kill a run, have it continue in the renamed mission, and compare its end with that of the run left alone."""
    whole = Yard(mission, seed, keeps_time=True)
    watched = WatchedFate(whole)
    result = live(folder / "whole.journal", whole, mission, ROBOT, thinkers(seed, whole), watched)
    assert result is not None
    yard, path, new = Yard(mission, seed, keeps_time=True), folder / "run.journal", folder / "new.journal"
    who = thinkers(seed, yard)
    chances = {name: each for name, each in watched.chances.items() if name != "before the start"}
    (fate,) = fates(random.Random(seed), chances, 1)
    if live(path, yard, mission, ROBOT, who, fate) is not None:
        return "it had ended"
    now, map_ = otherwise(mission)
    try:
        migrate(path, now, map_, to=new, robot=second_robot())
    except UsageError:
        return "it had ended, or had not begun"
    with read(path) as record:
        yard.reported |= {step.event.data.get("id", -1) for step in record.steps()}
    yard.suffix = TWO
    live(new, yard, now, second_robot(), who, Fate(seed % 6, is_done=bool(seed % 2)))  # it dies once more, at once
    with read(new) as record:
        yard.reported |= {step.event.data.get("id", -1) for step in record.steps()}
    if has_ended(new, now):
        return "it ended at once"
    ended = live(new, yard, now, second_robot(), who, Fate())
    assert ended is not None
    holds(new, yard, now)
    steps = steps_of(new)
    assert steps[0].event.name == "migrate" and steps[0].outcome is None, "a migration ends no run"
    if any(step.event.kind == "doubt" and step.event.data.get("what") != "publish" for step in steps):
        return "an effect was in doubt"
    assert (ended.outcome, ended.why.replace(TWO, "")) == (result.outcome, result.why)
    return "same"


@settings(deadline=None, max_examples=6)
@given(missions(), st.integers(0, 10_000))
def test_whatever_mission_is_renamed_its_run_ends_as_it_would_have(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, seed: int
) -> None:
    gone_over(tmp_path_factory.mktemp("any"), mission, seed)


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_runs_of_renamed_missions_end_as_they_would_have(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = Counter[str]()
    logging.disable(logging.CRITICAL)
    try:
        for batch in range(1, 51):
            for number, mission in enumerate(worth_a_trial(batch, 100)):
                folder = tmp_path / f"{batch} {number}"
                folder.mkdir()
                found[gone_over(folder, mission, batch * 1000 + number)] += 1
                shutil.rmtree(folder)
            if batch % 10 == 0:
                with capsys.disabled():
                    print(f"\n{batch} batches: {dict(found)}", flush=True)  # noqa: T201
    finally:
        logging.disable(logging.NOTSET)
    assert found["same"] >= 100


def test_a_history_of_a_renamed_mission_leads_back_into_its_list(tmp_path: Path) -> None:
    rounds = {"x": {"transitions": [{"on": "next", "to": "z"}]}, "z": {"final": "succeeded"}}
    tour = {"each": "items", "as": "item", "initial": "x", "states": rounds}
    work = {"initial": "tour", "states": {"tour": tour, "kept": {"history": "deep"}}}
    mission = Mission.model_validate({
        "name": "tour", "initial": "work", "events": ["next", "away", "back"],
        "blackboard": {"items": {"type": "list", "initial": [1, 2, 3]}, "item": {"type": "integer"}},
        "states": {"work": {**work, "transitions": [{"on": "away", "to": "off"}]},
                   "off": {"transitions": [{"on": "back", "to": "kept"}]}},
    })  # fmt: skip
    chart, path, new = Chart(mission), tmp_path / "run.journal", tmp_path / "new.journal"
    with Journal.create(path, Header(dump(mission))) as journal:
        journal.write(chart.start(), since=0.0)
        for name in ("next", "away"):
            journal.write(chart.send(Event(name)), since=0.0)
    now, map_ = otherwise(mission)
    migrate(path, now, map_, to=new)
    with read(new) as record:
        again = resumption(record, now).chart
    again.settle_holds()
    again.send(Event("resume", kind="command"))
    again.send(Event("back" + TWO))
    assert "x" + TWO in again.active and again.view.board["item" + TWO].value == 2


RESTING = {
    "name": "patrol", "version": "1.0.0", "initial": "resting",
    "blackboard": {"rounds": {"type": "integer", "initial": 2}},
    "states": {"resting": {"transitions": [{"after_s": 0.2, "to": "done"}]}, "done": {"final": "canceled"}},
}  # fmt: skip


def begun(path: Path) -> Path:
    """A run that was cut short after its start, of a mission without a robot."""
    mission = Mission.model_validate(RESTING)
    with Journal.create(path, Header(dump(mission))) as journal:
        journal.write(Chart(mission).start(), since=0.0)
    return path


def test_the_command_line_migrates_a_run_or_reports_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    journal, map_, mission = begun(tmp_path / "run.journal"), tmp_path / "map.json", tmp_path / "mission.json"
    text = dump(Mission.model_validate(RESTING)).replace("resting", "waiting").replace("1.0.0", "2.0.0")
    mission.write_text(text)
    command = ["run", "--resume", str(journal), str(mission), "--no-operator"]
    assert main(command) == 2
    assert "--migrate MAP" in capsys.readouterr().err
    map_.write_text("{}")
    assert main([*command, "--migrate", str(map_)]) == 2
    assert "map.json: /states: 'resting' is active, and the mission now has no state" in capsys.readouterr().err
    map_.write_text(json.dumps({"states": {"resting": "waiting"}}))
    assert main([*command, "--migrate", str(map_), "--json"]) == 1, "it ends, and not with success"
    printed = capsys.readouterr()
    reported = json.loads(printed.out)
    assert (reported["outcome"], reported["journal"]) == ("canceled", str(tmp_path / "run-migrated.journal"))
    assert f"the run of {journal} resumes in {reported['journal']}, as 'patrol' 2.0.0" in printed.err
    assert replay(reported["journal"]).holds
    assert main([*command, "--migrate", str(map_)]) == 2
    assert "continues in another mission" in capsys.readouterr().err
    assert main(["run", str(mission), "--migrate", str(map_)]) == 2
    assert "--migrate MAP goes with --resume JOURNAL" in capsys.readouterr().err

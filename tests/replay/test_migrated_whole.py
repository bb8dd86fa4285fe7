# SPDX-License-Identifier: Apache-2.0
"""What a migration must not lose: the goal of a composed action, and a list that was over as it began."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.errors import DefinitionError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile, robot_facts
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.resume import resumption

Json = dict[str, Any]


def loading(key: str) -> Mission:
    """A mission with an action whose robot counts under a key."""
    return Mission.model_validate({
        "name": "loading", "initial": "load", "states": {
            "load": {"action": "haul", "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "over"}]},
            "over": {"final": "canceled"}},
        "blackboard": {key: {"type": "integer", "source": "robot", "optional": True}},
    })  # fmt: skip


def hauler(key: str, **good: Json) -> Robot:
    """A robot whose action is over once it has counted two under a key."""
    return Robot.model_validate({
        "name": "hauler", "blackboard": {key: {"topic": "/bales", "type": "std_msgs/msg/Int32"}},
        "actions": {"haul": {"start": {"service": "/haul", "type": "x/srv/Haul", **good}, "cancel": "/stop",
                             "succeeded": {"key": key, ">=": 2}}},
    })  # fmt: skip


def begun(folder: Path, mission: Mission, robot: Robot) -> Path:
    path = folder / "run.journal"
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        journal.write(Chart(mission, robot_facts=robot_facts(robot)).start(0.0), since=0.0)
    return path


def test_the_goal_of_a_composed_action_continues_where_what_it_counts_under_has_another_name(tmp_path: Path) -> None:
    reply = {"succeeded": {"key": "bales", "==": 0}}  # a field of the reply, which no map renames
    path = begun(tmp_path, loading("bales"), hauler("bales", **reply))
    now, new = loading("hauled"), tmp_path / "new.journal"
    assert migrate(path, now, Map(keys={"bales": "hauled"}), to=new, robot=hauler("hauled", **reply)).notes == ()
    with read(new) as record:
        chart = resumption(record, now).chart
    chart.send(Event("haul", 1.0, {}, "accepted", 1))
    chart.send(Event("hauled", 2.0, {"value": 2}, "write"))
    assert (chart.outcome, chart.why) == ("canceled", "'over' was reached")


@pytest.mark.parametrize("robot", [hauler("bales"), hauler("hauled", succeeded={"key": "done", "==": True})])
def test_a_goal_whose_action_is_another_one_now_is_refused(tmp_path: Path, robot: Robot) -> None:
    path = begun(tmp_path, loading("bales"), hauler("bales"))
    with pytest.raises(DefinitionError) as refused:
        migrate(path, loading("hauled"), Map(keys={"bales": "hauled"}), to=tmp_path / "new.journal", robot=robot)
    sentence = "/actions/haul: a goal of it is under way, and the profile has another action there now; leave it"
    assert sentence in [str(fault) for fault in refused.value.faults]


def touring(tour: str, stops: list[str]) -> Mission:
    """A mission that goes through a list in one region, and waits in the other."""
    each = {"each": "stops", "as": "stop", "initial": "at", "states": {"at": {}}}
    waits = {"initial": "wait", "states": {"wait": {"transitions": [{"on": "go", "to": "went"}]},
                                           "went": {"final": "succeeded"}}}  # fmt: skip
    work = {"parallel": {tour: each, "other": waits}, "transitions": [{"on": "succeeded", "to": "over"}]}
    return Mission.model_validate({
        "name": "touring", "initial": "work", "events": ["go"],
        "blackboard": {"stops": {"type": "list", "initial": stops}, "stop": {"type": "string", "initial": ""}},
        "states": {"work": work, "over": {"final": "canceled"}},
    })  # fmt: skip


@pytest.mark.parametrize("tour", ["tour", "trip"])
def test_a_list_that_was_over_as_it_began_is_over_after_a_migration(tmp_path: Path, tour: str) -> None:
    was, now = touring("tour", []), touring(tour, [])
    path, new = tmp_path / "run.journal", tmp_path / "new.journal"
    with Journal.create(path, Header(dump(was))) as journal:
        journal.write(Chart(was).start(0.0), since=0.0)
    migrate(path, now, Map(states={"tour": tour}), to=new)
    with read(new) as record:
        chart = resumption(record, now).chart
    assert tour in chart.active and "at" not in chart.active
    chart.send(Event("go", 1.0))
    assert (chart.outcome, chart.why) == ("canceled", "'over' was reached")

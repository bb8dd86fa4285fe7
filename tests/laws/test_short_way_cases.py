# SPDX-License-Identifier: Apache-2.0
"""Steps for which the short way has more to do than meets the eye."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from tests.laws.test_short_way import LongWay, agree, plain_mission


def waits_for(guard: dict[str, Any]) -> dict[str, Any]:
    return {"condition": "success", "child": {"check": guard}}


def test_a_tree_that_begins_in_a_step_sees_what_the_step_has_left() -> None:
    counts = {"sequence": [{"set": "n", "add": 1}, {"check": {"in": "s"}}], "memory": False}
    mission = Mission.model_validate({
        "name": "m", "events": ["a", "b", "c"], "initial": "s", "blackboard": {"n": {"type": "integer", "initial": 0}},
        "states": {
            "s": {"transitions": [{"on": "a", "to": "t", "do": [{"raise": "c"}]}]},
            "t": {"transitions": [{"on": "c", "to": "u"}]},
            "u": {"tree": {"selector": [counts, {"wait_s": 5}], "memory": False},
                  "transitions": [{"on": "b", "to": "s"}]},
        },
    })  # fmt: skip
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for at, name in enumerate("abab"):
        agree(short, long, Event(name, float(at)))


def test_a_list_that_is_left_is_forgotten() -> None:
    rounds = {"each": "items", "as": "item", "initial": "x", "states": {"x": {}},
              "transitions": [{"on": "a", "to": "t"}]}  # fmt: skip
    mission = Mission.model_validate({
        "name": "m", "events": ["a", "b"], "initial": "s",
        "blackboard": {"items": {"type": "list", "initial": [1, 2]}, "item": {"type": "integer"}},
        "states": {"s": rounds, "t": {"transitions": [{"on": "b", "to": "s"}]}},
    })  # fmt: skip
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for name in "abab":
        agree(short, long, Event(name, 0.0))
        assert short.snapshot() == long.snapshot()


def test_a_round_that_begins_with_a_reading_may_end_with_an_event() -> None:
    seen, unseen = {"key": "f", "==": True}, {"key": "f", "==": False}
    waits = [{"key": "n", "==": 1}, {"any": [unseen, {"key": "n", "==": 0}]}, seen]
    tree = {"repeat": -1, "child": {"sequence": [waits_for(each) for each in waits], "memory": True}}
    there = {"on": "a", "to": "yb", "do": [{"set": "n", "value": 1}]}
    back = {"on": "b", "to": "ya", "do": [{"set": "n", "value": 0}]}
    mission = Mission.model_validate({
        "name": "m", "events": ["a", "b"], "initial": "p", "blackboard": {
            "n": {"type": "integer", "initial": 0}, "f": {"type": "boolean", "source": "robot", "optional": True}},
        "states": {"p": {"parallel": {
            "x": {"initial": "xa", "states": {"xa": {"tree": tree}}},
            "y": {"initial": "ya", "states": {"ya": {"transitions": [there]}, "yb": {"transitions": [back]}}},
        }}},
    })  # fmt: skip
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    agree(short, long, Event("f", 0.0, {"value": False}, "write"))
    for name in "aba":
        agree(short, long, Event(name, 0.0))
    agree(short, long, Event("f", 0.1, {"value": True}, "write"))
    agree(short, long, Event("b", 0.2))


def test_events_that_go_round_for_ever_end_at_the_same_microstep() -> None:
    mission = Mission.model_validate({
        "name": "m", "events": ["a", "b", "c"], "initial": "s", "blackboard": {"n": {"type": "integer", "initial": 0}},
        "states": {
            "s": {"transitions": [{"on": "a", "to": "t", "do": [{"raise": "c"}]}]},
            "t": {"transitions": [{"on": "b", "to": "s"}, {"on": "c", "when": {"key": "n", ">": 0}, "do": [
                {"set": "n", "add": 1}, {"raise": "c"}]}, {"on": "c", "do": [{"set": "n", "add": 1}]}]},
        },
    })  # fmt: skip
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for name in "aba":
        agree(short, long, Event(name, 0.0))
    assert short.outcome == "failed"


@pytest.mark.parametrize("guard", [{"key": "n", "==": 0}, {"key": "n", ">": 0}])
def test_what_the_engine_raises_is_refused_from_outside(guard: dict[str, Any]) -> None:
    to = [{"on": "a", "to": "t"}, {"on": "uncertain", "when": guard, "to": "t"}]
    mission = Mission.model_validate({
        "name": "m", "events": ["a"], "initial": "s", "blackboard": {"n": {"type": "integer", "initial": 0}},
        "states": {"s": {"transitions": to}, "t": {"transitions": [{"on": ["a", "uncertain"], "to": "s"}]}},
    })  # fmt: skip
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for _ in range(3):
        agree(short, long, Event("uncertain", 1.0, {}, "doubt"))
    for at in (2.0, 3.0):
        agree(short, long, Event("a", at))
        assert agree(short, long, Event("uncertain", at)).refusal == "unknown"


@pytest.mark.parametrize("at", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("kind", ["event", "write"])
def test_no_way_takes_a_time_that_is_no_number_of_seconds(at: float, kind: Any) -> None:
    chart = Chart(plain_mission(random.Random(0)))
    chart.start(0.0)
    with pytest.raises(UsageError):
        chart.send(Event("fact" if kind == "write" else "a", at, {"value": 1}, kind))

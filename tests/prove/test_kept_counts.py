# SPDX-License-Identifier: Apache-2.0
"""Numbers that are counted, copied and brought: what a run shows of them, the proof has, or names as tried."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from tests.rigs.charts import Drawn, ScriptedRobot

Json = dict[str, Any]
READ: Json = {"type": "integer", "source": "robot"}
KEPT: Json = {"type": "integer", "initial": 0}
STOP: Json = {"on": "stop", "to": "over"}
ENDS = ["failed", "rejected", "timed_out"]
X: Json = {"fields": {"x": "integer"}}


class Run(NamedTuple):
    """A mission, and what happens until it is where no run was to come."""

    keys: Json
    states: Json
    happens: list[Drawn | Event]
    given: Mapping[str, Any] = MappingProxyType({})


def chain(names: str, last: str, **words: Any) -> Json:
    """States from each of which an event leads to the next."""
    return {
        name: {"transitions": [{"on": "next", "to": to, **words}, STOP]}
        for name, to in zip(names, [*names[1:], last], strict=True)
    }


def drive(*transitions: Json) -> Json:
    return {"action": "drive", "timeout_s": 9, "result": {"kept": "n"}, "transitions": [*transitions, FAILED]}


FAILED: Json = {"on": ENDS, "to": "over"}
MORE = {"do": [{"set": "kept", "add": 1}]}
LESS = {"do": [{"set": "kept", "add": -1}]}
AT_TEN: Json = {"end": {"transitions": [{"on": "next", "when": {"key": "kept", "==": 10}, "to": "found"}, STOP]}}
FOUR_MORE = {**chain("abcd", "end", **MORE), **AT_TEN}
NEXT: Drawn = ("event", "next")
IS_MORE: Json = {"key": "read", ">": {"key": "kept"}}
IS_LESS: Json = {"key": "read", "<": {"key": "kept"}}


def taken(source: str) -> Json:
    """The first state: it keeps a number."""
    return {"transitions": [{"on": "next", "do": [{"set": "kept", "from": source}], "to": "a"}, STOP]}


RISING: Json = {
    "on": "next",
    "when": {"key": "seen.x", ">": {"key": "last.x"}},
    "do": [{"set": "last", "from": "seen"}],
}
SEEN: Json = {"type": "object", "fields": {"x": "integer"}}
RUNS: dict[str, Run] = {
    "a reading is kept, and counted": Run(
        {"kept": KEPT, "read": READ}, {"first": taken("read"), **FOUR_MORE}, [NEXT] * 6, {"read": 6},
    ),
    "an argument is kept, and counted": Run(
        {"kept": KEPT, "many": {**KEPT, "source": "argument"}}, {"first": taken("many"), **FOUR_MORE}, [NEXT] * 6,
        {"many": 6},
    ),
    "what an event brings is kept, and counted": Run(
        {"kept": KEPT}, {"first": taken("event.x"), **FOUR_MORE}, [Event("next", 0, {"x": 6}), *[NEXT] * 5],
    ),
    "a result is kept, and counted": Run(
        {"kept": KEPT}, {"first": drive({"on": "succeeded", "to": "a"}), **FOUR_MORE},
        [("result", 0, "succeeded", 6), *[NEXT] * 5],
    ),
    "an item is kept, and counted": Run(
        {"items": {"type": "list", "source": "argument", "initial": []}, "kept": KEPT},
        {"first": {"each": "items", "as": "kept", "initial": "a", "transitions": [{"on": "succeeded", "to": "over"}],
                   "states": {**chain("abcd", "end", **MORE), "last": {"final": "succeeded"}, "end": {
                       "transitions": [*AT_TEN["end"]["transitions"], {"on": "next", "to": "last"}]}}}},
        [NEXT] * 5, {"items": [6]},
    ),
    "a copy of what grows shrinks": Run(
        {"sum": KEPT, "kept": KEPT},
        {"first": {"transitions": [
            {"on": "more", "do": [{"set": "sum", "add": 1}]},
            {"on": "next", "do": [{"set": "kept", "from": "sum"}], "to": "a"}, STOP]},
         **chain("abcd", "end", **LESS),
         "end": {"transitions": [{"on": "next", "when": {"key": "kept", ">": 3}, "to": "found"}, STOP]}},
        [*[("event", "more")] * 8, *[NEXT] * 6],
    ),
    "a field is kept with its object": Run(
        {"seen": {**SEEN, "source": "robot"}, "last": {**SEEN, "initial": {"x": 0}}},
        {"first": {"transitions": [{**RISING, "to": "a"}, STOP]},
         **{name: {"transitions": [{**RISING, "to": to}, STOP]} for name, to in (("a", "b"), ("b", "found"))}},
        [NEXT, ("write", "seen", {"x": 2}), NEXT, ("write", "seen", {"x": 3}), NEXT], {"seen": {"x": 1}},
    ),
    "an item is less than a reading, the one before was more": Run(
        {"items": {"type": "list", "source": "argument", "initial": []}, "kept": {"type": "integer"},
         "read": READ, "armed": {"type": "boolean", "initial": False}},
        {"first": {"each": "items", "as": "kept", "initial": "look", "transitions": [
            {"on": "succeeded", "to": "over"}], "states": {
                "look": {"transitions": [{"when": {"all": [{"key": "armed", "==": True}, IS_MORE]}, "to": "found"},
                                         {"when": IS_LESS, "to": "wait"}, STOP]},
                "wait": {"transitions": [{"when": {"not": IS_LESS}, "to": "over"},
                                         {"on": "next", "do": [{"set": "armed", "value": True}], "to": "last"}]},
                "last": {"final": "succeeded"}}}},
        [NEXT], {"items": [9, 1], "read": 5},
    ),
    "a key of the mission goes stale": Run(
        {"kept": {**KEPT, "max_age_s": 2}},
        {"first": {"transitions": [{"on": "next", "when": {"not": {"fresh": "kept"}}, "to": "found"}, STOP]}},
        [Event("next", 3.0)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", RUNS)
def test_what_a_run_enters_is_not_called_out_of_reach(what: str) -> None:
    keys, states, happens, given = RUNS[what]
    ends: Json = {"found": {"transitions": [STOP]}, "over": {"final": "aborted"}}
    mission = Mission.model_validate({
        "name": "counted", "initial": "first", "blackboard": keys, "events": {"next": X, "more": {}, "stop": {}},
        "states": {**states, **ends},
    })  # fmt: skip
    chart, robot = Chart(mission), ScriptedRobot()
    for key, value in given.items():
        chart.write(key, value, 0.0)
    robot.follow(chart.start(0.0))
    for each in happens:
        robot.follow(chart.send(each if isinstance(each, Event) else robot.event(each, chart.at)))
    assert "found" in chart.active
    assert "found" not in prove(mission, most=500).never

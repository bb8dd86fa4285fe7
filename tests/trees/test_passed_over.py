# SPDX-License-Identifier: Apache-2.0
"""What was not looked at for a while is looked at again when a tick comes back to it: an example of each way."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from tests.trees.growing import Moment, is_true
from tests.trees.test_compiled import Both, as_py_trees, comparable

CHECKS = {key: {"check": is_true(key)} for key in "abc"}
AWAY_AND_BACK = {
    "a selector's lower child": (
        {"failure_is_running": {
            "selector": [{"sequence": [CHECKS["a"], {"action": "drive"}]}, {"inverter": CHECKS["b"]}],
        }},
        [({"a": False, "b": True}, ""), ({"a": True, "b": True}, ""), ({"a": True, "b": False}, ""),
         ({"a": True, "b": False}, "failed")],
    ),
    "the child of a guard that was shut": (
        {"selector": [
            {"success_is_failure": {"eternal_guard": is_true("a"), "child": CHECKS["b"]}}, {"wait_s": 999.5},
        ], "memory": False},
        [({"a": True, "b": True}, ""), ({"a": False, "b": True}, ""), ({"a": False, "b": False}, ""),
         ({"a": True, "b": False}, "")],
    ),
    "a selector in a sequence that begins again": (
        {"failure_is_running": {"sequence": [{"selector": [CHECKS["a"], CHECKS["b"]]}, CHECKS["c"]]}},
        [({"a": False, "b": False, "c": False}, ""), ({"a": True, "b": False, "c": False}, "")],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", AWAY_AND_BACK)
def test_what_was_passed_over_is_looked_at_again(name: str) -> None:
    tree, life = AWAY_AND_BACK[name]
    as_py_trees(tree, [Moment(facts, (end, "", ""), 0) for facts, end in life])


def test_a_key_that_was_written_and_not_taken_is_looked_at_again_in_each_run() -> None:
    watched = {"sequence": [CHECKS["c"], {"wait_s": 999.5}], "memory": False}
    tree: Any = {"sequence": [{"set": "c", "value": True}, watched]}
    first, second = Both(tree), Both(tree)
    second.ours = first.ours
    for at in range(2):
        for run in (first, second):
            ours, theirs = run.tick(at, Moment({"c": None}, ("", "", ""), 0))
            assert comparable(ours) == comparable(theirs)
    assert ours.status == "failure"


def test_what_a_leafs_result_writes_is_seen_by_the_tick_that_takes_its_end() -> None:
    tree = {"selector": [
        {"sequence": [{"check": {"key": "found", "==": 1}}, {"wait_s": 5}], "memory": False},
        {"call": "ask", "result": {"found": "count"}},
    ]}  # fmt: skip
    work = {"tree": tree, "transitions": [{"on": ["succeeded", "failed"], "to": "end"}]}
    chart = Chart(Mission.model_validate({
        "name": "m", "initial": "work", "blackboard": {"found": {"type": "integer"}},
        "states": {"work": work, "end": {"final": "failed"}},
    }))  # fmt: skip
    number = chart.start(0.0).effects[0].number  # type: ignore[union-attr]
    assert chart.send(Event("succeeded", 1.0, {"count": 1}, "result", number)).outcome is None
    assert chart.wake_at == 6.0

# SPDX-License-Identifier: Apache-2.0
"""What a tree's node reports is written like anything else: to a key of the mission that can hold it."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.mission.mission import Mission

HERE = "/states/work/tree/status_to_blackboard"


def found(key: dict[str, Any], *, requires: bool = False) -> list[tuple[str, str]]:
    tree = {"status_to_blackboard": "status", "child": {"wait_s": 1}}
    over: dict[str, Any] = {"final": "aborted"}
    if requires:
        over = {"final": "succeeded", "requires": {"key": "status", "==": "success"}}
    states = {
        "work": {
            "tree": tree,
            "transitions": [
                {"when": {"key": "status", "==": "failure"}, "to": "over"},
                {"on": "succeeded", "to": "over"},
            ],
        },
        "over": over,
    }
    written = {"name": "m", "initial": "work", "blackboard": {"status": key}, "states": states}
    return [(each.rule, each.place) for each in check(Mission.model_validate(written)) if each.severity == "error"]


def test_a_status_is_a_write_of_a_string() -> None:
    assert found({"type": "string"}) == []


@pytest.mark.parametrize("source", ["robot", "argument", "answer"])
def test_no_status_is_written_to_a_key_of_another_source(source: str) -> None:
    assert ("forbidden-write", HERE) in found({"type": "string", "source": source})


def test_no_status_is_written_to_a_key_of_another_type() -> None:
    assert ("mismatched-write", HERE) in found({"type": "boolean"})


def test_no_success_rests_on_what_the_mission_states_itself() -> None:
    assert any(rule == "unfounded-success" for rule, _ in found({"type": "string"}, requires=True))

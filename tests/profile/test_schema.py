# SPDX-License-Identifier: Apache-2.0
"""The schema that is shipped is the models' own, and reports the same of a profile."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import rai_missions
from rai_missions.errors import DefinitionError
from rai_missions.profile import parse_profile
from rai_missions.profile.schema import robot_schema
from tests.profile.profiles import PROFILE, altered

REPORTED = "the format has changed: run `rai-missions schema robot > rai_missions/robot.schema.json`"
SHIPPED = Path(rai_missions.__file__).with_name("robot.schema.json")


def valid(profile: Any) -> bool:
    return jsonschema.Draft202012Validator(robot_schema()).is_valid(profile)


def test_the_schema_that_is_shipped_is_the_models_own() -> None:
    made = json.dumps(robot_schema(), indent=2, ensure_ascii=False) + "\n"
    assert SHIPPED.read_text(encoding="utf-8") == made, REPORTED


def test_the_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(robot_schema())


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"$schema": "robot.schema.json"},
        {"control": {"agent": "/tractor1/give"}},
        {"actions/drive_alleys/start": {"service": "/go", "request": {"fast": True}}},
        {"services/horn/succeeded": {"key": "code", "==": 0}},
    ],
)
def test_a_profile_that_is_read_is_valid(change: dict[str, Any]) -> None:
    profile = altered(PROFILE, change)
    parse_profile(json.dumps(profile))
    assert valid(profile)


@pytest.mark.parametrize(
    "change",
    [
        {"name": None},
        {"format": 2},
        {"colour": "red"},
        {"connector": {"world": "orchard"}},
        {"blackboard/battery/topic": None},
        {"blackboard/battery/every_s": 1},
        {"blackboard/battery/as": "video"},
        {"events/anomaly/every_s": None},
        {"events/go/topic": "/go"},
        {"actions/drive_alleys/succeeded": None},
        {"actions/go_home/start": "/x"},
        {"services/horn/service": None},
        {"rules/assessing": [{"answer": "Stop!"}]},
    ],
)
def test_a_profile_that_is_refused_is_not_valid(change: dict[str, Any]) -> None:
    profile = altered(PROFILE, change)
    with pytest.raises(DefinitionError):
        parse_profile(json.dumps(profile))
    assert not valid(profile)

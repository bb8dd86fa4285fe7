# SPDX-License-Identifier: Apache-2.0
"""One edit a case by which the design's mission loses its teeth: none of them may be told as nothing."""

from __future__ import annotations

import json

import pytest

from rai_missions.mission import Mission
from tests.visualize.diff.test_severity import compared
from tests.visualize.runs import document, tractor
from visualize import difference


@pytest.mark.parametrize(("old", "new", "sort"), [("anomaly", "trouble", "event"), ("battery", "charge", "key")])
def test_a_new_name_for_what_others_know_by_the_old_is_for_review(old: str, new: str, sort: str) -> None:
    other = Mission.model_validate(json.loads(json.dumps(document()).replace(f'"{old}"', f'"{new}"')))
    (found,) = difference(tractor(), other).safety
    assert found.sentence.startswith(f"{sort} '{old}' renamed to '{new}'")
    assert found.before == f"'{old}'; profiles and other systems know it by this name"


def test_a_new_name_for_a_key_of_the_mission_alone_is_not() -> None:
    other = Mission.model_validate(json.loads(json.dumps(document()).replace('"signals"', '"horns"')))
    found = difference(tractor(), other)
    assert [change.topic for change in found.changes] == ["name"]
    assert found.safety == ()


def test_another_name_of_the_mission_is_a_difference() -> None:
    found = compared(lambda new: new.update(name="another"))
    assert [change.sentence for change in found.changes] == ["mission: 'name' changed"]
    assert found.lines()[0].endswith("nothing that diff weighs as safety-relevant, 1 other")

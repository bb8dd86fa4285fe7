# SPDX-License-Identifier: Apache-2.0
"""A profile of which some entries cannot be read: what it lacks is found, and nothing that it has."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError
from rai_missions.mission.files import load
from rai_missions.profile import legible_profile, missing_anyway, parse_profile

TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"
PROFILE: dict[str, Any] = json.loads((TRACTOR / "robot.sim.json").read_text())
MISSION = load(TRACTOR / "mission.json")
ENTRIES = [(word, name) for word, item in PROFILE.items() if isinstance(item, dict) for name in item]
LOST = ("actions", "cross")
"""An entry that the mission needs."""


def is_unread(document: dict[str, Any]) -> bool:
    try:
        parse_profile(json.dumps(document))
    except DefinitionError:
        return True
    return False


@pytest.mark.parametrize("entry", [None, *ENTRIES])
def test_an_entry_that_cannot_be_read_hides_nothing_that_lacks_and_invents_nothing(
    entry: tuple[str, str] | None,
) -> None:
    whole = copy.deepcopy(PROFILE)
    section, name = entry or ("blackboard", "unread")
    whole[section][name] = [[1.5]]
    if not is_unread(whole):
        return
    found = legible_profile(whole)
    assert found is not None
    assert [*missing_anyway(MISSION, found, whole)] == []
    if entry != LOST:
        del whole[LOST[0]][LOST[1]]
        found = legible_profile(whole)
        assert found is not None
        assert [each.place for each in missing_anyway(MISSION, found, whole)] == ["/actions/cross"]


@pytest.mark.parametrize("command", ["check", "run", "prove"])
def test_what_a_profile_lacks_is_reported_next_to_what_cannot_be_read(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = copy.deepcopy(PROFILE)
    document["connector"]["kind"] = "locl"
    document["blackboard"]["battery"]["topc"] = "/battery"
    del document["actions"]["cross"]
    document.pop("identity", None)
    path = tmp_path / "robot.json"
    path.write_text(json.dumps(document))
    assert main([command, str(TRACTOR / "mission.json"), "--robot", str(path)]) == 2
    printed = capsys.readouterr().err.splitlines()
    for sentence in (
        "/blackboard/battery/topc: a source has no 'topc'; did you mean 'topic'?",
        "/connector/kind: no connector of kind 'locl'; did you mean 'local'?",
        "/actions/cross: missing; the mission uses it at /states/crossing/action",
    ):
        assert any(line.startswith(f"{path}: {sentence}") for line in printed)
    assert len(printed) == 3 + (command == "check")


@pytest.mark.parametrize("command", ["check", "run", "prove"])
def test_of_a_file_of_another_kind_that_is_all_that_is_reported(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "robot.json"
    other.write_bytes((TRACTOR / "mission.json").read_bytes())
    assert main([command, str(TRACTOR / "mission.json"), "--robot", str(other)]) == 2
    faults = [line for line in capsys.readouterr().err.splitlines() if line.startswith(f"{other}: /")]
    assert len(faults) == 1 and "this is a mission; --robot takes a robot's profile" in faults[0]


@pytest.mark.parametrize("data", [[], "text", None, {"format": 7, "name": 3, "blackboard": 5, "connector": []}])
def test_of_what_is_hardly_a_profile_as_much_is_read_as_there_is(data: Any) -> None:
    found = legible_profile(data)
    assert (found is None) == (not isinstance(data, dict))

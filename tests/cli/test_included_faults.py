# SPDX-License-Identifier: Apache-2.0
"""A fault is reported in the file that its author opens, by every command that refuses a mission for it."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from rai_missions.check import check_file
from rai_missions.cli.main import main
from rai_missions.errors import steps_of

COMMANDS = (("check",), ("prove",), ("run",), ("try", "--terminal"))

INNER = {
    "format": 1, "name": "inner", "initial": "asking",
    "states": {"asking": {"call": "bell", "timeout_s": 1, "transitions": [{"on": "unheard", "to": "rung"}]},
               "rung": {"final": "succeeded"}},
}  # fmt: skip
OUTER = {
    "format": 1, "name": "outer", "initial": "ringing",
    "states": {"ringing": {"mission": "parts/inner.json", "transitions": [{"on": "succeeded", "to": "over"}]},
               "over": {"final": "canceled"}},
}  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_fault_of_an_included_mission_is_reported_in_its_file(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("parts").mkdir()
    Path("parts/inner.json").write_text(json.dumps(INNER))
    Path("outer.json").write_text(json.dumps(OUTER))
    assert main([*command, "outer.json"]) == 2
    printed = "".join(capsys.readouterr())
    assert "parts/inner.json: /states/asking/transitions/0/on: no event or outcome" in printed


def test_what_a_profile_lacks_is_reported_in_the_profile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    inner = json.loads(json.dumps(INNER).replace("unheard", "succeeded"))
    Path("mission.json").write_text(json.dumps(inner))
    Path("robot.json").write_text(json.dumps({"format": 1, "name": "mute", "connector": {"kind": "local"}}))
    assert main(["prove", "mission.json", "--robot", "robot.json"]) == 2
    assert "robot.json: /services/bell: missing" in capsys.readouterr().err


def places_in(file: Path, document: dict[str, Any]) -> list[tuple[str, str]]:
    """The file and the place of each fault of a mission; each place is one that the file has."""
    file.write_text(json.dumps(document))
    found = [(each.file, each.finding.place) for each in check_file(str(file)).findings]
    for name, place in found:
        here = json.loads(Path(name).read_text())
        for step in steps_of(place):
            here = here[int(step)] if isinstance(here, list) else here[step]
    return [(Path(name).name, place) for name, place in found]


def test_a_state_a_key_and_an_invariant_may_have_the_name_of_a_junction(tmp_path: Path) -> None:
    wrong = {"key": "none", "==": 1}
    found = places_in(tmp_path / "outer.json", {
        "format": 1, "name": "outer", "initial": "all",
        "blackboard": {"any": {"type": "integer", "initial": "one"}},
        "invariants": {"all": wrong, "any": {"any": [wrong, {"any": [wrong]}]}},
        "states": {"all": {"transitions": [{"when": wrong, "to": "any"}]}, "any": {"final": "aborted"}},
    })  # fmt: skip
    places = (
        "/invariants/all",
        "/invariants/any/any/0",
        "/invariants/any/any/1/any/0",
        "/states/all/transitions/0/when",
    )
    assert {("outer.json", f"{place}/key") for place in places} | {("outer.json", "/blackboard/any/initial")} == {
        *found
    }


def test_where_an_included_mission_begins_is_a_place_in_its_file(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/inner.json").write_text(json.dumps({**INNER, "initial": "askign"}))
    assert ("inner.json", "/initial") in places_in(tmp_path / "outer.json", OUTER)


def calls_to_check(file: Path, parts: int) -> int:
    """How many functions are called to find a fault in each of so many states and inclusions."""
    states: dict[str, Any] = {f"s{number}": {"mission": "parts/inner.json"} for number in range(parts)}
    file.write_text(json.dumps({"format": 1, "name": "outer", "initial": "s0", "states": states}))
    calls = 0

    def count(frame: object, event: str, argument: object) -> None:
        nonlocal calls
        calls += event == "call"

    sys.setprofile(count)
    try:
        found = check_file(str(file)).findings
    finally:
        sys.setprofile(None)
    assert {each.file for each in found} == {str(file), str(file.parent / "parts/inner.json")}
    assert len(found) >= parts
    return calls


def test_the_place_of_a_fault_is_found_as_fast_among_many(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/inner.json").write_text(json.dumps(INNER))
    calls_to_check(tmp_path / "outer.json", 2)  # what is loaded by the first is not counted
    few, many = (calls_to_check(tmp_path / "outer.json", parts) for parts in (10, 100))
    assert many < 11 * few

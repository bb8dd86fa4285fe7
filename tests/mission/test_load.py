# SPDX-License-Identifier: Apache-2.0
"""What is dumped is loaded again, equal; files are named, bounded and replaced whole."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions import DefinitionError, Mission, UsageError, dump, load
from rai_missions.guards import All, Guard
from rai_missions.states import Compound
from tests.strategies import mission_documents

DATA = Path(__file__).parents[1] / "data"
SHIPPED = sorted((DATA.parents[1] / "missions").glob("*/*.json"))
MISSIONS = [DATA / "tractor_design.json", *(path for path in SHIPPED if "robot" not in path.name)]
SMALL = '{"format": 1, "name": "small", "initial": "a", "states": {"a": {}}}'


@given(document=mission_documents())
def test_what_is_dumped_is_loaded_again_equal(
    document: dict[str, Any], tmp_path_factory: pytest.TempPathFactory
) -> None:
    mission = Mission.model_validate(document)
    file = tmp_path_factory.mktemp("law") / "m.json"
    text = dump(mission, file)
    assert load(file) == mission
    assert dump(load(file)) == text == file.read_text(encoding="utf-8")
    assert list(json.loads(text)["states"]) == list(document["states"])


@pytest.mark.parametrize("file", MISSIONS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_the_shipped_missions_are_dumped_and_loaded_again_equal(file: Path, tmp_path: Path) -> None:
    mission = load(file)
    dump(mission, tmp_path / "again.json")
    assert load(tmp_path / "again.json") == mission


def test_a_dump_begins_with_the_schema_and_ends_with_a_line() -> None:
    text = dump(load(DATA / "tractor_design.json"))
    assert text.startswith('{\n  "$schema": "mission.schema.json",\n  "format": 1,\n  "name": "tractor_orchard",\n')
    assert text.endswith("}\n")
    assert '"timeout_s": 900\n' in text
    assert '"kind": null' not in text


def test_the_words_of_a_kind_come_before_those_of_every_state() -> None:
    state = json.loads(dump(load(DATA / "tractor_design.json")))["states"]["signalling"]
    assert list(state) == ["control", "tree", "entry", "transitions", "timeout_s"]


def test_a_guard_is_dumped_as_it_was_written_and_flat() -> None:
    mission = Mission.model_validate(
        json.loads(SMALL) | {"invariants": {"i": {"all": [{"all": [{"in": "a"}, {"in": "b"}]}, {"not": {"in": "c"}}]}}}
    )
    assert json.loads(dump(mission))["invariants"]["i"] == {"all": [{"in": "a"}, {"in": "b"}, {"not": {"in": "c"}}]}


def test_a_guard_among_guards_of_another_kind_stays_what_it_is() -> None:
    here = [{"in": "a"}, {"in": "b"}]
    made = All.read({"all": [Guard.read({"all": here}), Guard.read({"any": here}), Guard.read({"in": "c"})]})
    assert made == All.read({"all": [*here, {"any": here}, {"in": "c"}]})


def test_schema_and_lists_of_event_names_are_normalised_away(tmp_path: Path) -> None:
    for name, extra in (("a", {"events": ["e"]}), ("b", {"$schema": "x", "events": {"e": {}}})):
        (tmp_path / f"{name}.json").write_text(json.dumps(json.loads(SMALL) | extra))
    assert load(tmp_path / "a.json") == load(tmp_path / "b.json")


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
    (tmp_path / "m.json").write_text(SMALL, encoding="utf-8-sig")
    assert load(tmp_path / "m.json").name == "small"


def test_a_file_is_replaced_whole_and_keeps_its_mode(tmp_path: Path) -> None:
    file = tmp_path / "m.json"
    file.write_text("old")
    file.chmod(0o640)
    dump(Mission.model_validate(json.loads(SMALL)), file)
    assert load(file).name == "small"
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [file]


def test_a_new_file_has_the_permissions_that_the_system_gives_and_no_thread_sees_another_mask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    masks: list[int] = []
    change = os.umask
    monkeypatch.setattr(os, "umask", lambda mask: masks.append(mask) or change(mask))
    before = change(0o027)
    try:
        dump(Mission.model_validate(json.loads(SMALL)), tmp_path / "m.json")
    finally:
        change(before)
    assert stat.S_IMODE((tmp_path / "m.json").stat().st_mode) == 0o640
    assert masks == []


def test_a_dump_that_fails_leaves_the_old_file(tmp_path: Path) -> None:
    (tmp_path / "m.json").mkdir()
    (tmp_path / "m.json" / "kept").write_text("old")
    with pytest.raises(OSError, match=r"m\.json"):
        dump(Mission.model_validate(json.loads(SMALL)), tmp_path / "m.json")
    assert [each.name for each in tmp_path.iterdir()] == ["m.json"]


def test_what_could_not_be_loaded_is_not_dumped() -> None:
    states = {"s0": Compound(initial="s1", states={"s1": {}})}
    for depth in range(60):
        states = {f"t{depth}": Compound(initial=next(iter(states)), states=states)}
    with pytest.raises(DefinitionError, match="more than 100 objects and lists"):
        dump(Mission("deep", initial="t59", states=states))


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("no.json", "there is no file"), ("no.py", "there is no file"), ("m.yaml", "neither .json nor .py")],
)
def test_a_file_that_is_no_mission_is_for_the_caller_to_mend(tmp_path: Path, name: str, sentence: str) -> None:
    with pytest.raises(UsageError, match=sentence):
        load(tmp_path / name)


def test_the_text_of_a_mission_is_no_file_and_its_reader_is_named() -> None:
    text = dump(Mission.model_validate(json.loads(SMALL)))
    with pytest.raises(
        UsageError, match=r"^this is the text of a mission; load takes its file, Mission\.model_validate"
    ):
        load(text)
    assert Mission.model_validate_json(text) == Mission.model_validate(json.loads(SMALL))


def test_ten_thousand_states_are_loaded(tmp_path: Path) -> None:
    transitions = [{"on": "succeeded", "to": "s0"}]
    states = {f"s{number}": {"action": "go", "timeout_s": 5, "transitions": transitions} for number in range(10_000)}
    (tmp_path / "m.json").write_text(json.dumps(json.loads(SMALL) | {"initial": "s0", "states": states}))
    assert len(load(tmp_path / "m.json").states) == 10_000


@given(raw=st.binary(max_size=200))
def test_any_file_is_a_mission_or_a_fault(raw: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("any") / "m.json"
    file.write_bytes(raw)
    with pytest.raises(DefinitionError):
        load(file)

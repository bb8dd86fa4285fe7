# SPDX-License-Identifier: Apache-2.0
"""A mission of which some words cannot be read: the rest is judged, and nothing is found that is not wrong."""

from __future__ import annotations

import copy
import itertools
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rai_missions import agents
from rai_missions.check import check, check_file
from rai_missions.check.rules import check_part
from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError
from rai_missions.mission.legible import legible_part
from rai_missions.mission.mission import Mission
from rai_missions.model.validation_errors import faults_of

ROOT = Path(__file__).parents[2]
SHIPPED = {
    path.parent.name: {key: item for key, item in json.loads(path.read_text()).items() if key != "$schema"}
    for path in sorted(ROOT.glob("missions/*/mission.json"))
}
"""They are free of findings."""
Steps = tuple[str | int, ...]


def places(value: Any, steps: Steps = ()) -> Iterator[Steps]:
    if steps:
        yield steps
    pairs: Any = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for word, item in pairs:
        yield from places(item, (*steps, word))


PLACES = [(name, steps) for name, document in SHIPPED.items() for steps in places(document)]


def broken(name: str, steps: Steps, *, word: bool) -> dict[str, Any] | None:
    """A shipped mission with a value that cannot be read, or an unknown word; None where it can be read still."""
    document = copy.deepcopy(SHIPPED[name])
    holder: Any = document
    for step in steps[:-1]:
        holder = holder[step]
    if not word:
        holder[steps[-1]] = [[1.5]]
    elif isinstance(holder[steps[-1]], dict):
        holder[steps[-1]]["wrogn"] = 1
    try:
        Mission.model_validate(document)
    except ValidationError:
        return document
    return None


def unread_places(document: dict[str, Any]) -> set[str]:
    """The places that a reader of the whole document reports."""
    try:
        Mission.model_validate(document)
    except ValidationError as error:
        return {each.place for each in faults_of(error, Mission, document)}
    return set()


def assert_nothing_is_invented(name: str, steps: Steps, *, word: bool) -> None:
    if (document := broken(name, steps, word=word)) is not None and (part := legible_part(document)) is not None:
        assert check_part(part, document) == (), (name, steps, word)
        assert {each.place for each in part.faults} <= unread_places(document), (name, steps, word)


@given(st.sampled_from(PLACES), st.booleans())
def test_what_cannot_be_read_is_the_cause_of_no_other_finding(place: tuple[str, Steps], word: bool) -> None:
    assert_nothing_is_invented(*place, word=word)


@pytest.mark.drill
def test_what_cannot_be_read_anywhere_is_the_cause_of_no_other_finding() -> None:
    for place in PLACES:
        for word in (False, True):
            assert_nothing_is_invented(*place, word=word)


READINGS: list[tuple[Steps, dict[str, Any], str]] = [
    (
        ("blackboard", "k"),
        {"type": "integer", "sorce": "mission", "initial": 1.5},
        "/blackboard/k/initial: 'initial' does not",
    ),
    (("blackboard", "k"), {"type": "integer", "sorce": "argument", "minimum": 1}, ""),
    (("blackboard", "k"), {"type": "integer", "sorce": "argment", "minimum": 1}, ""),
    (("blackboard", "k"), {"type": "integer", "sorce": "argument", "abut": "k", "initial": 1.5}, ""),
    (
        ("transitions", 0),
        {"on": "go", "after_s": 3, "tto": "end"},
        "/transitions/0: a transition has 'on' or 'after_s'",
    ),
    (("transitions", 0), {"to": "end", "wehn": {"key": "k", "==": 1}}, ""),
]
"""An object with an unknown word, and the fault next to it that is there whatever the word was meant to be."""


@pytest.mark.parametrize(("steps", "item", "fault"), READINGS)
def test_an_unknown_word_hides_no_fault_that_is_there_whatever_it_means(
    steps: Steps, item: dict[str, Any], fault: str
) -> None:
    document = document_of({})
    document["blackboard"] = {"k": {"type": "integer"}}
    document["transitions"] = [{"on": "go", "to": "end"}]
    document[str(steps[0])][steps[1]] = item
    part = legible_part(document)
    assert part is not None
    found = [str(each) for each in part.faults if str(each.place) not in unread_places(document)]
    assert len(found) == bool(fault) and "".join(found).startswith(fault)


def test_a_fault_next_to_an_unknown_word_is_there_once_the_word_is_mended() -> None:
    """Each word of each key of the shipped missions is misspelled, next to words of every other kind of key."""
    keys = [dict(each) for document in SHIPPED.values() for each in document["blackboard"].values()]
    more: list[dict[str, Any]] = [{}, {"initial": 1.5}, {"minimum": 1}, {"max_age_s": 2}, {"fields": {"a": "number"}}]
    for key, other in itertools.product(keys, more):
        document = document_of({})
        document["blackboard"] = {"k": key | other}
        mended = unread_places(document)
        for word in key:
            document["blackboard"]["k"] = {f"{each}x" if each == word else each: v for each, v in (key | other).items()}
            part = legible_part(document)
            assert part is None or {each.place for each in part.faults} <= mended | unread_places(document)


def test_a_comparison_whose_key_cannot_be_read_is_not_taken_for_a_question_about_a_state() -> None:
    guard = {"key": [[1.5]], "in": [1, 4]}
    document = document_of({"transitions": [{"on": "go", "when": guard, "to": "end"}]})
    part = legible_part(document)
    assert part is not None
    assert {each.place for each in part.faults} == unread_places(document)


@given(st.sampled_from([steps for name, steps in PLACES if name == "tractor" and steps[0] == "states"]))
def test_a_misspelled_name_elsewhere_is_found_all_the_same(steps: Steps) -> None:
    document = broken("tractor", steps, word=False)
    if document is None or steps == ("states",):
        return
    document["transitions"] = [*document["transitions"], {"on": "anomaly", "to": "dnoe"}]
    part = legible_part(document)
    assert part is not None
    found = [each for each in check_part(part, document) if each.sentence.startswith("no state 'dnoe'")]
    assert len(found) == part.has_states


@given(st.sampled_from([steps for name, steps in PLACES if name == "tractor" and steps[:2] != ("states", "done")]))
def test_a_final_that_lacks_its_facts_is_found_all_the_same(steps: Steps) -> None:
    document = broken("tractor", steps, word=False)
    if document is None or steps == ("states",):
        return
    del document["states"]["done"]["requires"]
    part = legible_part(document)
    assert part is None or "missing-requires" in {each.rule for each in check_part(part, document)}


def test_errors_are_printed_before_warnings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = copy.deepcopy(SHIPPED["tractor"])
    document["blackboard"]["unused"] = {"type": "number", "initial": 1}
    del document["states"]["done"]["requires"]
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    severities = [each.finding.severity for each in check_file(str(path)).findings]
    assert severities == ["warning", "error"], "the place of the warning is the earlier one"
    assert main(["check", str(path)]) == 2
    first, second, *_ = capsys.readouterr().err.splitlines()
    assert "/states/done" in first
    assert "/blackboard/unused: warning" in second
    main(["check", str(path), "--json"])
    assert [each["severity"] for each in json.loads(capsys.readouterr().out)] == ["error", "warning"]


@pytest.mark.parametrize("events", [list, dict])
@pytest.mark.parametrize("steps", [("events", "anomaly"), ("blackboard", "obstacle"), ("states", "assessing")])
def test_a_name_that_is_none_is_reported_with_the_rest(steps: Steps, events: type, tmp_path: Path) -> None:
    document = copy.deepcopy(SHIPPED["tractor"])
    section, name = steps
    document[section]["Bad-Name"] = document[section].pop(name)
    document["events"] = list(document["events"]) if events is list else document["events"]
    document["transitions"] = [*document["transitions"], {"when": {"in": "crossing"}, "to": "dnoe"}]
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    found = {each.finding.place: each.finding.sentence for each in check_file(str(path)).findings}
    assert "'Bad-Name' is not a name" in found[f"/{section}/Bad-Name"]
    assert "no state 'dnoe'; did you mean 'done'?" in found.values()


def test_a_finding_is_reported_in_the_file_that_is_to_be_mended(tmp_path: Path) -> None:
    inner = {
        "format": 1, "name": "dock",
        "blackboard": {"docked": {"type": "boolean", "source": "robot"},
                       "spare": {"type": "integer", "source": "robot"}},
        "initial": "driving",
        "states": {
            "driving": {"action": "dock", "timeout_s": 9, "achieved": {"key": "docked", "==": True},
                        "transitions": [{"on": "succeeded", "to": "done"}]},
            "done": {"final": "succeeded", "requires": {"key": "docked", "==": True}},
        },
    }  # fmt: skip
    outer = {
        "format": 1, "name": "outer", "initial": "docking",
        "states": {
            "docking": {"mission": "parts/dock.json", "transitions": [{"on": "succeeded", "to": "over"}]},
            "over": {"final": "aborted"},
        },
    }  # fmt: skip
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/dock.json").write_text(json.dumps(inner))
    (tmp_path / "outer.json").write_text(json.dumps(outer))
    checked = check_file(str(tmp_path / "outer.json"))
    found = {(each.file, each.finding.place) for each in checked.findings}
    dock = str(tmp_path / "parts/dock.json")
    assert checked.mission is not None
    assert {(dock, "/blackboard/spare"), (dock, "/states/driving")} <= found
    assert {file for file, _ in found} == {dock}
    assert check(checked.mission)


INNER = {
    "format": 1, "name": "dock",
    "blackboard": {"speed": {"type": "number", "source": "argument", "initial": 1},
                   "docked": {"type": "boolean", "source": "robot"}},
    "events": {"bumped": {}}, "initial": "driving",
    "states": {
        "driving": {"action": "dock", "goal": {"speed": {"from": "speed"}}, "timeout_s": 9,
                    "achieved": {"key": "docked", "==": True},
                    "transitions": [{"on": ["succeeded", "bumped"], "to": "ended"}]},
        "ended": {"final": "aborted"},
    },
}  # fmt: skip
OUTER = {
    "format": 1, "name": "outer", "blackboard": {"there": {"type": "boolean", "source": "robot", "max_age_s": 1}},
    "events": {"hit": {}}, "initial": "docking",
    "states": {
        "docking": {"mission": "dock.json", "with": {"speed": 2, "docked": {"from": "there"}, "bumped": "hit"},
                    "transitions": [{"on": "aborted", "to": "over"}]},
        "over": {"final": "aborted"},
    },
    "invariants": {"dry": {"key": "there", "==": True}},
}  # fmt: skip
UNFIT = {"speed": "fast", "spede": 1, "docked": {"from": "ther"}, "bumped": "hti"}
"""What an inclusion may not be given."""


@pytest.mark.parametrize("unfit", [None, *UNFIT])
def test_a_fault_of_an_inclusion_is_found_whatever_else_cannot_be_read_and_none_is_invented(
    unfit: str | None, tmp_path: Path
) -> None:
    (tmp_path / "dock.json").write_text(json.dumps(INNER))
    path, wrong = tmp_path / "m.json", f"/states/docking/with/{unfit}"
    for steps in places(OUTER):
        document: Any = copy.deepcopy(OUTER)
        if unfit is not None:
            document["states"]["docking"]["with"][unfit] = UNFIT[unfit]
        holder = document
        for step in steps[:-1]:
            holder = holder[step]
        holder[steps[-1]] = [[1.5]]
        if not (unread := unread_places(document)):
            continue
        path.write_text(json.dumps(document))
        found = {each.finding.place for each in check_file(str(path)).findings}
        assert found <= {*unread, wrong}, steps
        names_it = {"there", "hit", "docking"} & {*map(str, steps)}
        assert wrong in found or unfit is None or names_it or len(steps) == 1, steps


def document_of(state: Any) -> dict[str, Any]:
    """A mission with wrong names, and a state that cannot be read."""
    return {
        "format": 1, "name": "m", "initial": "odd", "events": {"go": {}},
        "states": {
            "odd": state,
            "next": {"transitions": [{"on": "goo", "to": "edn"}]},
            "end": {"final": "aborted"},
        },
    }  # fmt: skip


NAMES = {"/states/next/transitions/0/on", "/states/next/transitions/0/to"}
INSIDE = {
    "initial": "x",
    "states": {"x": {"transitions": [{"on": "go", "to": "yy"}]}, "y": {}},
    "transitions": [{"on": "go", "to": "nxet"}],
}


@pytest.mark.parametrize(
    ("state", "sentence", "more"),
    [
        ("drive", """a state is an object, not 'drive'; write {"action": "drive"}, or {} for""", ()),
        ("dock.json", """a state is an object, not 'dock.json'; write {"mission": "dock.json"}, or""", ()),
        (7, "a state is an object, not 7; write {…}", ()),
        ({"parallel": True} | INSIDE, "not true; write it in the place of 'states', without 'initial', or take it away",
         ("/states/odd/states/x/transitions/0/to", "/states/odd/transitions/0/to")),
        ({"parallel": False, "transitions": [{"on": "go", "to": "nxet"}]}, "not false; name them, or take it away",
         ("/states/odd/transitions/0/to",)),
    ],
)  # fmt: skip
def test_a_state_that_is_no_object_or_has_parallel_as_a_flag_hides_no_name(
    state: Any, sentence: str, more: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document_of(state)))
    found = {each.finding.place: each.finding.sentence for each in check_file(str(path)).findings}
    assert sentence in found["/states/odd"]
    assert {*NAMES, *more} == found.keys() - {"/states/odd"}
    assert found["/states/next/transitions/0/to"] == "no state 'edn'; did you mean 'end'?"
    for command in (
        ["run", str(path)],
        ["prove", str(path)],
        ["draw", str(path), "-o", str(tmp_path / "m.svg")],
        ["try", str(path), "--terminal"],
        ["diff", str(path), str(path)],
    ):
        assert main(command) == 2
        printed = capsys.readouterr().err
        assert all(f"{path}: {place}: {found[place]}" in printed for place in found), command


def test_a_mission_that_cannot_be_read_is_reported_whole_to_programs_too(tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document_of("drive")))
    with pytest.raises(DefinitionError) as raised:
        agents.run(path)
    assert {fault.place for fault in raised.value.faults} == {"/states/odd", *NAMES}


def test_a_guard_that_cannot_be_read_hides_no_fault_of_the_decision_around_it(tmp_path: Path) -> None:
    document = {
        "format": 1, "name": "m", "initial": "asking",
        "blackboard": {"battery": {"type": "number", "source": "robot", "max_age_s": 3}},
        "states": {
            "asking": {
                "decision": {
                    "question": "?", "deadline_s": 3, "fallback": "z",
                    "options": {"x": {}, "y": {"when": {"key": "battery", "=<": 0.3}}},
                },
                "transitions": [{"on": "x", "to": "end"}, {"on": "y", "too": "end"}],
            },
            "end": {"final": "aborted"},
        },
    }  # fmt: skip
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    found = {each.finding.place: each.finding.sentence for each in check_file(str(path)).findings}
    assert found.keys() == {
        "/states/asking/decision/fallback",
        "/states/asking/decision/options/y/when/=<",
        "/states/asking/transitions/1/too",
    }
    assert found["/states/asking/decision/fallback"] == "'fallback' names no option: 'z'; there is: x, y"


ASKED: dict[str, Any] = {
    "question": "?", "deadline_s": 3, "ask": ["operatr"], "evidence": ["battry"],
    "options": {"x": {"when": {"key": "battry", "<": 1}}, "y": {"parameters": {"properties": {}}}},
}  # fmt: skip


@pytest.mark.parametrize(
    ("word", "more", "sentence"),
    [
        ("fallback", {"fallback": "z"}, "'fallback' names no option: 'z'"),
        ("fallback", {"fallback": "x"}, "the fallback 'x' has a 'when'"),
        ("fallback", {"fallback": "y"}, "the fallback 'y' takes parameters"),
        ("deadline_s", {"deadline_s": "3"}, "'3' is not a number"),
    ],
)
@pytest.mark.parametrize("is_in_tree", [False, True])
def test_a_wrong_word_of_a_decision_hides_nothing_else_that_is_wrong_in_it(
    word: str, more: dict[str, Any], sentence: str, is_in_tree: bool, tmp_path: Path
) -> None:
    wrong = {"decision": {**ASKED, **more}}
    asking = {"tree": {"sequence": [wrong]}} if is_in_tree else wrong
    document = {
        "format": 1, "name": "m", "initial": "asking",
        "blackboard": {"battery": {"type": "number", "source": "robot", "max_age_s": 3}},
        "states": {"asking": asking, "end": {"final": "aborted"}},
    }  # fmt: skip
    path, at = tmp_path / "m.json", f"/states/asking{'/tree/sequence/0' * is_in_tree}/decision"
    path.write_text(json.dumps(document))
    found = {each.finding.place: each.finding.sentence for each in check_file(str(path)).findings}
    assert sentence in found[f"{at}/{word}"]
    named = (f"{at}/ask/0", f"{at}/evidence/0", f"{at}/options/x/when/key")
    assert set(named) <= found.keys() and "did you mean 'battery'?" in found[named[1]]


def test_an_event_that_is_declared_twice_hides_nothing_else(tmp_path: Path) -> None:
    document = {
        "format": 1, "name": "m", "initial": "here", "events": ["go", "go"],
        "states": {"here": {"transitions": [{"on": "go", "to": "end"}, {"on": "goo", "to": "edn"}]},
                   "end": {"final": "aborted"}},
    }  # fmt: skip
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    found = [each.finding.place for each in check_file(str(path)).findings]
    assert found == ["/events/1", "/states/here/transitions/1/on", "/states/here/transitions/1/to"]

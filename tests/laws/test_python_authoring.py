# SPDX-License-Identifier: Apache-2.0
"""A mission in Python is the one in JSON: as data, checked, drawn, proved and run; each fault has its place."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions import Chart, DefinitionError, Mission, dump, load
from rai_missions.check import check_file
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import MissionError, steps_of
from rai_missions.event import Event
from rai_missions.prove import prove
from tests.laws.drawn import OPTIONS, document, happenings, is_far, robot_facts
from tests.laws.test_included import including
from tests.rigs.authoring import PythonAuthor
from tests.rigs.charts import ScriptedRobot
from tests.strategies import mission_documents
from visualize import draw

Json = dict[str, Any]
MORE_KEYS: Json = {
    "class": {"type": "object", "fields": {"fresh": "boolean", "from": "string"}, "about": "words of Python's"},
    "dock/laps": {"type": "integer", "source": "argument", "minimum": 1, "maximum": 9, "initial": 2},
    "place": {"type": "pose", "frame": "map", "initial": {"x": 1, "y": 2.0, "frame": "map"}, "optional": True},
    "kinds": {"type": "list", "initial": ["log", {"nested": [None, True, 1.0]}]}, "item": {"type": "string"},
}  # fmt: skip
GUARDS: tuple[Json, ...] = (
    {"key": "class.fresh", "==": False}, {"key": "class.from", "!=": 'it\'s "ö"\n'}, {"fresh": "class"},
    {"key": "dock/laps", ">": {"key": "n"}}, {"key": "item", "in": {"key": "kinds"}},
    {"not": {"key": "flag", "==": True}},
    {"not": {"not": {"key": "clear", "==": False}}}, {"all": []}, {"any": [{"any": [{"in": "s1"}, {"in": "s1"}]}]},
    {"near": ["place", "home"], "within_m": 2}, {"key": "place.x", "<=": 1.5},
    {"key": "event.k", "==": [1, {"a": None}]},
    {"held": {"all": [{"key": "flag", "==": True}, {"possible": {"key": "clear", "==": True}}]}, "for_s": 1},
)  # fmt: skip
EFFECTS: tuple[Json, ...] = (
    {"set": "item", "from": "event.why"}, {"set": "kinds", "value": {"from": "stops"}}, {"set": "kinds", "value": [[]]},
    {"set": "class", "value": {"from": "a word", "fresh": True}},
    {"raise": "a", "data": {"k": {"from": "n"}, "l": [1]}},
    {"raise": "b", "after_s": 2, "id": "b/soon"}, {"drop": "b/soon"}, {"say": "\u201eja\u201c"},
    {"call": "horn", "request": {"at": [{"from": "place"}, {"x": {"from": "place.x"}}]}},
)  # fmt: skip


def places(value: Any) -> Iterator[Json]:
    """Each object inside a document, outer before inner."""
    if isinstance(value, dict):
        yield value
    for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from places(each)


def adorned(rng: random.Random, plain: Json) -> Json:
    """The document with words that are seldom drawn, and with defaults that an author need not write."""
    made: Json = json.loads(json.dumps(plain))
    made |= {"about": "drawn", "ready_s": 1.5, "blackboard": made["blackboard"] | MORE_KEYS}
    made["events"] = {name: {"fields": {"k": "integer", "why": "string"}} for name in made["events"]} | {"far/off": {}}
    for each in list(places(made["states"])):
        some = {word: rng.random() < 0.3 for word in ("about", "guard", "do", "asked", "default")}
        for transition in each.get("transitions", ()) if "history" not in each else ():
            transition.update({"about": "why", "internal": rng.random() < 0.5} if some["about"] else {})
            transition.update({"when": rng.choice(GUARDS)} if some["guard"] else {})
            transition.update({"do": [*transition.get("do", []), rng.choice(EFFECTS)]} if some["do"] else {})
        if "question" in each and some["asked"]:
            each |= {"budget": {"calls": 2}, "tools": ["recall"], "evidence": ["n", "place", "class.from"]}
            for name, option in each["options"].items():
                option.update({"confirm": True} if name in OPTIONS[1:] else {})
        if {"sequence", "selector"} & each.keys() and some["default"]:
            each |= {"memory": rng.random() < 0.5, "name": "first, then"}
        if "states" in each and "initial" in each and some["about"]:
            each |= {"about": "a room", "timeout_s": 90, "handover_s": 5.0}
    copied: Json = json.loads(json.dumps(made))
    return copied


def written(document: Json, rng: random.Random) -> Mission:
    """The mission of a document as a program in Python makes it."""
    names: Json = {}
    exec(PythonAuthor(rng).source(document), names)
    mission: Mission = names["mission"]()
    return mission


@given(seed=st.integers(0, 2**32))
def test_a_drawn_mission_in_python_is_the_same_data(seed: int) -> None:
    rng = random.Random(seed)
    drawn = adorned(rng, document(rng, wishes=seed % 3 == 0, trees=seed % 4 == 0))
    mission = Mission.model_validate(drawn)
    assert written(drawn, rng) == mission
    assert dump(written(drawn, rng)) == dump(mission)
    again = json.loads(dump(mission))
    assert dump(written(again, rng)) == dump(mission)


@given(document=mission_documents(), seed=st.integers(0, 2**32))
def test_a_generated_mission_in_python_is_the_same_data(document: Json, seed: int) -> None:
    mission = Mission.model_validate(document)
    assert written(document, random.Random(seed)) == mission
    assert dump(written(document, random.Random(seed))) == dump(mission)


def misspelled(rng: random.Random, made: Json) -> None:
    """Put faults of some kinds into a document, in place: wrong targets, and wrong names deep in guards."""
    for each in list(places(made)):
        if "to" in each and rng.random() < 0.1:
            each["to"] = rng.choice(["s", "nowhere"])
        if "when" in each and "question" not in each and rng.random() < 0.4:
            word = rng.choice(["all", "any"])
            wrong = {word: [{"in": "nowhere"}, {word: [each["when"], {"key": "nn", "<": 1}]}]}
            each["when"] = rng.choice([wrong, {"not": wrong}, {word: [{"key": "flag", "<": 1}]}])
    if rng.random() < 0.5:
        made["invariants"] = {
            "i": rng.choice([{"any": [{"in": "s0"}, {"any": [{"in": "s1"}, {"in": "s0"}]}]}, {"in": "s0"}])
        }


def both(seed: int, folder: Path) -> tuple[Path, Path]:
    """A mission that includes another, in files of both kinds; in some seeds one of the two is at fault."""
    rng = random.Random(seed)
    inner, outer = document(rng), including(rng)
    inner.pop("on_cancel", None)
    outer["states"]["part"] |= {"timeout_s": 30, "entry": [{"log": "in"}]}
    middle = {"name": "middle", "initial": "m", "states": {"m": {"mission": "../inner.json"}}}
    outer["states"]["deep"] = {"mission": "parts/middle.json"}
    if rng.random() < 0.7:
        misspelled(rng, inner)
    if rng.random() < 0.3:
        misspelled(rng, outer)
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts/middle.json").write_text(json.dumps({"format": 1, **middle}))
    (folder / "inner.json").write_text(json.dumps({"format": 1, **inner}))
    outer = Mission.model_validate(outer).written()  # in Python a place is one of the mission
    (folder / "top.json").write_text(json.dumps(outer))
    (folder / "top.py").write_text(PythonAuthor(rng).source(outer), encoding="utf-8")
    return folder / "top.json", folder / "top.py"


def findings(path: Path) -> list[str]:
    """What `check` finds, each with its file and place; the top file without its ending."""
    return [str(each).replace(str(path), "top") for each in check_file(str(path)).findings]


@given(seed=st.integers(0, 2**32))
@settings(max_examples=30)
def test_what_it_includes_is_the_same_and_each_fault_is_in_its_file(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    as_json, as_python = both(seed, tmp_path_factory.mktemp("both"))
    assert findings(as_python) == findings(as_json)
    assert loaded(as_python) == loaded(as_json)


def loaded(path: Path) -> str | list[str]:
    """The mission in a file as text, or what is wrong with it."""
    try:
        return dump(load(path))
    except DefinitionError as error:
        return [str(fault) for fault in error.faults]


def there(document: Any, place: str) -> bool:
    """Whether a pointer leads somewhere."""
    for step in steps_of(place):
        listed = isinstance(document, list) and step.isdecimal() and int(step) < len(document)
        if not listed and not (isinstance(document, dict) and step in document):
            return False
        document = document[int(step) if listed else step]
    return True


@given(seed=st.integers(0, 2**32))
@settings(max_examples=30)
def test_a_fault_is_at_a_place_that_its_file_has(seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Next to words that cannot be read, too."""
    rng, (top, _) = random.Random(seed), both(seed, tmp_path_factory.mktemp("there"))
    if rng.random() < 0.5:
        alone = adorned(rng, document(rng))
        misspelled(rng, alone)
        if rng.random() < 0.5:
            rng.choice(list(places(alone["states"])))["timout_s"] = 1
        top.write_text(json.dumps(alone))
    for file, finding in check_file(str(top)).findings:
        assert there(json.loads(Path(file).read_text(encoding="utf-8")), finding.place), finding


def test_faults_of_what_a_mission_in_python_includes_are_in_the_files_to_mend(tmp_path: Path) -> None:
    """With a behaviour in Python too, which no JSON has."""
    part = {"format": 1, "name": "part", "initial": "a", "states": {"a": {"mission": "leaf.json"}}}
    leaf = {
        "format": 1, "name": "leaf", "blackboard": {"n": {"type": "integer", "initial": 0}},
        "initial": "b", "states": {"b": {"transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}},
        "transitions": [{"when": {"key": "n", "==": "x"}, "to": "over"}], "invariants": {"i": {"in": "c"}},
    }  # fmt: skip
    (tmp_path / "parts").mkdir()
    for name, made in (("part", part), ("leaf", leaf)):
        (tmp_path / f"parts/{name}.json").write_text(json.dumps(made))
    (tmp_path / "top.py").write_text(
        "from rai_missions import Mission, On\nfrom rai_missions.states import Include, Tree\n"
        "def live(): ...\n"
        "mission = Mission('top', initial='p', states={'t': Tree(live), 'p': Include('parts/part.json', transitions=["
        "On('gone', to='t')])})\n"
    )
    found = {str(each).partition(": ")[0::2] for each in check_file(str(tmp_path / "top.py")).findings}
    places = {(Path(file).relative_to(tmp_path).as_posix(), text.partition(": ")[0]) for file, text in found}
    assert places >= {
        ("top.py", "/states/p/transitions/0/on"),
        ("parts/leaf.json", "/states/b/transitions/0/on"),
        ("parts/leaf.json", "/transitions/0/when/key"),
        ("parts/leaf.json", "/invariants/i/in"),
    }


def results(mission: Mission, path: Path, seed: int) -> Iterator[str]:
    """What becomes of a mission: its pages, its proof, and a walk."""
    rng = random.Random(seed)
    for ending in ("dot", "html", "md"):
        draw(mission, path.with_suffix(f".{ending}"))
        yield path.with_suffix(f".{ending}").read_text(encoding="utf-8")
    try:
        yield repr(prove(mission, CompiledTrees(), most=200, work=2000))
    except MissionError as error:
        yield str(error)
    script, robot = happenings(rng), robot_facts(rng)
    chart, scripted = (
        Chart(mission, CompiledTrees(), robot_facts=robot, named={"is_far": is_far}),
        ScriptedRobot("agent"),
    )
    for happening in (None, *script):
        event = Event("start", 0.0, {}, "command") if happening is None else scripted.event(*happening)
        yield repr(scripted.follow(chart.start(0.0) if happening is None else chart.send(event)))


@given(seed=st.integers(0, 2**32))
@settings(max_examples=8)
def test_its_pages_its_proof_and_its_walks_are_the_same(seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    as_json, as_python = both(seed, tmp_path_factory.mktemp("both"))
    try:
        missions = [load(as_json), load(as_python)]
    except DefinitionError:
        return
    one, other = (list(results(mission, as_json.with_name("page"), seed)) for mission in missions)
    assert one == other

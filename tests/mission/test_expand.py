# SPDX-License-Identifier: Apache-2.0
"""An included mission becomes a compound state: its names are private, its meaning stays."""

from __future__ import annotations

import json
import typing
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given

from rai_missions import DefinitionError, Mission, dump, load
from rai_missions.guards import Guard
from rai_missions.keys import Key
from rai_missions.mission import include
from rai_missions.mission.mission import EventSpec
from rai_missions.model import Json, MissionModel
from rai_missions.model.fields import NAME, PATH_PATTERN
from rai_missions.model.references import fields_of
from rai_missions.runtime.arguments import accepted
from rai_missions.states import Compound, DecisionSpec, Option, State, Transition
from rai_missions.states.tree import TreeNode
from tests.strategies import mission_documents

DOCK: dict[str, Any] = {
    "format": 1,
    "name": "dock",
    "about": "Drive to the dock.",
    "blackboard": {
        "pose": {"type": "pose", "source": "robot", "max_age_s": 1},
        "target": {"type": "pose", "source": "argument"},
        "tries": {"type": "integer", "source": "mission", "initial": 0},
        "limit": {"type": "integer", "source": "argument", "initial": 3},
        "charging": {"type": "boolean", "source": "robot", "max_age_s": 5},
    },
    "events": {"bumped": {}, "lost": {}},
    "initial": "approach",
    "states": {
        "approach": {
            "action": "go_to",
            "goal": {"pose": {"from": "target"}, "speed": 1},
            "achieved": {"near": ["pose", "target"], "within_m": 0.5},
            "transitions": [
                {"on": ["succeeded", "bumped"], "to": "asking"},
                {"on": "lost", "when": {"key": "event.by_m", ">": {"key": "limit"}}, "to": "failed"},
                {"on": "*", "do": [{"set": "tries", "add": 1}, {"raise": "lost", "after_s": 2, "id": "soon"}]},
            ],
            "exit": [{"drop": "soon"}, {"call": "horn", "request": {"times": {"from": "tries"}}}],
        },
        "asking": {
            "decision": {
                "question": "Again?",
                "evidence": ["pose"],
                "options": {"again": {}, "stop": {"when": {"fresh": "pose"}}},
            },
            "transitions": [{"on": "again", "to": "looking"}, {"on": "stop", "to": "failed"}],
        },
        "looking": {
            "tree": {"sequence": [{"check": {"key": "charging", "==": True}}, {"set": "tries", "from": "limit"}]},
            "transitions": [{"on": "succeeded", "of": "looking", "to": "docked"}],
        },
        "docked": {"final": "succeeded", "requires": {"key": "charging", "==": True}},
        "failed": {"final": "failed"},
    },
    "transitions": [{"when": {"all": [{"key": "tries", ">": 5}, {"not": {"in": "approach"}}]}, "to": "failed"}],
    "invariants": {"slow": {"key": "tries", "<": 9}},
}
TOP: dict[str, Any] = {
    "format": 1,
    "name": "top",
    "blackboard": {
        "place": {"type": "pose", "source": "robot", "max_age_s": 1},
        "station": {"type": "pose", "source": "argument"},
    },
    "events": {"bumper": {}},
    "initial": "dock",
    "states": {
        "dock": {
            "mission": "dock.json",
            "with": {"pose": {"from": "place"}, "target": {"from": "station"}, "limit": 7, "bumped": "bumper"},
            "control": "autonomy",
            "timeout_s": 60,
            "transitions": [{"on": "succeeded", "to": "end"}],
        },
        "end": {"final": "aborted"},
    },
}


def written(folder: Path, **documents: Any) -> Path:
    """The documents as files; the path of `top`."""
    for name, document in documents.items():
        (folder / f"{name}.json").write_text(json.dumps(document))
    return folder / "top.json"


def faults_in(file: Path) -> list[str]:
    with pytest.raises(DefinitionError) as refused:
        load(file)
    assert refused.value.source == str(file)
    return [str(fault) for fault in refused.value.faults]


def test_an_inclusion_becomes_a_compound_state_with_private_names(tmp_path: Path) -> None:
    mission = load(written(tmp_path, top=TOP, dock=DOCK))
    dock = json.loads(dump(mission))["states"]["dock"]
    no_longer = [{"not": {"in": "dock/docked"}}, {"not": {"in": "dock/failed"}}]
    assert {word: value for word, value in dock.items() if word != "states"} == {
        "about": "Drive to the dock.",
        "control": "autonomy",
        "timeout_s": 60,
        "initial": "dock/approach",
        "transitions": [
            {"on": "succeeded", "to": "end"},
            {
                "when": {"all": [{"key": "dock/tries", ">": 5}, {"not": {"in": "dock/approach"}}, *no_longer]},
                "to": "dock/failed",
                "internal": True,
            },
        ],
    }
    approach, asking, looking, docked, failed = dock["states"].values()
    assert list(dock["states"]) == ["dock/approach", "dock/asking", "dock/looking", "dock/docked", "dock/failed"]
    assert approach == {
        "action": "go_to",
        "goal": {"pose": {"from": "station"}, "speed": 1},
        "achieved": {"near": ["place", "station"], "within_m": 0.5},
        "exit": [{"drop": "dock/soon"}, {"call": "horn", "request": {"times": {"from": "dock/tries"}}}],
        "transitions": [
            {"on": ["succeeded", "bumper"], "to": "dock/asking"},
            {"on": "dock/lost", "when": {"key": "event.by_m", ">": {"key": "dock/limit"}}, "to": "dock/failed"},
            {
                "on": ["bumper", "dock/lost"],
                "do": [{"set": "dock/tries", "add": 1}, {"raise": "dock/lost", "after_s": 2, "id": "dock/soon"}],
            },
        ],
    }
    assert asking["decision"]["evidence"] == ["place"]
    assert asking["decision"]["options"] == {"again": {}, "stop": {"when": {"fresh": "place"}}}
    assert asking["transitions"] == [{"on": "again", "to": "dock/looking"}, {"on": "stop", "to": "dock/failed"}]
    assert looking["tree"] == {
        "sequence": [{"check": {"key": "dock/charging", "==": True}}, {"set": "dock/tries", "from": "dock/limit"}]
    }
    assert looking["transitions"] == [{"on": "succeeded", "of": "dock/looking", "to": "dock/docked"}]
    assert docked == {"final": "succeeded", "requires": {"key": "dock/charging", "==": True}}
    assert failed == {"final": "failed"}


def test_keys_events_and_invariants_join_those_of_the_mission(tmp_path: Path) -> None:
    mission = load(written(tmp_path, top=TOP, dock=DOCK))
    assert list(mission.blackboard) == ["place", "station", "dock/tries", "dock/limit", "dock/charging"]
    assert mission.blackboard["dock/limit"] == Key(int, initial=7)
    assert list(mission.events) == ["bumper", "dock/lost"]
    assert json.loads(dump(mission))["invariants"] == {
        "dock/slow": {"any": [{"not": {"in": "dock"}}, {"key": "dock/tries", "<": 9}]}
    }


def test_what_was_expanded_is_dumped_and_loaded_again_equal(tmp_path: Path) -> None:
    mission = load(written(tmp_path, top=TOP, dock=DOCK))
    dump(mission, tmp_path / "whole.json")
    assert load(tmp_path / "whole.json") == mission


def test_what_with_gives_is_no_argument_of_the_run(tmp_path: Path) -> None:
    limit = {"type": "integer", "source": "argument", "minimum": 1, "maximum": 9}
    dock = DOCK | {"blackboard": DOCK["blackboard"] | {"limit": limit}}
    mission = load(written(tmp_path, top=TOP, dock=dock))
    assert Mission.model_validate(json.loads(dump(mission))) == mission
    with pytest.raises(DefinitionError, match="the mission takes no argument 'dock/limit'"):
        accepted(mission, {"dock/limit": 3}, whole=False)
    top = TOP | {"states": TOP["states"] | {"dock": TOP["states"]["dock"] | {"with": {"limit": 10}}}}
    assert "/states/dock/with/limit: 10 is out of range; it must be from 1 to 9" in faults_in(
        written(tmp_path, top=top)
    )


def test_an_object_that_with_gives_is_an_argument_with_a_value(tmp_path: Path) -> None:
    keys = DOCK["blackboard"] | {"goal": {"type": "object", "source": "argument"}}
    top = TOP | {"states": TOP["states"] | {"dock": TOP["states"]["dock"] | {"with": {"goal": {"far": 3}}}}}
    mission = load(written(tmp_path, top=top, dock=DOCK | {"blackboard": keys}))
    assert mission.blackboard["dock/goal"] == Key(dict, source="argument", initial={"far": 3})


def test_missions_include_missions_that_include_missions(tmp_path: Path) -> None:
    middle = TOP | {"name": "middle"}
    outer = {"format": 1, "name": "outer", "initial": "m", "states": {"m": {"mission": "parts/middle.json"}}}
    (tmp_path / "parts").mkdir()
    written(tmp_path / "parts", middle=middle, dock=DOCK)
    mission = load(written(tmp_path, top=outer))
    names = [name for _, name, _ in mission.walk()]
    assert names[:3] == ["m", "m/dock", "m/dock/approach"]
    assert "m/dock/tries" in mission.blackboard
    assert set(mission.events) == {"m/bumper", "m/dock/lost"}
    dump(mission, tmp_path / "whole.json")
    assert load(tmp_path / "whole.json") == mission


def test_the_same_mission_may_be_included_twice(tmp_path: Path) -> None:
    twice = TOP | {"states": {"one": {"mission": "dock.json"}, "two": {"mission": "dock.json"}}, "initial": "one"}
    mission = load(written(tmp_path, top=twice, dock=DOCK))
    assert {"one/approach", "two/approach"} <= {name for _, name, _ in mission.walk()}


def test_a_python_mission_includes_too(tmp_path: Path) -> None:
    written(tmp_path, dock=DOCK)
    (tmp_path / "top.py").write_text(
        "from rai_missions import Mission\nfrom rai_missions.states import Include\n"
        "def mission() -> Mission:\n    return Mission('top', initial='d', states={'d': Include('dock.json')})\n"
    )
    assert isinstance(load(tmp_path / "top.py").states["d"], Compound)


def test_a_final_waits_as_long_as_its_own_mission_would(tmp_path: Path) -> None:
    mission = load(written(tmp_path, top=TOP, dock=DOCK | {"settle_s": 2}))
    states = json.loads(dump(mission))["states"]["dock"]["states"]
    charging = {"key": "dock/charging", "==": True}
    assert states["dock/docked"] == {"final": "succeeded", "requires": charging, "settle_s": 2}


def test_a_final_in_a_mission_that_waits_no_time_waits_no_time(tmp_path: Path) -> None:
    top = TOP | {"settle_s": 9, "states": {"middle": {"mission": "middle.json"}}, "initial": "middle"}
    middle = TOP | {"name": "middle"}
    for within, dock in ((0, DOCK), (3, DOCK | {"settle_s": 3})):
        mission = load(written(tmp_path, top=top, middle=middle, dock=dock))
        assert mission.state("middle/dock/docked").settle_s == within


@given(inner=mission_documents())
def test_any_mission_may_be_a_part_of_another(inner: Any, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("law")
    top = {"format": 1, "name": "top", "initial": "part", "states": {"part": {"mission": "inner.json"}}}
    mission = load(written(folder, top=top, inner=inner))
    alone = Mission.model_validate(inner)
    renamed = [name for _, name, _ in mission.walk()]
    assert renamed[0] == "part"
    assert renamed[1:] == [f"part/{name}" for _, name, _ in alone.walk()]
    dump(mission, folder / "whole.json")
    assert load(folder / "whole.json") == mission


IN_DOCK = "/states/dock/mission: in 'dock.json', "


@pytest.mark.parametrize(
    ("changes", "dock", "sentence"),
    [
        ({"mission": "dok.json"}, {}, "/states/dock/mission: there is no file 'dok.json'; did you mean 'dock.json'?"),
        (
            {"mission": "sub/part.json"},
            {},
            "/states/dock/mission: there is no file 'sub/part.json'; did you mean 'sub/parts.json'?",
        ),
        (
            {"mission": "/etc/passwd"},
            {},
            "/states/dock/mission: '/etc/passwd' cannot be included; name a .json file relative to this one, with '/'",
        ),
        (
            {"mission": "../outside.json"},
            {},
            "/states/dock/mission: '../outside.json' lies outside the mission's folder; put it inside",
        ),
        (
            {"mission": "link.json"},
            {},
            "/states/dock/mission: 'link.json' lies outside the mission's folder; put it inside",
        ),
        (
            {"mission": "x" * 5000 + ".json"},
            {},
            f"/states/dock/mission: '{'x' * 59}…' cannot be opened; name a .json file",
        ),
        ({"mission": "loop.json"}, {}, "/states/dock/mission: 'loop.json' cannot be opened; name a .json file"),
        (
            {"mission": "dock.py"},
            {},
            "/states/dock/mission: 'dock.py' cannot be included; name a .json file relative to this one, with '/'",
        ),
        ({}, {"initial": 3}, f"{IN_DOCK}/initial: 3 is not text; write a word in quotes"),
        (
            {},
            {"states": {"approach": {"mission": "top.json"}}},
            f"{IN_DOCK}/states/approach/mission: a mission cannot include itself: "
            "top.json → dock.json → top.json; break the circle",
        ),
        (
            {},
            {"invariants": {"soon": {"elapsed_s": 5}}},
            "/states/dock/mission: its invariant 'soon' asks for 'elapsed_s', "
            "which would count from the start of the whole; use a transition with 'after_s'",
        ),
        (
            {"with": {}},
            {"events": {}},
            "/states/dock/mission: its transition /states/approach/transitions/2 is for any event, "
            "and it declares none; drop the transition",
        ),
        (
            {},
            {"blackboard": DOCK["blackboard"] | {"words": {"type": "string", "source": "answer"}}},
            "/states/dock/mission: its key 'words' is written by answers, which know it by that name; "
            'keep the name: "with": {"words": {"from": "words"}}, and declare it in this mission',
        ),
        (
            {"with": {"poes": 1}},
            {},
            "/states/dock/with/poes: 'dock.json' has no key or event 'poes'; did you mean 'pose'?",
        ),
        (
            {"with": {"pose": {"from": "plaec"}}},
            {},
            "/states/dock/with/pose: no key 'plaec'; did you mean 'place'?",
        ),
        (
            {"with": {"tries": {"from": "place"}}},
            {},
            "/states/dock/with/tries: 'place' is of type 'pose', not 'integer'; share a key of that type",
        ),
        (
            {"with": {"target": {"x": {"from": "place.x"}, "y": 0}}},
            {},
            '/states/dock/with/target: a reference inside a value is not followed; share a whole key: {"from": key}',
        ),
        (
            {"with": {"limit": "many"}},
            {},
            "/states/dock/with/limit: 'many' is not of type 'integer'; an integer is like 3",
        ),
        (
            {"with": {"limit": "station"}},
            {},
            "/states/dock/with/limit: 'station' is not of type 'integer'; an integer is like 3; to share the key, "
            'write {"from": "station"}',
        ),
        (
            {"with": {"pose": {"x": 1, "y": 2}}},
            {},
            '/states/dock/with/pose: a key of the robot takes no value; share one of this mission\'s: {"from": key}',
        ),
        ({"with": {"bumped": "bumpr"}}, {}, "/states/dock/with/bumped: no event 'bumpr'; did you mean 'bumper'?"),
        (
            {"with": {"bumped": 5}},
            {},
            "/states/dock/with/bumped: 'bumped' is an event; give the name of one of this mission's, not 5",
        ),
    ],
)
def test_what_cannot_be_included_is_reported(tmp_path: Path, changes: Any, dock: Any, sentence: str) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    written(tmp_path, outside=DOCK)
    (folder / "sub").mkdir()
    (folder / "sub" / "parts.json").write_text("{}", encoding="utf-8")
    (folder / "link.json").symlink_to(tmp_path / "outside.json")
    (folder / "loop.json").symlink_to(folder / "loop.json")
    top = TOP | {"states": TOP["states"] | {"dock": TOP["states"]["dock"] | changes}}
    assert sentence in faults_in(written(folder, top=top, dock=DOCK | dock))


def test_an_option_that_is_an_event_outside_is_refused(tmp_path: Path) -> None:
    top = TOP | {"events": {"bumper": {}, "again": {}}}
    assert faults_in(written(tmp_path, top=top, dock=DOCK)) == [
        "/states/dock/mission: its option 'again' is also an event of this mission; rename one of them"
    ]


@pytest.mark.parametrize(
    ("parameters", "remedy"),
    [
        ({"properties": {"words": {"type": "string"}}}, "rename one of them"),
        ({"properties": {"other": {"type": "string"}}}, ""),
        ({"type": "object"}, "list its 'properties'"),
        ({"type": "object", "additionalProperties": False}, ""),
    ],
)
def test_an_option_that_would_write_a_key_outside_is_refused(
    tmp_path: Path, parameters: dict[str, Any], remedy: str
) -> None:
    asking = json.loads(json.dumps(DOCK["states"]["asking"]))
    asking["decision"]["options"]["again"]["parameters"] = parameters
    words = {"words": {"type": "string", "source": "answer"}}
    dock = DOCK | {"states": DOCK["states"] | {"asking": asking}}
    top = TOP | {"blackboard": TOP["blackboard"] | words}
    file = written(tmp_path, top=top, dock=dock)
    if remedy:
        sentence = f"/states/dock/mission: its option 'again' would write 'words' of this mission; {remedy}"
        assert faults_in(file) == [sentence]
    else:
        assert "words" in load(file).blackboard
    state = TOP["states"]["dock"]
    shared = state | {"with": state.get("with", {}) | {"words": {"from": "words"}}}
    top |= {"states": TOP["states"] | {"dock": shared}}
    assert load(written(tmp_path, top=top, dock=dock | {"blackboard": DOCK["blackboard"] | words}))


def test_a_private_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    top = TOP | {"blackboard": TOP["blackboard"] | {"dock/tries": {"type": "string"}}}
    assert faults_in(written(tmp_path, top=top, dock=DOCK)) == [
        "/states/dock/mission: it brings 'dock/tries', which this mission has itself; rename that"
    ]


def test_the_faults_of_all_inclusions_are_reported_at_once(tmp_path: Path) -> None:
    states = {"a": {"mission": "no.json"}, "b": {"states": {"c": {"mission": "bad.json"}}, "initial": "c"}}
    file = written(tmp_path, top=TOP | {"initial": "a", "states": states}, bad={"name": 1})
    assert [line.partition(": ")[0] for line in faults_in(file)] == [
        "/states/a/mission",
        *["/states/b/states/c/mission"] * 3,
    ]


@pytest.mark.parametrize(("levels", "leaf"), [(14, {"initial": "B"}), (40, {})])
def test_a_file_at_fault_is_reported_once_however_many_ways_lead_to_it(
    tmp_path: Path, levels: int, leaf: dict[str, Any]
) -> None:
    for depth in range(levels):
        states = {name: {"mission": f"m{depth + 1}.json"} for name in "ab"}
        written(tmp_path, **{f"m{depth}": {"format": 1, "name": "m", "initial": "a", "states": states}})
    last = {"format": 1, "name": "m", "initial": "a", "states": {"a": {}}}
    written(tmp_path, **{f"m{levels}": last | leaf})
    faults, why = faults_in(tmp_path / "m0.json"), "'B' is not a name" if leaf else "more than 16 missions inside each"
    assert [why in each for each in faults] == [True] * (1 if leaf else 2)  # that of the leaf; both ways to it
    states = {name: {"mission": f"m{levels}.json"} for name in "ab"}
    mended = {"format": 1, "name": "m", "initial": "a", "states": states | {"c": {"mission": "other.json"}}}
    written(tmp_path, top=mended, other={"format": 1, "name": "m", "initial": "C", "states": {}})
    assert {fault.partition(": ")[0] for fault in faults_in(tmp_path / "top.json")} == (
        {"/states/a/mission", "/states/c/mission"} if leaf else {"/states/c/mission"}
    )


@pytest.mark.parametrize("most", [500, pytest.param(include.MAX_STATES, marks=pytest.mark.drill)])
def test_what_grows_without_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    monkeypatch.setattr(include, "MAX_STATES", most)
    for depth in range(15):
        states = {name: {"mission": f"m{depth + 1}.json"} for name in "abcdefgh"}
        written(tmp_path, **{f"m{depth}": {"format": 1, "name": "m", "initial": "a", "states": states}})
    written(tmp_path, m15={"format": 1, "name": "m", "initial": "a", "states": {"a": {}}})
    assert f"more than {most} states with all that is included" in "".join(faults_in(tmp_path / "m0.json"))


def test_a_mission_that_includes_nothing_has_the_same_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(include, "MAX_STATES", 3)
    states = {name: {"transitions": [{"after_s": 1, "to": "a"}]} for name in "abcd"}
    large = {"format": 1, "name": "large", "initial": "a", "states": states}
    assert faults_in(written(tmp_path, top=large)) == [
        "/states/d: more than 3 states with all that is included; make it smaller"
    ]
    assert len(load(written(tmp_path, top=large | {"states": dict(list(states.items())[:3])})).states) == 3


def test_missions_inside_each_other_are_counted(tmp_path: Path) -> None:
    for depth in range(30):
        states = {"a": {"mission": f"m{depth + 1}.json"}}
        written(tmp_path, **{f"m{depth}": {"format": 1, "name": "m", "initial": "a", "states": states}})
    assert "more than 16 missions inside each other" in faults_in(tmp_path / "m0.json")[0]


NAMES_NOTHING = {
    (DecisionSpec, "options"),
    (DecisionSpec, "ask"),
    (DecisionSpec, "fallback"),
    (DecisionSpec, "tools"),
    (Option, "parameters"),
    (Mission, "name"),
    (Mission, "blackboard"),
    (Mission, "events"),
    (Mission, "initial"),
    (Mission, "states"),
    (Mission, "invariants"),
    (Mission, "on_cancel"),
    (Key, "initial"),
    (Key, "fields"),
}
"""Fields of names that stay as they are, or that the expansion itself takes care of."""
SERVED = {"action", "call", "publish", "named", "then", "factory"}
"""Words for what the profile or the program has, and a decision's own options."""


def of_models() -> set[type[MissionModel]]:
    found: set[type[MissionModel]] = {Mission, EventSpec, Key}
    rest: list[type[MissionModel]] = [MissionModel]
    while rest:
        rest += (inner := rest.pop().__subclasses__())
        found |= {kind for kind in inner if kind.__module__.startswith(("rai_missions.guards", "rai_missions.states"))}
        found |= {kind for kind in inner if kind.__module__ == "rai_missions.states.effects"}
    return found


def may_name(annotation: Any) -> bool:
    """Whether a field's type is a name, a path or a template, or holds one."""
    if annotation is Any:
        return True
    pattern = getattr(annotation, "pattern", None) or next(
        (getattr(each, "pattern", None) for each in getattr(annotation, "metadata", ())), None
    )
    if pattern in (NAME, PATH_PATTERN) or (pattern and pattern.startswith(r"^(\*|")):
        return True
    return any(may_name(each) for each in (*get_args(annotation), *getattr(annotation, "__metadata__", ())))


def test_every_field_that_can_name_something_reports_what_it_names() -> None:
    forgotten = {
        (kind.__name__, field)
        for kind in of_models()
        for field, info in typing.cast("dict[str, Any]", kind.model_fields).items()
        if (may_name(info.annotation) or any(may_name(each) for each in info.metadata))
        and field not in {use.name for use in fields_of(kind)}
        and (kind, field) not in NAMES_NOTHING
        and field not in SERVED
    }
    assert forgotten == set()
    assert {Guard, State, Transition, TreeNode} <= of_models() and Json is not None

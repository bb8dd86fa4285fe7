# SPDX-License-Identifier: Apache-2.0
"""Items of lists that are left open until a rule looks: a proof with them, and with each item chosen as a whole."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from rai_missions.journal import Header
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove, record
from rai_missions.prove.abstraction import open_world
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import RecordingSpace

Json = dict[str, Any]
ENDS = ["succeeded", "failed", "timed_out", "rejected", "unverified"]
MOST, WORK = 1_200, 30
GUARDS: tuple[Json, ...] = (
    {"key": "item.heavy", "==": True}, {"key": "item.kind", "in": ["box", "bag"]}, {"key": "item.kind", "==": "box"},
    {"key": "item.tries", ">": 1}, {"fresh": "item.kind"}, {"key": "door", "==": {"key": "item.kind"}},
    {"key": "count", "<": 2}, {"not": {"key": "item.heavy", "==": True}}, {"key": "item.tries", "<": {"key": "most"}},
)  # fmt: skip
SETS: tuple[Json, ...] = (
    {"set": "count", "add": 1}, {"set": "count", "value": 0}, {"set": "kept", "from": "item.kind"},
)  # fmt: skip


def drawn(seed: int) -> Mission:
    """A list whose states look at fields of its items, and a break from which a history leads back."""
    r = random.Random(seed)
    kinds = r.sample(GUARDS, 3)

    def guard(depth: int = 1) -> Json:
        if depth and r.random() < 0.4:
            return {r.choice(["all", "any"]): [guard(0), guard(0)]}
        return dict(r.choice(kinds))

    def moves(*names: str, many: int = 2) -> list[Json]:
        return [
            {"when": guard(), "to": r.choice(names), **({"do": [dict(r.choice(SETS))]} if r.random() < 0.4 else {})}
            for _ in range(r.randint(0, many))
        ]

    looks = {"transitions": [*moves("work", "next", many=2), {"after_s": 1, "to": r.choice(["work", "next"])}]}
    work: Json = {
        "action": "drive", "goal": {"what": {"from": "item.kind"}}, "timeout_s": 9,
        "transitions": [{"on": ENDS[:4], "when": guard(), "to": r.choice(["look", "next", "sort"])},
                        {"on": ENDS[:4], "to": "next"}],
    }  # fmt: skip
    sort = {"transitions": [*moves("next", "fail", many=2), {"after_s": 2, "to": "next"}]}
    states: Json = {
        "look": looks, "work": work, "sort": sort, "fail": {"final": "failed"}, "next": {"final": "succeeded"},
        "back": {"history": r.choice(["deep", "shallow"])},
    }  # fmt: skip
    after: list[Json] = [
        {"on": "halt", "to": "rest"},
        {"on": ["succeeded", "failed"], "to": r.choice(["over", "again"])},
    ]
    return Mission.model_validate({
        "format": 1, "name": "drawn", "initial": "going", "events": {"halt": {}, "go": {}},
        "blackboard": {
            "items": {"type": "list", "source": "argument"},
            "item": {"type": "object", "fields": {"heavy": "boolean", "kind": "string", "tries": "integer"}},
            "door": {"type": "string", "source": "robot", "optional": True},
            "most": {"type": "integer", "source": "argument", "minimum": 1, "maximum": 2, "initial": 1},
            "kept": {"type": "string"}, "count": {"type": "integer", "initial": 0},
        },
        "states": {
            "going": {"each": "items", "as": "item", "initial": r.choice(["look", "work"]), "states": states,
                      "transitions": after},
            "rest": {"transitions": [{"on": "go", "to": "back"}, *moves("over", many=1), {"after_s": 9, "to": "over"}]},
            "again": {"transitions": [{"on": "go", "to": "going"}, {"after_s": 9, "to": "over"}]},
            "over": {"final": "aborted"},
        },
        "invariants": {"asked": {"not": {"all": [{"in": "work"}, guard(0)]}}} if r.random() < 0.5 else {},
    })  # fmt: skip


def explored(mission: Mission, *, is_open: bool) -> RecordingSpace:
    with pytest.MonkeyPatch.context() as patch:
        if not is_open:
            patch.setattr(open_world, "open_lists", lambda *given: {})
        space = RecordingSpace(Environment(mission, is_calm=True), MOST, WORK)
        space.explore()
    return space


def hold_against_whole_items(seed: int) -> tuple[int, int]:
    mission = drawn(seed)
    few, every = explored(mission, is_open=True), explored(mission, is_open=False)
    assert few.environment.world.items.keys
    if not every.is_whole:
        return 0, 0
    assert few.is_whole
    assert (few.seen, {*few.ends.values()}) == (every.seen, {*every.ends.values()})
    assert (few.findings.taken, few.findings.entered) == (every.findings.taken, every.findings.entered)
    assert few.findings.flaws.keys() == every.findings.flaws.keys()
    for name, flaw in few.findings.flaws.items():
        assert len(few.path(flaw.state)) == len(every.path(every.findings.flaws[name].state))
    return few.states, every.states


@pytest.mark.parametrize("seed", [0, 1, 10, 14])
def test_open_items_lead_where_whole_ones_lead(seed: int) -> None:
    assert hold_against_whole_items(seed) > (0, 0)


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, 4, 5, 8, 9, 13])
def test_open_items_of_more_missions_lead_where_whole_ones_lead(seed: int) -> None:
    hold_against_whole_items(seed)


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(20, 200))
def test_open_items_lead_where_whole_ones_lead_however_often_it_is_tried(seed: int) -> None:
    hold_against_whole_items(seed)


def test_a_refutation_begins_with_the_items_that_its_steps_have_found(tmp_path: Path) -> None:
    count, heavy = {"key": "count", "==": 1}, {"key": "item.heavy", "==": True}
    document: Json = drawn(0).model_dump(mode="json")
    document["states"]["going"]["initial"] = "look"
    document["states"]["going"]["states"]["look"] = {
        "transitions": [{"when": {"key": "item.heavy", "==": False}, "to": "next", "do": [SETS[0]]}]
    }
    document["invariants"] = {"light": {"not": {"all": [{"in": "look"}, count, heavy]}}}
    mission = Mission.model_validate(document)
    (run,) = [run for claim, run in prove(mission).ways.items() if claim == "invariants"]
    assert run[0].facts["items"] == [{"heavy": False}, {"heavy": True}]
    assert record(tmp_path / "run.journal", Header(dump(mission)), mission, run)

# SPDX-License-Identifier: Apache-2.0
"""Faults of one file are reported together: each that is reported of a change alone is reported of all changes.

Rule: a change is what an author got wrong in a good file, and none of these hides another.
"""

from __future__ import annotations

import copy
from itertools import combinations
from typing import Any, NamedTuple

import pytest

from rai_missions.campaign.file import CampaignFile
from rai_missions.errors import DefinitionError
from rai_missions.gate.config import GateWords
from rai_missions.model.validation_errors import validated
from rai_missions.profile.profile import Robot

Json = dict[str, Any]


class Changed(NamedTuple):
    """A good file, and changes that are faults: the steps to a place → what is written there."""

    kind: Any
    good: Json
    changes: tuple[tuple[tuple[str, ...], Any], ...]


HORN, BATTERY = {"service": "/horn", "type": "std_srvs/srv/Trigger"}, {"topic": "/battery", "type": "x/msg/Y"}
FILES = {
    "gate": Changed(
        GateWords,
        {"commands": [{"topic": "/a", "type": "x/msg/Y"}], "leases": {}},
        (
            (("leases", "agnet"), 1.0),
            (("leases", "nobdy"), 2.0),
            (("leases", "agent"), 0.001),
            (("leases", "operator"), 0.002),
            (("name",), "gate"),
        ),
    ),
    "gate's commands": Changed(
        GateWords,
        {"leases": {}},
        ((("commands",), [{"topic": each, "type": "x/msg/Y"} for each in ("/a", "/a", "/b", "/b")]),),
    ),
    "campaign": Changed(
        CampaignFile,
        {
            "name": "c",
            "mission": "m.json",
            "robot": "r.json",
            "decision": "d",
            "models": ["rules", "openai:x"],
            "scenes": {"world": "orchard", "seeds": [1]},
            "prices": {},
            "rates": {},
            "scripts": {},
            "budget": {},
        },
        (
            (("embodiments",), ["none", "nne", "non", "none"]),
            (("orders",), ["written", "written"]),
            (("prices", "opnai:x"), {}),
            (("prices", "opena:x"), {}),
            (("scripts", "rule"), {"*": "stop"}),
            (("rates", "opnai"), {}),
            (("rates", "opena"), {}),
        ),
    ),
    "campaign's prices": Changed(
        CampaignFile,
        {
            "name": "c",
            "mission": "m.json",
            "robot": "r.json",
            "decision": "d",
            "models": ["openai:x", "openai:y"],
            "scenes": {"world": "orchard", "seeds": [1]},
            "budget": {},
        },
        ((("budget", "money"), 1), (("embodiments",), ["nne"]), (("retries",), 11)),
    ),
    "campaign's scenes": Changed(
        CampaignFile,
        {
            "name": "c",
            "mission": "m.json",
            "robot": "r.json",
            "decision": "d",
            "models": ["rules"],
            "scenes": {"world": "orchard", "seeds": [1]},
        },
        (
            (("scenes", "given"), [{"scene": each, "kind": "x", "seed": 1} for each in ("a", "a", "b", "b")]),
            (("scenes", "count"), 3),
            (("embodiments",), ["nne"]),
            (("models",), ["rules", "rules"]),
            (("budget",), {"calls": 0}),
        ),
    ),
    "profile": Changed(
        Robot,
        {
            "name": "r",
            "services": {"horn": HORN},
            "control": {},
            "events": {},
            "actions": {},
            "blackboard": {},
            "conversation": {"may": {}},
        },
        (
            (("control", "agnet"), HORN),
            (("control", "operater"), HORN),
            (("conversation", "may", "persn"), ["stop"]),
            (("conversation", "may", "viewr"), ["stop"]),
            (("actions", "go"), {"start": "/go", "type": "x/action/Y"}),
            (("blackboard", "at_home"), {**BATTERY, "every_s": 2, "request": {"a": 1}, "json": True, "as": "pose"}),
            (("events", "hit"), {"posted": True, "topic": "/hit", "during": "go"}),
        ),
    ),
    "profile's rest": Changed(
        Robot,
        {"name": "r", "events": {}},
        (
            (("events", "a"), {**BATTERY, "during": "go"}),
            (("events", "b"), {**BATTERY, "during": "stay"}),
        ),
    ),
}


def faults(file: Changed, changes: Any) -> set[str]:
    data = copy.deepcopy(file.good)
    for steps, written in changes:
        inside = data
        for step in steps[:-1]:
            inside = inside.setdefault(step, {})
        inside[steps[-1]] = copy.deepcopy(written)
    try:
        validated(file.kind, data)
    except DefinitionError as error:
        return {str(each) for each in error.faults}
    return set()


MORE_THAN_ONE = {
    ("gate's commands", 0): 2, ("campaign", 0): 3, ("campaign's scenes", 0): 3,
    ("campaign's prices", 0): 2, ("profile", 4): 2, ("profile", 5): 3, ("profile", 6): 2,
}  # fmt: skip
"""File, number of a change → how many faults it is."""


@pytest.mark.parametrize("what", FILES)
def test_all_that_is_wrong_with_a_file_is_reported_at_once(what: str) -> None:
    file = FILES[what]
    alone = [faults(file, [change]) for change in file.changes]
    assert not faults(file, [])
    assert [len(each) for each in alone] == [MORE_THAN_ONE.get((what, at), 1) for at in range(len(alone))]
    for at in combinations(range(len(alone)), 2):
        assert faults(file, [file.changes[each] for each in at]) >= set.union(*(alone[each] for each in at))
    assert faults(file, file.changes) >= set.union(*alone)

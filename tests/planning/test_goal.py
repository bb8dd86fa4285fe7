# SPDX-License-Identifier: Apache-2.0
"""Goals are a closed list of predicates: what is not declared is refused, with its place and a remedy."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest

from rai_missions.errors import DefinitionError
from rai_missions.planning import Goal, Refusal, goal_schema, read_goal

EVERY = {"all": [
    {"on": ["a", "desk"]}, {"on": ["b", "a"]}, {"at": "c", "x": 0.5, "y": -0.1}, {"in": ["d", "tray"]},
    {"left_of": ["a", "c"], "gap_m": 0.05}, {"left_of": ["d", "c"]}, {"next_to": ["a", "c"]},
    {"grouped": ["a", "b", "c"]}, {"apart": ["c", "d"]}, {"swapped": ["c", "d"]},
    {"behind": ["a", "c"], "gap_m": 0.05}, {"behind": ["d", "c"]}, {"between": ["a", "c", "d"]},
    {"shifted": "c", "dx": 0.0, "dy": 0.1},
]}  # fmt: skip


def test_a_goal_is_written_as_it_was_read() -> None:
    goal = read_goal(EVERY)
    assert isinstance(goal, Goal)
    assert goal.written() == EVERY
    assert goal.things() == ("a", "b", "c", "d", "tray")


def test_a_refusal_is_read_as_one() -> None:
    assert read_goal({"refused": "absent", "about": "no lemon"}) == Refusal("absent", "no lemon")


def test_the_schema_takes_what_is_read() -> None:
    schema = goal_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    for each in (EVERY, {"refused": "absent", "about": "no lemon"}):
        jsonschema.validate(each, schema)


@pytest.mark.parametrize(
    ("predicate", "sentence"),
    [
        ({"on": ["a", "a"]}, "/all/0/on: 'a' is named twice; a relation is between different things"),
        ({"on": ["desk", "a"]}, "/all/0/on: 'desk' carries all things and is none of them; only 'on' may have it, as "
                                "its second name"),
        ({"next_to": ["a", "desk"]}, "/all/0/next_to: 'desk' carries all things and is none of them; only 'on' may "
                                     "have it, as its second name"),
        ({"above": ["a", "b"]}, "/all/0: no predicate is written ['above']; there is: apart, at, behind, between, "
                                "grouped, in, left_of, next_to, on, shifted, swapped"),
        ({"on": ["a", "b"], "in": ["a", "b"]}, "/all/0: a predicate is one thing, this is 2: on, in; keep one"),
        ({"at": "a", "x": "1", "y": 0}, "/all/0/x: '1' is not a number; write one, without quotes"),
        ({"at": "a", "x": 50, "y": 0}, "/all/0/x: 50 is too large; it must be 10 or less"),
        ({"left_of": ["a", "b"], "gap": 1}, "/all/0/gap: a predicate with 'left_of' has no 'gap'; did you "
                                            "mean 'gap_m'?"),
    ],
)  # fmt: skip
def test_what_is_not_declared_is_refused(predicate: dict[str, Any], sentence: str) -> None:
    with pytest.raises(DefinitionError) as error:
        read_goal({"all": [predicate]})
    assert str(error.value) == sentence


@pytest.mark.parametrize(
    "data", [None, [], {}, {"all": []}, {"all": {}}, {"refused": 1}, {"all": EVERY["all"], "x": 1}]
)
def test_what_is_no_goal_is_refused(data: Any) -> None:
    with pytest.raises(DefinitionError):
        read_goal(data)

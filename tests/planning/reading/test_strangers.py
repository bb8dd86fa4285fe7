# SPDX-License-Identifier: Apache-2.0
"""Requests of strangers, who had not seen the grammar: how many are read right, and what other talk becomes.

Every other sentence was read, the first of each two; the rest was only counted. Those about boxes are left out: at the
desk there is a tray and a bin.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.planning import Goal
from rai_missions.planning.reading import reading_of
from tests.planning.scenes import scene, thing

STORED = Path(__file__).parents[2] / "conversation/data/strangers.json"
SETS = {who: kinds["desk"] for who, kinds in json.loads(STORED.read_text(encoding="utf-8")).items()}
SEEN = scene(
    *(
        thing(f"{colour}_cube", x, y, colour=colour)
        for colour, x, y in (("red", 0.4, 0.1), ("green", 0.4, -0.1), ("blue", 0.5, 0.0), ("yellow", 0.5, 0.2))
    ),
    thing("carrot", 0.6, 0.1),
    thing("apple", 0.6, -0.1, colour="green"),
    thing("tomato", 0.35, -0.2, colour="red"),
)
NONE, RELATION = "none", re.compile(r"(\w+) (on|next to) (\w+)")
LEAST = {("first", "en"): (9, 8, 4, 3), ("second", "en"): (9, 3, 4, 4), ("second", "de"): (4, 4, 4, 1)}
"""Requests that are read right, of the half that was read and of the other; then other talk that becomes no goal."""


def named(word: str) -> str:
    return word if word in ("carrot", "apple", "tomato") else f"{word}_cube"


def wanted(expected: str) -> frozenset[tuple[str, ...]]:
    """The end that a description has; empty for none, and for one that this desk cannot have."""
    if expected.startswith("swap "):
        return frozenset({("swapped", *sorted(map(named, expected.split()[1:])))})
    found = RELATION.findall(expected)
    pairs = ((relation, [named(one), named(other)]) for one, relation, other in found)
    each = (("on", *pair) if relation == "on" else ("next_to", *sorted(pair)) for relation, pair in pairs)
    return frozenset(each)


def ends(goal: Goal) -> frozenset[tuple[str, ...]]:
    """What a goal asks for; what rests on the desk is where it begins."""
    parts = ((name, names) for part in goal.written()["all"] for name, names in part.items())
    each = ((name, *(names if name == "on" else sorted(names))) for name, names in parts)
    return frozenset(part for part in each if part[-1] != "desk")


def rights(who: str, code: str) -> Iterator[tuple[int, bool, bool]]:
    """Which half a sentence is of, whether it is other talk, and whether it is read right within one yes."""
    for at, (text, expected) in enumerate(SETS[who][code]):
        if expected != NONE and not wanted(expected):
            continue
        found = reading_of(text, SEEN)
        goals = (found.goal,) if found.goal is not None else found.candidates
        is_right = not goals if expected == NONE else wanted(expected) in map(ends, goals)
        yield at % 2, expected == NONE, is_right


@pytest.mark.parametrize(("who", "code"), LEAST)
def test_as_many_requests_of_a_stranger_are_read_right_as_before(who: str, code: str) -> None:
    rows = list(rights(who, code))
    found = [
        sum(is_right for at, none, is_right in rows if at == half and none == is_none)
        for is_none in (False, True)
        for half in (0, 1)
    ]
    assert all(each >= least for each, least in zip(found, LEAST[who, code], strict=True)), found

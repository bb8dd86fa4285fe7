# SPDX-License-Identifier: Apache-2.0
"""A list has an end: rounds that take no time are no cycle, however many; a cycle round a list still is."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.activities import tree_rounds
from rai_missions.engine.semantics import macrostep
from rai_missions.engine.trees import CompiledTrees
from rai_missions.mission.mission import Mission

Json = dict[str, Any]
MOST = 100
"""The limits in these tests."""
WRITES_WHAT_IT_READS: Json = {
    "selector": [
        {"check": {"key": "n", ">": {"key": "item"}}},
        {"sequence": [{"set": "n", "add": 1}, {"wait_s": 5}]},
    ],
    "memory": False,
}
AT_ONCE: dict[str, Json] = {
    "transition": {"transitions": [{"when": {"key": "n", ">=": 0}, "to": "done"}]},
    "tree": {"tree": WRITES_WHAT_IT_READS, "transitions": [{"on": "succeeded", "to": "done"}]},
}
"""What a round does that ends in the instant in which it began."""


@pytest.fixture(autouse=True)
def limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(macrostep, "MOST_MICROSTEPS", MOST)
    monkeypatch.setattr(tree_rounds, "MOST_WAKES", MOST)


def started(inside: Json, items: int, *, after: str = "over", regions: bool = False) -> Chart:
    """A chart that goes over so many items, and then to `after`; if asked, in a region of a parallel state."""
    lists: Json = {
        "each": "items", "as": "item", "initial": "work", "states": {"work": inside, "done": {"final": "succeeded"}},
        "transitions": [] if regions else [{"on": "succeeded", "to": after}],
    }  # fmt: skip
    whole: Json = {"parallel": {"list": lists}, "transitions": [{"on": "succeeded", "to": "over"}]}
    chart = Chart(
        Mission.model_validate(
            {
                "name": "lists",
                "initial": "whole" if regions else "list",
                "blackboard": {
                    "items": {"type": "list", "initial": list(range(items))},
                    "item": {"type": "integer"},
                    "n": {"type": "integer", "initial": 0},
                },
                "states": {**({"whole": whole} if regions else {"list": lists}), "over": {"final": "aborted"}},
            }
        ),
        CompiledTrees(),
    )
    chart.start(0.0)
    return chart


@pytest.mark.parametrize("regions", [False, True])
@pytest.mark.parametrize("inside", AT_ONCE)
def test_a_list_of_any_length_comes_to_its_end_within_an_instant(inside: str, regions: bool) -> None:
    chart = started(AT_ONCE[inside], 3 * MOST, regions=regions)
    assert (chart.outcome, chart.why) == ("aborted", "'over' was reached")
    assert chart.view.board["item"].value == 3 * MOST - 1


@pytest.mark.parametrize("items", [1, 3, 30])
@pytest.mark.parametrize("inside", AT_ONCE)
def test_a_cycle_round_a_list_is_one(inside: str, items: int) -> None:
    assert started(AT_ONCE[inside], items, after="list").cause == "cycle"


@pytest.mark.parametrize("items", [3, 30])
def test_a_cycle_within_a_round_is_one(items: int) -> None:
    inside = {"transitions": [{"when": {"key": "n", ">=": 0}, "to": "work", "do": [{"set": "n", "add": 1}]}]}
    assert started(inside, items).cause == "cycle"


@pytest.mark.parametrize(("entry", "writes"), [
    ([], [("item", 0)]),
    ([{"set": "n", "add": 1}], [("item", 0), ("n", 1)]),
    ([{"set": "item", "value": 7}], [("item", 0), ("item", 7), ("item", 0)]),
])  # fmt: skip
def test_the_first_item_is_written_once_unless_the_entry_overwrites_it(
    entry: list[Json], writes: list[tuple[str, Any]]
) -> None:
    list_state: Json = {"each": "items", "as": "item", "initial": "work", "states": {"work": {}}, "entry": entry}
    chart = Chart(Mission.model_validate({
        "name": "lists", "initial": "list",
        "blackboard": {
            "items": {"type": "list", "initial": [0, 1]},
            "item": {"type": "integer"}, "n": {"type": "integer", "initial": 0},
        },
        "states": {"list": list_state},
    }))  # fmt: skip
    assert list(chart.start(0.0).writes) == writes
    assert chart.active == {"list", "work"}

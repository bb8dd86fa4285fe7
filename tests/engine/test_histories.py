# SPDX-License-Identifier: Apache-2.0
"""Histories as the place where a state begins, and where they lead while there is no memory."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from rai_missions.engine import Chart
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.states import Compound, History
from tests.rigs.charts import mission, sent, transition
from visualize.build import picture

Json = dict[str, Any]


def ways(kind: str, default: str | None, initial: str = "back") -> Mission:
    """`up` begins with its history; inside are `a` and `box` with `b` and `c`."""
    back = {"history": kind, **({"transitions": [{"to": default}]} if default else {})}
    box = {"initial": "b", "states": {"b": {"transitions": [transition("next", "c")]}, "c": {}}}
    inside = {"a": {"transitions": [transition("next", "box")]}, "box": box, "back": back}
    up = {"initial": initial, "states": inside, "transitions": [transition("stop", "off")]}
    return mission({"off": {"transitions": [transition("go", "up"), transition("resume", "back")]}, "up": up})


@pytest.mark.parametrize(
    ("kind", "default", "first", "then"),
    [
        ("deep", "box", ("up", "box", "b"), ("up", "box", "c")),
        ("deep", "c", ("up", "box", "c"), ("up", "box", "c")),
        ("shallow", "box", ("up", "box", "b"), ("up", "box", "b")),
    ],
)
def test_a_state_that_begins_with_its_history_begins_by_its_default_and_continues_where_it_was(
    kind: str, default: str, first: tuple[str, ...], then: tuple[str, ...]
) -> None:
    made = Chart(ways(kind, default))
    made.start()
    assert sent(made, "go").entered == first
    sent(made, "next", "stop")
    assert sent(made, "go").entered == then


def test_a_history_that_is_a_target_leads_by_its_default_while_there_is_no_memory() -> None:
    made = Chart(ways("deep", "c", initial="a"))
    made.start()
    assert sent(made, "resume").entered == ("up", "box", "c")


def test_a_default_is_forgotten_with_the_first_memory_in_every_snapshot() -> None:
    made = Chart(ways("deep", "box"))
    made.start()
    sent(made, "go", "next", "stop")
    again = Chart.restore(made.mission, made.snapshot())
    assert sent(again, "go").entered == ("up", "box", "c")


def test_a_history_that_leads_to_itself_is_refused_with_the_cure() -> None:
    with pytest.raises(UsageError, match="'back' leads to itself where there is no memory; give it a default"):
        Chart(ways("deep", None))


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ({"on": "e", "to": "a"}, "this has on"),
        ({"to": "a", "do": [{"log": "x"}]}, "this has do"),
        ({}, "this has none"),
    ],
)
def test_a_default_only_leads(words: Json, why: str) -> None:
    with pytest.raises(ValidationError, match=f"has only where it leads without memory, 'to'; {why}"):
        History.model_validate({"history": "deep", "transitions": [words]})


def test_python_writes_what_json_reports() -> None:
    inside = {"a": {}, "back": History("shallow", transitions=[{"to": "a"}])}
    assert Compound(initial="back", states=inside).written() == {
        "initial": "back", "states": {"a": {}, "back": {"history": "shallow", "transitions": [{"to": "a"}]}},
    }  # fmt: skip


def test_a_default_is_drawn_as_where_its_history_leads_without_memory() -> None:
    (edge,) = [each for each in picture(ways("deep", "c")).edges if each.source == "back"]
    assert (edge.target, edge.when) == ("c", "without memory")

# SPDX-License-Identifier: Apache-2.0
"""Histories as the place where a state begins, and where they lead while there is no memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from pydantic import ValidationError

from rai_missions.engine import Chart
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
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


def tour(kind: str = "deep", items: Sequence[Any] = (1, 2, 3), **words: Any) -> Mission:
    """A list is gone over in `work`, which `away` leaves and `back` leads back into, to `y` or `z` of the same item."""
    inside = {
        "x": {"transitions": [transition("next", "y")]},
        "y": {"transitions": [transition("next", "z")]},
        "z": {"final": "succeeded"},
    }
    ways, invariants = [transition("succeeded", "over"), *words.pop("rounds", [])], words.pop("invariants", {})
    rounds = {"each": "items", "as": "item", "initial": "x", "states": inside, "transitions": ways}
    work = {"initial": "tour", "states": {"tour": rounds, "over": {}, "kept": {"history": kind}}}
    off = {"transitions": [transition("back", "kept"), transition("inside", "y"), transition("again", "tour")]}
    return mission(
        {"work": {**work, "transitions": [transition("away", "off")]}, "off": off},
        blackboard={"items": {"type": "list", "initial": list(items)}, "item": {"type": "integer"}, **words},
        invariants=invariants,
    )


def item_of(chart: Chart) -> Any:
    return chart.view.board["item"].value


def test_a_deep_history_leads_back_to_the_item_that_was_current() -> None:
    made = Chart(tour())
    made.start()
    sent(made, "next", "next", "next", "away")
    made.write("items", [7, 8, 9])
    assert sent(made, "back").entered == ("work", "tour", "y")
    assert item_of(made) == 2
    sent(made, "next")
    assert (made.active, item_of(made)) == ({"work", "tour", "x"}, 3)


def test_a_list_that_no_history_leads_back_into_begins_with_its_first_item() -> None:
    for kind, event, where in (("shallow", "back", "x"), ("deep", "inside", "y"), ("deep", "again", "x")):
        made = Chart(tour(kind))
        made.start()
        sent(made, "next", "next", "next", "away")
        assert sent(made, event).entered == ("work", "tour", where)
        assert item_of(made) == 1


@pytest.mark.parametrize("kind", ["shallow", "deep"])
def test_a_history_inside_a_list_leads_back_to_its_item(kind: str) -> None:
    ways = tour().model_dump()
    ways["states"]["work"]["states"]["tour"]["states"]["inner"] = {"history": kind}
    ways["states"]["off"]["transitions"].append(transition("into", "inner"))
    made = Chart(Mission.model_validate({**ways, "events": [*ways["events"], "into"]}))
    made.start()
    sent(made, "next", "next", "next", "away", "into")
    assert (made.active, item_of(made)) == ({"work", "tour", "y"}, 2)


def test_an_item_whose_final_was_left_before_the_next_round_is_over_once() -> None:
    way = {"when": {"all": [{"in": "z"}, {"key": "hurried", "==": True}]}, "to": "off"}
    made = Chart(tour(rounds=[way], hurried={"type": "boolean", "initial": False}))
    made.start()
    sent(made, "next", "next", "next")
    made.write("hurried", True)
    assert sent(made, "next").entered == ("z", "off")
    made.write("hurried", False)
    sent(made, "back")
    assert (made.active, item_of(made)) == ({"work", "tour", "x"}, 3)


@pytest.mark.parametrize("where", ["y", "z"])
def test_what_leaves_the_final_of_the_last_round_is_about_the_last_item(where: str) -> None:
    ways = tour(items=(1, 2)).model_dump()
    more = {**transition("repeat", "x"), "internal": True}
    ways["states"]["work"]["states"]["tour"]["transitions"] = [more]
    made = Chart(Mission.model_validate({**ways, "events": [*ways["events"], "repeat"]}))
    made.start()
    sent(made, "next", "next", "next", "next", "repeat", "next")
    assert (made.active, item_of(made)) == ({"work", "tour", "y"}, 2)
    if where == "z":
        sent(made, "next", "repeat", "next", "next")
    sent(made, "away", "back")
    assert (made.active, item_of(made)) == ({"work", "tour", where}, 2)


def test_the_item_that_a_history_leads_back_to_outlives_its_process() -> None:
    made = Chart(tour())
    made.start()
    sent(made, "next", "next", "next", "away")
    again = Chart.restore(made.mission, unpacked(packed(made.snapshot())))
    assert again.snapshot() == made.snapshot()
    sent(again, "back")
    assert item_of(again) == 2


def test_a_state_in_the_round_of_a_list_without_items_is_left_at_once() -> None:
    made = Chart(tour(items=()))
    made.start()
    assert made.active == {"work", "over"}
    sent(made, "away")
    assert sent(made, "inside").entered == ("work", "tour", "y", "over")


def test_a_proof_follows_a_history_back_to_the_item() -> None:
    is_first = {"key": "item", "==": 1}
    ways = tour(invariants={"y_is_left_out_first": {"not": {"all": [{"in": "y"}, is_first]}}}).model_dump()
    inside = ways["states"]["work"]["states"]["tour"]["states"]
    inside["x"]["transitions"] = [{"when": is_first, "to": "z"}, {"when": {"not": is_first}, "to": "y"}]
    ways["states"]["off"]["transitions"] = [transition("back", "kept")]
    proof = prove(Mission.model_validate(ways))
    assert next(claim for claim in proof.claims if claim.name == "invariants").verdict == "proved"


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
        "initial": "back",
        "states": {"a": {}, "back": {"history": "shallow", "transitions": [{"to": "a"}]}},
    }


def test_a_default_is_drawn_as_where_its_history_leads_without_memory() -> None:
    (edge,) = [each for each in picture(ways("deep", "c")).edges if each.source == "back"]
    assert (edge.target, edge.when) == ("c", "without memory")

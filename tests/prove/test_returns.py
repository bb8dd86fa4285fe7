# SPDX-License-Identifier: Apache-2.0
"""What a history leads back to, and the next item of a list: what is forgotten of them makes no difference."""

from __future__ import annotations

import random
from typing import Any

import pytest

from rai_missions.mission.mission import Mission
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import Forgetless, explored

Json = dict[str, Any]
MOST = 4_000
FINDS: dict[str, Json] = {
    key: {"when": {"key": key, "==": True}, "do": [{"set": "seen", "value": "heavy"}]} for key in ("item.heavy", "flag")
}
"""What a way finds out of a key, and notes."""
COPY: Json = {"set": "flag", "from": "item.heavy"}
ODD: dict[str, Json] = {
    key: {"all": [{"key": "seen", "==": "heavy"}, {"key": key, "==": False}]} for key in ("item.heavy", "flag")
}
"""What is so only where a way has found out something else before."""


def mission_of(going: Json, *rest: Json) -> Mission:
    """What goes over a list, and how it is led back to.

    Args:
        going: The state for each of its items.
        rest: The ways out of the state that it is left for.
    """
    return Mission.model_validate({
        "format": 1, "name": "drawn", "initial": "going",
        "events": {"halt": {}, "go": {}, "turn": {}, "look": {}},
        "blackboard": {
            "items": {"type": "list", "source": "argument"},
            "item": {"type": "object", "fields": {"heavy": "boolean"}},
            "seen": {"type": "string", "initial": ""}, "flag": {"type": "boolean"},
        },
        "states": {"going": {"each": "items", "as": "item", **going}, "rest": {"transitions": [*rest]},
                   "over": {"final": "aborted"}, "odd": {"final": "failed"}},
    })  # fmt: skip


def drawn(seed: int) -> Mission:
    """States with histories, inside each other and in lists, which are left and led back to.

    What a way finds out of an item is noted. A mission comes to `odd` where the item is another one later.
    """
    r = random.Random(seed)

    keys = r.choice([["item.heavy"], ["flag"], ["item.heavy", "flag"]])

    def way(*to: str, likely: float = 0.5) -> Json:
        finds = FINDS[r.choice(keys)] if r.random() < likely else {}
        return {"on": r.choice(["go", "turn"]), "to": r.choice(to), **finds}

    def odd() -> list[Json]:
        return [{"on": "look", "when": ODD[r.choice(keys)], "to": "odd"}]

    def entry() -> list[Json]:
        return [dict(COPY)] * (r.random() < 0.3)

    def leaf(*to: str) -> Json:
        if r.random() < 0.4:
            return {"transitions": [way(*to, likely=0)]}
        return {"entry": entry(), "transitions": [way(*to) for _ in range(r.randint(1, 2))] + odd() * r.randint(0, 1)}

    ahead = r.random() < 0.5
    """Within a list no way leads back, but for histories."""
    inner: Json = {
        "c": leaf("d", "inside") if ahead else leaf("a", "d", "inside"),
        "d": leaf("b", "done") if ahead else leaf("b", "c"),
        "inside": {"history": r.choice(["deep", "shallow"])},
    }
    states: Json = {
        "a": leaf("b", "deeper", "back"), "b": leaf("done", "inside") if ahead else leaf("a", "c", "done"),
        "deeper": {"initial": "c", "entry": entry(), "states": inner, "transitions": [way("b")]},
        "done": {"final": "succeeded"}, "back": {"history": r.choice(["deep", "shallow"])},
    }  # fmt: skip
    first = r.choice(["a", "deeper"])
    states[first]["entry"] = [{"set": "seen", "value": ""}, *states[first].get("entry", [])]
    ends: list[Json] = [{"on": ["succeeded", "failed"], "to": r.choice(["over", "rest"])}]
    going: Json = {"initial": first, "entry": entry(), "states": states,
                   "transitions": [{**way("rest"), "on": "halt"}, *ends]}  # fmt: skip
    rest = [{**way("back"), "on": "go"}, way("going", "back"), way("over", "inside", likely=0)]
    return mission_of(going, *rest)


def hold_against_all_that_is_remembered(seed: int) -> tuple[int, int]:
    mission = drawn(seed)
    few, every = explored(mission, MOST), explored(mission, MOST, Forgetless)
    if not every.is_whole:
        return 0, 0
    assert few.is_whole and few.states <= every.states
    assert (few.seen, {*few.ends.values()}) == (every.seen, {*every.ends.values()})
    assert (few.findings.taken, few.findings.entered) == (every.findings.taken, every.findings.entered)
    assert few.findings.flaws.keys() == every.findings.flaws.keys()
    for name, flaw in few.findings.flaws.items():
        assert len(few.path(flaw.state)) == len(every.path(every.findings.flaws[name].state))
    return few.states, every.states


@pytest.mark.parametrize("seed", range(8))
def test_what_is_forgotten_of_an_item_makes_no_difference(seed: int) -> None:
    assert hold_against_all_that_is_remembered(seed) > (0, 0)


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(8, 500))
def test_what_is_forgotten_of_an_item_makes_no_difference_however_often_it_is_tried(seed: int) -> None:
    hold_against_all_that_is_remembered(seed)


def looks(key: str, *more: Json) -> Json:
    """A state that finds out what an item is, and one that looks whether it is another one by then."""
    return {"transitions": [{"on": "look", "when": ODD[key], "to": "odd"}, *more]}


FINDS_AGAIN: dict[str, tuple[Json, Json]] = {
    "an entry that is made again": (
        {"work": {"entry": [COPY], **looks("flag", {"on": "go", "to": "done"})}, "back": {"history": "deep"}},
        FINDS["flag"],
    ),
    "a shallow history that leads back to a first state": (
        {
            "work": {"initial": "c", "states": {
                "c": looks("item.heavy", {"on": "go", **FINDS["item.heavy"], "to": "d"}),
                "d": {"transitions": [{"on": "go", "to": "done"}]},
            }},
            "back": {"history": "shallow"},
        },
        {},
    ),
    "a history that is looked up within its parent": (
        {
            "work": looks("item.heavy", {"on": "go", **FINDS["item.heavy"], "to": "b"}),
            "b": {"transitions": [{"on": "go", "to": "back"}, {"on": "turn", "to": "done"}]},
            "back": {"history": "deep"},
        },
        {},
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", FINDS_AGAIN)
def test_an_item_that_is_led_back_to_is_the_same(what: str) -> None:
    states, halt = FINDS_AGAIN[what]
    first: Json = {"entry": [{"set": "seen", "value": ""}], "transitions": [{"on": "go", "to": "work"}]}
    going: Json = {
        "initial": "first", "states": {"first": first, "done": {"final": "succeeded"}, **states},
        "transitions": [{"on": "halt", **halt, "to": "rest"}, {"on": ["succeeded", "failed"], "to": "over"}],
    }  # fmt: skip
    mission = mission_of(going, {"on": "go", "to": "back"}, {"on": "turn", "to": "over"})
    for kind in (Environment, Forgetless):
        space = explored(mission, MOST, kind)
        assert space.is_whole and "odd" not in space.findings.entered

# SPDX-License-Identifier: Apache-2.0
"""A state that a run enters is never called unreachable: regions are entered again wherever their parallel state is."""

from __future__ import annotations

from itertools import count
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission

Json = dict[str, Any]
EVENTS = ("a", "b", "c", "d")


def lost(document: Json) -> set[str]:
    """The states that `check` calls unreachable."""
    findings = check(Mission.model_validate(document))
    return {each.place.rpartition("/")[2] for each in findings if each.rule == "unreachable-state"}


def mission(states: Json, initial: str) -> Json:
    ended = {"over": {"final": "aborted"}}
    return {
        "format": 1,
        "name": "m",
        "events": {event: {"about": event} for event in EVENTS},
        "initial": initial,
        "states": states | ended,
        "transitions": [{"on": "cancel", "to": "over"}],
    }


@pytest.mark.parametrize("way", ["of the parallel state", "from outside, another time"])
def test_a_region_without_a_target_begins_with_its_initial_state_again(way: str) -> None:
    both = {
        "r": {"initial": "r1", "states": {"r1": {}, "r2": {}}},
        "q": {"initial": "x1", "states": {"x1": {}, "x2": {}}},
    }
    begin = {"transitions": [{"on": "a", "to": "x2"}]}
    pair: Json = {"parallel": both}
    if way == "of the parallel state":
        pair["transitions"] = [{"on": "b", "to": "r2"}]
    else:
        begin["transitions"].append({"on": "b", "to": "r2"})
    assert lost(mission({"begin": begin, "p": pair}, "begin")) == set()


def test_a_region_that_no_transition_begins_again_keeps_what_is_unreachable() -> None:
    regions = {
        "r": {"initial": "r1", "states": {"r1": {"transitions": [{"on": "b", "to": "r2"}]}, "r2": {}}},
        "q": {"initial": "x1", "states": {"x1": {}, "x2": {}}},
    }
    begin = {"transitions": [{"on": "a", "to": "x2"}]}
    assert lost(mission({"begin": begin, "p": {"parallel": regions}}, "begin")) == {"x1"}


@st.composite
def charts(draw: st.DrawFn) -> Json:
    """Missions of nested states, regions and histories, whose transitions need an event alone."""
    numbers, names, owners = count(), list[str](), list[Json]()

    def state(depth: int) -> Json:
        made: Json = {}
        kind = draw(st.sampled_from(["plain", "compound", "parallel"])) if depth < 3 else "plain"
        if kind == "parallel":
            made["parallel"] = children(depth, 2, is_region=True)
        elif kind == "compound":
            made["states"] = children(depth, draw(st.integers(1, 3)))
            made["initial"] = draw(st.sampled_from([*made["states"]]))
            if draw(st.booleans()):
                name = f"h{next(numbers)}"
                history: Json = {"history": draw(st.sampled_from(["shallow", "deep"]))}
                made["states"][name] = history | (
                    {"transitions": [{"to": made["initial"]}]} if draw(st.booleans()) else {}
                )
                names.append(name)
        owners.append(made)
        return made

    def children(depth: int, many: int, *, is_region: bool = False) -> Json:
        found: Json = {}
        for _ in range(many):
            name = f"s{next(numbers)}"
            names.append(name)
            inner = state(depth + 1)
            if is_region and not inner:
                region = f"s{next(numbers)}"
                inner |= {"initial": region, "states": {region: {}}}
                names.append(region)
                owners.append(inner["states"][region])
            found[name] = inner
        return found

    states = children(0, draw(st.integers(2, 3)))
    for owner in owners:
        ways = draw(st.lists(st.tuples(st.sampled_from(EVENTS), st.sampled_from(names)), max_size=2))
        if ways:
            owner["transitions"] = [{"on": on, "to": to} for on, to in ways]
    return mission(states, next(iter(states)))


@given(charts(), st.lists(st.sampled_from(EVENTS), max_size=30))
def test_what_a_run_enters_is_not_called_unreachable(document: Json, events: list[str]) -> None:
    chart = Chart(Mission.model_validate(document))
    entered = {*chart.start(0.0).entered}
    for at, event in enumerate(events, start=1):
        if chart.outcome is None:
            entered |= {*chart.send(Event(event, float(at))).entered}
    assert not entered & lost(document)

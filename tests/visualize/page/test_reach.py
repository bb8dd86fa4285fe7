# SPDX-License-Identifier: Apache-2.0
"""What is reported as out of reach is out of reach: held against every run of missions, as far as they are explored."""

from __future__ import annotations

from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine.step import Move
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space
from rai_missions.prove.exploration.step_cache import Arrival
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.stimulus import CANCEL
from tests.strategies import KEYS, missions
from tests.visualize.runs import ROOT, tractor
from visualize.page.reachability import Roads

Json = dict[str, Any]
lenient = settings(max_examples=12, suppress_health_check=list(HealthCheck), deadline=None)
MOST = 80


class Moving(Space):
    """A space that remembers by which moves each of its states was first come to."""

    def __init__(self, chart: Environment, most: int) -> None:
        super().__init__(chart, most)
        self.came: list[tuple[int, bool, tuple[Move, ...]]] = []
        self._moves: dict[int, tuple[Edge, tuple[Move, ...]]] = {}

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        moves = tuple(self.environment.chart.state.draft.moves)
        self._moves[id(way)] = way, moves  # the way is kept, so that no other gets its id
        super().learn(source, way, is_paused=is_paused)

    def _find(self, key: bytes | int, source: int, arrival: Arrival, *rest: Any) -> int:
        self.came.append((source, arrival.way.words == CANCEL, self._moves[id(arrival.way)][1]))
        return super()._find(key, source, arrival, *rest)


def hold(mission: Mission) -> None:
    """Whatever a run enters after a transition is in reach of where the transition leads."""
    space = Moving(Environment(mission), MOST)
    space.explore()
    roads = Roads(mission)
    to = {place: transition.to for transitions in roads.transitions.values() for place, transition in transitions}
    reach: dict[frozenset[str], frozenset[str]] = {}
    for number in range(space.states):
        entered: set[str] = set()
        here = number
        while here >= 0:
            here, is_cancel, moves = space.came[here]
            for move in reversed(moves):
                entered |= set(move.entered)
                leads = frozenset(name for place in move.taken for name in to[place])
                if leads:
                    assert entered <= reached(roads, leads, reach), (move.taken, leads)
            if is_cancel:
                entered = set()
        assert entered <= reached(roads, frozenset(mission.initial), reach)


def reached(roads: Roads, leads: frozenset[str], known: dict[frozenset[str], frozenset[str]]) -> frozenset[str]:
    """With what lies around, which is entered on the way in."""
    if leads not in known:
        states = roads.onward(leads).states
        known[leads] = states | {above for name in states for above in roads.above(name)}
    return known[leads]


@lenient
@given(missions())
def test_no_run_enters_what_is_reported_to_be_out_of_reach(mission: Mission) -> None:
    hold(mission)


def _regions(draw: st.DrawFn, prefix: str, everywhere: list[str]) -> Json:
    """A region of three states, which only events move between, and a final."""
    names = [f"{prefix}{number}" for number in range(3)]
    states: Json = {name: {"transitions": []} for name in names}
    for name in names:
        for event in draw(st.lists(st.sampled_from(["poke", "halt", "anomaly"]), unique=True, max_size=2)):
            states[name]["transitions"].append({"on": event, "to": draw(st.sampled_from([*names, *everywhere]))})
    states[f"{prefix}_end"] = {"final": draw(st.sampled_from(["succeeded", "failed"]))}
    states[f"{prefix}0"]["transitions"].append({"on": "hint", "to": draw(st.sampled_from([f"{prefix}_end", names[2]]))})
    if draw(st.booleans()):
        states[f"{prefix}_was"] = {"history": draw(st.sampled_from(["shallow", "deep"]))}
    return {"initial": names[0], "states": states}


@st.composite
def sided(draw: st.DrawFn) -> Mission:
    """Two regions next to each other in an `each`, entered by one name, by two, by default or by a history."""
    inside = [f"{prefix}{number}" for prefix in "ab" for number in range(3)]
    outside = ["before", "done", "aborted", "work"]
    a, b = (_regions(draw, prefix, [*inside, *outside]) for prefix in "ab")
    into = st.one_of(
        st.sampled_from([*outside, *inside, "both"]),
        st.tuples(st.sampled_from([f"a{n}" for n in range(3)]), st.sampled_from([f"b{n}" for n in range(3)])).map(list),
    )
    work: Json = {
        "each": "waypoints", "as": "waypoint", "initial": draw(st.sampled_from(["both", "first", ["a1", "b2"]])),
        "states": {
            "first": {"transitions": [{"on": "poke", "to": draw(into)}, {"on": "halt", "to": "next"}]},
            "both": {"parallel": {"a": a, "b": b}, "transitions": [{"on": "succeeded", "to": "next"}]},
            "next": {"final": "succeeded"},
        },
        "transitions": [{"on": "succeeded", "to": "done"}, {"on": "anomaly", "to": draw(into)}],
    }  # fmt: skip
    return Mission.model_validate({
        "format": 1, "name": "sided", "blackboard": KEYS, "events": ["poke", "halt", "anomaly", "hint"],
        "initial": "before", "transitions": [{"on": "hint", "to": draw(into)}] if draw(st.booleans()) else [],
        "states": {
            "before": {"transitions": [{"on": "poke", "to": draw(into)}, {"on": "halt", "to": draw(into)}]},
            "work": work, "done": {"final": "succeeded"}, "aborted": {"final": "aborted"},
        },
    })  # fmt: skip


@lenient
@given(sided())
def test_no_run_enters_what_is_reported_to_be_out_of_reach_of_regions_and_items(mission: Mission) -> None:
    hold(mission)


def test_leaving_an_item_out_leads_to_the_next_and_so_to_every_end() -> None:
    mission = load(ROOT / "missions/rosbot/mission.json")
    reached_from = Roads(mission).onward(["passed_by"]).states
    assert {"on_the_way", "going", "deciding", "giving_up", "aborted"} <= reached_from


def test_nothing_comes_after_an_end_of_the_mission() -> None:
    assert Roads(tractor()).onward(["aborted"]) == (frozenset({"aborted"}), frozenset())

# SPDX-License-Identifier: Apache-2.0
"""Within one tick of a tree that writes and looks, no fact of the robot leads where the exploration has not been."""

from __future__ import annotations

from itertools import product
from typing import Any

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from tests.prove.explored import explored, walked
from tests.rigs.laws import drill

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
KEYS: Json = {
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 5},
    "alleys": {"type": "integer", "initial": 0},
}
FACTS = {"clear": (None, True, False), "battery": (None, 0.1, 0.9)}
LEAVES = st.sampled_from([
    {"set": "alleys", "add": 1}, {"set": "alleys", "value": 0}, {"check": {"key": "alleys", ">=": 2}},
    {"check": {"key": "clear", "==": True}}, {"check": {"key": "battery", "<": 0.2}},
    {"check": {"any": [{"key": "clear", "==": False}, {"key": "alleys", "==": 1}]}}, {"check": {"fresh": "battery"}},
    {"publish": "lamp", "message": {}},
])  # fmt: skip


def around(nodes: st.SearchStrategy[Json]) -> st.SearchStrategy[Json]:
    """Nodes with these below."""
    several, word = st.lists(nodes, min_size=2, max_size=3), st.sampled_from(["sequence", "selector"])
    one = st.sampled_from(["inverter", "failure_is_success", "failure_is_running"])
    return st.one_of(
        st.builds(lambda word, inside, memory: {word: inside, "memory": memory}, word, several, st.booleans()),
        st.builds(lambda inside: {"parallel": inside}, several),
        st.builds(lambda word, inside: {word: inside}, one, nodes),
        st.builds(lambda word, inside: {word: 3, "child": inside}, st.sampled_from(["repeat", "retry"]), nodes),
    )


def holds(tree: Json) -> None:
    """Every start, whatever the robot has reported before it, is one that was explored."""
    stays = {"transitions": [{"on": "go", "to": "over"}]}
    ends = [{"on": "succeeded", "to": "well"}, {"on": "failed", "to": "ill"}]
    states = {"looking": {"tree": tree, "transitions": ends}, "well": stays, "ill": stays, "over": {"final": "aborted"}}
    mission = Mission.model_validate({
        "format": 1, "name": "tick", "blackboard": KEYS, "events": {"go": {}}, "initial": "looking", "states": states,
    })  # fmt: skip
    space = explored(mission, 60)
    assume(space.is_whole)
    for values in product(*FACTS.values()):
        known = {key: value for key, value in zip(FACTS, values, strict=True) if value is not None}
        (started,) = walked(mission, [], {}, **known)
        assert started in space.seen, f"started with {known}"


@settings(lenient, max_examples=15)
@given(st.recursive(LEAVES, around, max_leaves=6))
def test_every_start_is_one_that_was_explored(tree: Json) -> None:
    holds(tree)


test_every_start_is_one_that_was_explored_however_often_it_is_tried = drill(
    holds, st.recursive(LEAVES, around, max_leaves=10), tried=settings(lenient, max_examples=5000)
)

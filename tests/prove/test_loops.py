# SPDX-License-Identifier: Apache-2.0
"""A few rounds of a loop represent ten thousand: the same verdicts, and refutations that the mission itself runs."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.journal import Header
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove, record
from rai_missions.prove.analysis import loops
from rai_missions.replay.replay import replay
from tests.strategies import KEYS as TREE_KEYS
from tests.strategies import tree_nodes

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
WORK = 5_000
CLEAR: Json = {"check": {"key": "clear", "==": True}}
CALL: Json = {"call": "horn", "timeout_s": 3}
KEYS: Json = {
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 5}, "n": {"type": "integer", "initial": 0},
    "seen": {"type": "integer", "initial": 0},
}  # fmt: skip


def looping(tree: Json, *, failed: str = "over", **words: Any) -> Mission:
    transitions = [{"on": ["succeeded", "timed_out"], "to": "over"}, {"on": "failed", "to": failed}]
    return Mission.model_validate({
        "format": 1, "name": "looping", "initial": "going", "blackboard": KEYS,
        "states": {"going": {"tree": tree, "timeout_s": 1e6, "transitions": transitions}, "over": {"final": "aborted"},
                   "stuck": {}}, **words,
    })  # fmt: skip


def proof_of(mission: Mission, **words: Any) -> Proof:
    return prove(mission, **words)


def verdicts(proof: Proof) -> list[tuple[str, str, str]]:
    return [(each.name, each.verdict, each.sentence) for each in proof.claims]


BODIES: dict[str, Json] = {
    "a call": CALL,
    "an action": {"action": "lift", "timeout_s": 3},
    "a check before a call": {"sequence": [CLEAR, CALL]},
    "a wait and a check": {"sequence": [{"wait_s": 1}, CLEAR]},
    "a loop": {"retry": 100, "child": CALL},
    "two things at once": {"parallel": [CALL, {"sequence": [{"wait_s": 2}, CLEAR]}]},
    "a count that nothing reads": {"sequence": [{"set": "n", "add": 1}, CALL]},
}


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_ten_thousand_rounds_take_no_longer_than_a_hundred(body: Json) -> None:
    began = time.process_time()
    some, many = (proof_of(looping({"retry": rounds, "child": body})) for rounds in (100, 10_000))
    assert (many.verdict, some.states, some.steps) == ("proved", many.states, many.steps)
    assert many.states < 3000 and "going" in many.alike and time.process_time() - began < 20


@pytest.mark.parametrize("rounds", [17, pytest.param(1000, marks=pytest.mark.drill)])
def test_a_run_that_needs_every_round_has_every_round(rounds: int, tmp_path: Path) -> None:
    mission = looping({"retry": rounds, "child": {"sequence": [{"wait_s": 1}, CLEAR]}}, failed="stuck")
    proof = proof_of(mission)
    run = proof.ways["ends"]
    assert proof.alike == {"going": rounds} and len(run) == rounds + 1
    assert record(tmp_path / "run.journal", Header(dump(mission)), mission, run)
    again = replay(tmp_path / "run.journal")
    assert again.holds and again.outcome is None


def test_a_run_of_two_loops_has_the_rounds_of_both(tmp_path: Path) -> None:
    waits: Json = {"sequence": [{"wait_s": 1}, CLEAR]}
    second: Json = {"inverter": {"repeat": 20, "child": {"wait_s": 1}}}
    tree: Json = {"selector": [{"retry": 30, "child": waits}, second], "memory": True}
    mission = looping(tree, failed="stuck")
    proof = proof_of(mission)
    assert len(proof.alike) == 2 and len(proof.ways["ends"]) == 1 + 30 + 20
    assert record(tmp_path / "run.journal", Header(dump(mission)), mission, proof.ways["ends"])


@pytest.mark.drill
def test_a_round_within_a_round_is_gone_as_often_as_both_ask(tmp_path: Path) -> None:
    tree: Json = {"retry": 20, "child": {"inverter": {"repeat": 17, "child": {"wait_s": 1}}}}
    mission = looping(tree, failed="stuck")
    proof = proof_of(mission)
    assert len(proof.ways["ends"]) == 1 + 20 * 17
    assert record(tmp_path / "run.journal", Header(dump(mission)), mission, proof.ways["ends"])


UNLIKE: dict[str, tuple[Json, int]] = {
    "a count that is read": (
        {"retry": 40, "child": {"sequence": [{"set": "n", "add": 1}, {"wait_s": 1}, {"check": {"key": "n", ">": 30}}]}},
        32,
    ),
    "a time that is over": ({"timeout": 25.5, "child": {"repeat": 40, "child": {"wait_s": 1}}}, 27),
}


@pytest.mark.parametrize(("tree", "steps"), UNLIKE.values(), ids=UNLIKE)
def test_rounds_that_are_not_alike_are_explored_each(tree: Json, steps: int) -> None:
    transitions = [{"on": ["succeeded", "failed"], "to": "stuck"}, {"on": "timed_out", "to": "over"}]
    mission = looping(tree)
    mission = Mission.model_validate({
        **mission.model_dump(by_alias=True, exclude_unset=True),
        "states": {"going": {"tree": tree, "timeout_s": 1e6, "transitions": transitions}, "over": {"final": "aborted"},
                   "stuck": {}},
    })  # fmt: skip
    assert len(proof_of(mission).ways["ends"]) == steps


# -- the law ---------------------------------------------------------------------------------------------------------


@st.composite
def looping_documents(draw: st.DrawFn) -> Json:
    """A loop over any tree, perhaps within another, next to a region that counts and asks."""
    tree: Json = {draw(st.sampled_from(["retry", "repeat"])): draw(st.integers(17, 21)), "child": draw(tree_nodes())}
    around = draw(st.sampled_from(["", "", "timeout", "inverter", "selector", "retry"]))
    if around == "timeout":
        tree = {"timeout": draw(st.sampled_from([3.0, 9.0, 100.0])), "child": tree}
    elif around == "retry":
        tree = {"retry": draw(st.integers(2, 18)), "child": tree}
    elif around:
        tree = {around: tree if around == "inverter" else [tree, draw(tree_nodes(depth=1))]}
    ends = draw(st.permutations(["over", "done", "stuck"]))
    going: Json = {"tree": tree, "timeout_s": 200.0, "transitions": [
        {"on": "succeeded", "to": ends[0]}, {"on": "failed", "to": ends[1]}, {"on": "timed_out", "to": ends[2]},
    ]}  # fmt: skip
    if draw(st.booleans()):
        going["transitions"].insert(0, {"when": {"key": "count", ">=": draw(st.integers(1, 3))}, "to": ends[1]})
    return {
        "format": 1, "name": "looping", "version": "1.0.0", "blackboard": {**TREE_KEYS}, "initial": "going",
        "events": {"poke": {}, "hint": {}, "halt": {}, "anomaly": {}},
        "states": {"going": going, "over": {"final": "aborted"}, "stuck": {},
                   "done": {"final": "succeeded", "requires": {"key": "clear", "==": True}}},
    }  # fmt: skip


def hold_against_every_round(document: Json, most: int) -> None:
    mission = Mission.model_validate(document)
    few = proof_of(mission, most=most, work=WORK)
    assume(few.is_whole and few.alike)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loops, "LONG", 10**6)
        every = proof_of(mission, most=20 * most, work=20 * WORK)
    assume(every.is_whole)
    assert every.alike == {} and verdicts(few) == verdicts(every) and few.never == every.never
    assert (few.assumed, few.in_pause, few.sampled) == (every.assumed, every.in_pause, every.sampled)
    for name, run in every.ways.items():
        assert len(few.ways[name]) >= len(run)


@settings(lenient, max_examples=5)
@given(looping_documents())
def test_a_few_rounds_prove_what_all_of_them_prove(document: Json) -> None:
    hold_against_every_round(document, 150)


@pytest.mark.drill
@settings(lenient, max_examples=2000)
@given(looping_documents())
def test_a_few_rounds_prove_what_all_of_them_prove_however_often_it_is_tried(document: Json) -> None:
    hold_against_every_round(document, 500)


def test_a_time_that_is_over_in_a_late_round_is_found() -> None:
    tree: Json = {"timeout": 25.5, "child": {"repeat": 40, "child": {"wait_s": 1}}}
    proof = proof_of(looping(tree, failed="stuck"))
    assert len(proof.ways["ends"]) == 27 and "over" not in proof.never

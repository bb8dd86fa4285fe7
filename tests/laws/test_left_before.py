# SPDX-License-Identifier: Apache-2.0
"""An outcome belongs to a visit of its state: once that is left, only a transition that names the state has use for it.

The state is left in the step of its own outcome: what its tree writes makes a guard true, and a transition without a
trigger comes before the outcome.
"""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions import Chart, Mission, Tick
from rai_missions.engine.snapshot_json import packed, unpacked

OUTCOMES = ["succeeded", "failed"]
HANDLERS = ("own", "around", "mission", "name")
Json = dict[str, Any]


def mission(outcome: str, leads: str, handlers: frozenset[str], *, is_left: bool, deep: bool) -> Mission:
    """A state `work` whose tree ends after a second, with transitions for its outcome.

    Args:
        outcome: How the tree ends.
        leads: Where a guard leads: `work` again, its sibling `rest`, or `aside`, which is outside.
        handlers: Whose transitions are for outcomes; `name` is one of the mission that names the state.
        is_left: Whether the tree makes that guard true as it ends.
        deep: Another compound state is around it.
    """
    ends = {"wait_s": 0} if outcome == "succeeded" else {"inverter": {"wait_s": 0}}
    work: Json = {
        "tree": {"sequence": [{"wait_s": 1}, {"set": "gone", "value": is_left}, ends]},
        "transitions": [
            {"when": {"key": "gone", "==": True}, "to": leads, "do": [{"set": "gone", "value": False}]},
            *([{"on": OUTCOMES, "to": "by_own"}] if "own" in handlers else []),
        ],
    }
    around: Json = {"initial": "work", "states": {"work": work, "rest": {}}}
    if deep:
        around = {"initial": "inside", "states": {"inside": around}}
    around["transitions"] = [{"on": OUTCOMES, "to": "by_around"}] if "around" in handlers else []
    top = [{"on": OUTCOMES, "to": "by_mission"}] if "mission" in handlers else []
    top += [{"on": OUTCOMES, "of": "work", "to": "by_name"}] if "name" in handlers else []
    return Mission.model_validate(
        {
            "name": "left",
            "initial": "around",
            "blackboard": {"gone": {"type": "boolean", "initial": False}},
            "states": {"around": around, "aside": {}, **{f"by_{each}": {} for each in HANDLERS}},
            "transitions": top,
        }
    )


@given(
    outcome=st.sampled_from(OUTCOMES),
    leads=st.sampled_from(["work", "rest", "aside"]),
    handlers=st.frozensets(st.sampled_from(HANDLERS)),
    is_left=st.booleans(),
    deep=st.booleans(),
)
def test_an_outcome_of_a_state_that_was_left_fires_only_what_names_the_state(
    outcome: str, leads: str, handlers: frozenset[str], is_left: bool, deep: bool
) -> None:
    made = mission(outcome, leads, handlers, is_left=is_left, deep=deep)
    chart = Chart(made)
    chart.start(0.0)
    chart = Chart.restore(made, unpacked(packed(chart.snapshot())))
    step = chart.send(Tick(1.0))
    climbing = ["around", "mission"] if outcome == "failed" else []
    open_to = ["name"] if is_left else ["own", *climbing, "name"]
    taken = [f"by_{each}" for each in open_to if each in handlers][:1]
    if is_left:
        assert step.moves[0].entered[-1] == leads
    assert [move.entered[0] for move in step.moves[is_left:]] == taken
    assert (step.outcome == "failed") is (outcome == "failed" and not is_left and not taken)

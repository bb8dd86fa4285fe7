# SPDX-License-Identifier: Apache-2.0
"""What is counted up to an argument of few whole numbers is proved for each of them."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove

Json = dict[str, Any]
MOST: Json = {"type": "integer", "source": "argument", "initial": 2, "minimum": 1, "maximum": 5}


def trying(most: Json, *, also: int = 3, **words: Any) -> Mission:
    """A call that is made again as often as an argument has it; it ends in another state if that is some number."""
    failed = ["failed", "timed_out", "rejected"]
    return Mission.model_validate({
        "name": "trying", "initial": "calling", **words,
        "blackboard": {"most": most, "tries": {"type": "integer", "initial": 0}},
        "states": {
            "calling": {"call": "door", "timeout_s": 5, "entry": [{"set": "tries", "add": 1}], "transitions": [
                {"on": "succeeded", "to": "over"},
                {"on": failed, "when": {"key": "tries", "<": {"key": "most"}}, "to": "pausing"},
                {"on": failed, "when": {"key": "tries", "==": also}, "to": "odd"},
                {"on": failed, "to": "over"},
            ]},
            "pausing": {"transitions": [{"after_s": 3, "to": "calling"}]},
            "odd": {"final": "failed"}, "over": {"final": "aborted"},
        },
    })  # fmt: skip


def ends(most: int, also: int) -> str:
    """Where the run of a door that never opens ends."""
    chart = Chart(trying(MOST, also=also))
    chart.write("most", most, at=0)
    step = chart.start(at=0)
    while chart.outcome is None:
        calls = [effect.number for effect in step.effects if type(effect).__name__ == "CallService"]
        step = chart.send(
            Event("failed", chart.at, {}, "result", calls[0]) if calls else Event("tick", chart.at + 3, {}, "tick")
        )
    return step.entered[0]


@pytest.mark.parametrize("also", [0, 1, 4, 5, 6])
def test_a_proof_comes_to_the_ends_that_runs_with_each_number_come_to(also: int) -> None:
    proof = prove(trying(MOST, also=also))
    assert (proof.sampled, proof.is_whole) == ((), True)
    assert ("odd" in proof.never) is ("odd" not in {ends(most, also) for most in range(1, 6)})


@pytest.mark.parametrize(("few", "verdict"), [(5, "proved"), (4, "refuted")])
def test_a_count_is_bounded_by_the_largest_number(few: int, verdict: str) -> None:
    proof = prove(trying(MOST, invariants={"few": {"key": "tries", "<=": few}}))
    assert {each.name: each.verdict for each in proof.claims}["invariants"] == verdict


@pytest.mark.parametrize("most", [{**MOST, "maximum": 5000}, {"type": "integer", "source": "argument", "initial": 2}])
def test_what_is_counted_up_to_any_number_is_tried_with_some_values_only(most: Json) -> None:
    assert prove(trying(most), most=200).sampled == ("most", "tries")

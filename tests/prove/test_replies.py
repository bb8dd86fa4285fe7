# SPDX-License-Identifier: Apache-2.0
"""How a call can end in a proof is how it can end in a run: `timed_out` only where it has a time."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.activities.call import REPLIES
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove

Json = dict[str, Any]
ENDS = ("succeeded", "failed", "timed_out", "rejected")
STATES: dict[str, Json] = {
    "a call": {"call": "horn"},
    "a call with a time": {"call": "horn", "timeout_s": 5},
    "a tree": {"tree": {"call": "horn"}},
    "a tree, its leaf with a time": {"tree": {"call": "horn", "timeout_s": 5}},
    "a call of an effect": {"entry": [{"call": "horn"}]},
}


@pytest.mark.parametrize("what", STATES)
def test_a_call_ends_in_a_proof_as_in_runs(what: str) -> None:
    transitions = [{"on": end, "to": f"has_{end}"} for end in (*ENDS, "call_failed")]
    states: Json = {f"has_{end}": {} for end in (*ENDS, "call_failed")}
    mission = Mission.model_validate(
        {"name": "calling", "initial": "a", "states": {"a": {**STATES[what], "transitions": transitions}, **states}}
    )
    found = set[str]()
    for reply in (*REPLIES, "of a server of its own"):
        chart = Chart(mission)
        chart.start(0.0)
        found |= set(chart.send(Event(reply, 1.0, {}, "result", 1)).entered)
    assert set(states) - set(prove(mission).never) == found
    assert ("has_timed_out" in found) is ("timeout_s" in STATES[what])

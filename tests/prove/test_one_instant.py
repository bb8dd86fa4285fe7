# SPDX-License-Identifier: Apache-2.0
"""What comes at one instant in a run, the proof has at one instant: ages of states, held guards, stale keys, timers."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Tick
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove

Json = dict[str, Any]
STOP: Json = {"on": "stop", "to": "over"}
AGED: Json = {"elapsed_s": 2}
HELD: Json = {"held": {"key": "read", "==": True}, "for_s": 2}
STALE: Json = {"not": {"fresh": "mark"}}
MARK: Json = {"mark": {"type": "boolean", "initial": False, "max_age_s": 2}}


def both(one: Json, other: Json) -> Json:
    """Two regions, each of which moves on only while the other has not."""
    regions = {
        name: {"initial": f"{name}1", "states": {
            f"{name}1": {"transitions": [{"when": {"all": [guard, {"in": f"{there}1"}]}, "to": f"{name}2"}]},
            f"{name}2": {},
        }} for name, there, guard in (("x", "y", one), ("y", "x", other))
    }  # fmt: skip
    moved: Json = {"all": [{"in": "x2"}, {"in": "y2"}]}
    return {"a": {"parallel": regions, "transitions": [{"when": moved, "to": "found"}, STOP]}}


def alone(*transitions: Json, **words: Any) -> Json:
    return {"a": {"transitions": [*transitions, {"when": AGED, "to": "other"}, STOP], **words}}


STATES: dict[str, Json] = {
    "a timer, and the age of its state": alone({"after_s": 2, "when": AGED, "to": "found"}),
    "a timeout, and the age of its state": alone({"on": "timed_out", "when": AGED, "to": "found"}, timeout_s=2),
    "a delayed event, and the age of a state": alone(
        {"on": "due", "when": AGED, "to": "found"}, entry=[{"raise": "due", "after_s": 2}]
    ),
    "a timer, and a key of the mission that goes stale": {
        "a": {"entry": [{"set": "mark", "value": True}], "transitions": [
            {"after_s": 2, "when": STALE, "to": "found"}, {"when": STALE, "to": "other"}, STOP]},
    },
    "a key of the mission that goes stale, and the age of a state": alone(
        {"when": {"all": [AGED, STALE]}, "to": "found"}, {"when": STALE, "to": "other"},
        entry=[{"set": "mark", "value": True}],
    ),
    "the ages of two states": both(AGED, AGED),
    "the age of a state, and a guard that was held": both(AGED, HELD),
    "two guards that were held": both(HELD, HELD),
}  # fmt: skip


@pytest.mark.parametrize("what", STATES)
def test_what_comes_at_one_instant_is_not_called_out_of_reach(what: str) -> None:
    rest = {name: {"transitions": [STOP]} for name in ("found", "other")}
    read: Json = {"read": {"type": "boolean", "source": "robot", "optional": True}}
    mission = Mission.model_validate({
        "name": "instant", "initial": "a", "blackboard": {**read, **MARK}, "events": ["stop", "due"],
        "states": {**STATES[what], **rest, "over": {"final": "aborted"}},
    })  # fmt: skip
    chart = Chart(mission)
    chart.write("read", True, 0.0)
    chart.start(0.0)
    chart.send(Tick(2.0))
    assert "found" in chart.active
    assert "found" not in prove(mission).never

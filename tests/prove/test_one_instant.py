# SPDX-License-Identifier: Apache-2.0
"""What comes at one instant in a run, the proof has at one instant.

Ages of states, held guards, stale keys, timers, and what activities and finals wait for.
"""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove

Json = dict[str, Any]
STOP: Json = {"on": "stop", "to": "over"}
ASKED: Json = {
    "question": "What now?",
    "options": {"yes": {}, "no": {}},
    "ask": ["agent"],
    "deadline_s": 2,
    "fallback": "yes",
}
AGED: Json = {"elapsed_s": 2}
HELD: Json = {"held": {"key": "read", "==": True}, "for_s": 2}
STALE: Json = {"not": {"fresh": "mark"}}
COUNTS: Json = {name: {"type": "integer", "initial": 0} for name in ("n", "m")}
READ: Json = {"read": {"type": "boolean", "source": "robot", "optional": True}}
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


SET: Json = {"set": "n", "value": 1}
IS_SET: Json = {"key": "n", "==": 1}
OTHERWISE: Json = {"on": ["succeeded", "failed"], "to": "other"}
UNTIL_SET: Json = {"selector": [{"check": IS_SET}, {"wait_s": 100}], "memory": False}
LATER: Json = {"final": "succeeded", "requires": {"key": "read", "==": False}, "settle_s": 2}


def side_by_side(left: Json, right: Json, *around: Json, **more: Json) -> Json:
    """Two regions of two states, or one."""
    regions = {
        "left": {"initial": "x", "states": {"x": left, **({"z": more["z"]} if "z" in more else {})}},
        "right": {"initial": "y", "states": {"y": right, "w": more.get("w", {})}},
    }
    return {"a": {"parallel": regions, "transitions": [*around, STOP]}}


def leaving(outcome: str, left: Json, right: Json) -> Json:
    """The answer to the first outcome leaves the other state, whose outcome another waits for."""
    away: Json = {"when": {"in": "z"}, "to": "w"}
    return side_by_side(
        {**left, "transitions": [{"on": outcome, "to": "z"}]},
        {**right, "transitions": [away, {"on": outcome, "to": "other"}]},
        z={"transitions": [{"on": outcome, "of": "y", "to": "found"}]},
    )


def set_by_timer(tree: Json) -> Json:
    """A timer that writes what a tree looks at, which fails then."""
    return side_by_side(
        {"transitions": [{"after_s": 2, "do": [SET]}]},
        {"tree": tree, "transitions": [{"on": "failed", "when": IS_SET, "to": "found"}, OTHERWISE]},
    )


STATES: dict[str, Json] = {
    "a timer that writes, and a wait of a tree that looks": set_by_timer(
        {"parallel": [UNTIL_SET, {"inverter": {"wait_s": 2}}], "policy": "success_on_one"}
    ),
    "a timer that writes, and the timeout of a leaf of a tree that looks": set_by_timer(
        {"parallel": [UNTIL_SET, {"action": "drive", "timeout_s": 2}], "policy": "success_on_one"}
    ),
    "two trees, each of which writes": side_by_side(
        {"tree": {"wait_s": 2}, "transitions": [{"on": "succeeded", "when": IS_SET, "to": "found"}, OTHERWISE]},
        {"tree": {"sequence": [{"wait_s": 2}, SET]}, "transitions": [OTHERWISE]},
    ),
    "two trees, the second of which begins after a call": side_by_side(
        {"tree": {"wait_s": 2}, "transitions": [{"on": "succeeded", "when": IS_SET, "to": "z"}]},
        {"call": "turn", "transitions": [{"on": "succeeded", "to": "w"}]},
        z={"transitions": [{"after_s": 1, "to": "found"}]},
        w={"tree": {"sequence": [{"wait_s": 2}, SET]},
           "transitions": [{"on": "succeeded", "do": [{"set": "n", "value": 0}]}]},
    ),
    "two trees, the first of which leaves the second": leaving(
        "succeeded", {"tree": {"wait_s": 2}}, {"tree": {"wait_s": 2}}
    ),
    "two questions, the first of which leaves the second": leaving("yes", {"decision": ASKED}, {"decision": ASKED}),
    "a goal and a tree, whose waits began in two steps": side_by_side(
        {"action": "turn", "achieved": {"key": "read", "==": False}, "settle_s": 2,
         "transitions": [{"on": "unverified", "when": IS_SET, "to": "found"}, {**OTHERWISE, "on": "unverified"}]},
        {"tree": {"sequence": [{"wait_s": 2}, SET]}, "transitions": [OTHERWISE]},
    ),
    "two waits of one tree that began in two steps": {
        "a": {"tree": {"parallel": [{"sequence": [{"wait_s": 2}, SET]}, {"sequence": [
                  {"action": "turn"}, {"wait_s": 2}, {"set": "m", "value": 1}]}], "policy": "success_on_one"},
              "transitions": [{"on": "succeeded", "when": {"all": [IS_SET, {"key": "m", "==": 1}]}, "to": "found"},
                              OTHERWISE, STOP]},
    },
    "two finals that do not settle": leaving("unverified", {"initial": "p", "states": {"p": LATER}},
                                             {"initial": "q", "states": {"q": LATER}}),
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
    known = {
        **COUNTS,
        **(MARK if "mark" in repr(STATES[what]) else {}),
    }  # with it regions are not explored part by part
    mission = Mission.model_validate({
        "name": "instant", "initial": "a", "blackboard": {**READ, **known}, "events": ["stop", "due"],
        "states": {**STATES[what], **rest, "over": {"final": "aborted"}},
    })  # fmt: skip
    chart = Chart(mission)
    chart.write("read", True, 0.0)
    for each in chart.start(0.0).effects:
        if "turn" in (getattr(each, "action", ""), getattr(each, "service", "")):
            chart.send(Event("succeeded", 0.0, {}, "result", each.number))
    chart.send(Tick(3.0))
    assert "found" in chart.active
    assert "found" not in prove(mission).never

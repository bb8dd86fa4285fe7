# SPDX-License-Identifier: Apache-2.0
"""A tree in a mission is ticked when something concerns it, and at no other time."""

from __future__ import annotations

from rai_missions.engine import Chart
from rai_missions.engine.step import StartGoal
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

COUNTING = {
    "selector": [
        {"sequence": [{"set": "ticks", "add": 1}, {"check": {"key": "door", "==": True}}], "memory": False},
        {"wait_s": 10},
    ],
    "memory": False,
}


def ticking() -> Chart:
    keys = {
        "ticks": {"type": "integer", "initial": 0},
        "door": {"type": "boolean", "source": "robot", "max_age_s": 30},
        "other": {"type": "boolean", "source": "robot"},
    }
    states = {
        "work": {"tree": COUNTING, "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "done"}, {"on": "e"}]},
        "done": {"final": "aborted"},
    }
    data = {"name": "ticking", "initial": "work", "states": states, "blackboard": keys, "events": {"e": {}}}
    made = Chart(Mission.model_validate(data), CompiledTrees())
    made.start(0.0)
    return made


def ticks(made: Chart) -> int:
    value: int = made.view.board["ticks"].value
    return value


def test_what_does_not_concern_a_tree_does_not_tick_it() -> None:
    made = ticking()
    assert ticks(made) == 1
    made.send(Event("e", 1.0))
    made.write("other", True, 2.0)
    made.send(Event("accepted", 3.0, {}, "accepted", 77))
    made.send(Event("succeeded", 3.0, {}, "result", 77))
    made.send(Tick(4.0))
    assert ticks(made) == 1


def test_a_key_that_it_reads_ticks_it_once() -> None:
    made = ticking()
    made.write("door", False, 1.0)
    assert ticks(made) == 2
    assert made.write("door", True, 2.0).outcome == "aborted"
    assert ticks(made) == 3


def test_its_own_timer_ticks_it() -> None:
    made = ticking()
    assert made.wake_at == 10.0
    assert made.send(Tick(10.0)).outcome == "aborted"


def test_a_leaf_that_waits_for_resources_starts_when_they_are_free() -> None:
    go = {"action": "go", "timeout_s": 60, "transitions": [{"on": "e", "to": "tree"}, {"on": "succeeded", "to": "end"}]}
    tree = {"tree": {"action": "turn", "timeout_s": 30}, "transitions": [{"on": ["succeeded", "failed"], "to": "end"}]}
    data = {
        "name": "m",
        "initial": "go",
        "events": {"e": {}},
        "states": {"go": go, "tree": tree, "end": {"final": "aborted"}},
    }
    made = Chart(Mission.model_validate(data), CompiledTrees())
    number = made.start(0.0).effects[0].number  # type: ignore[union-attr]
    made.send(Event("accepted", 0.0, {}, "accepted", number))
    assert not any(isinstance(effect, StartGoal) for effect in made.send(Event("e", 1.0)).effects)
    step = made.send(Event("canceled", 2.0, {}, "result", number))
    assert [effect.action for effect in step.effects if isinstance(effect, StartGoal)] == ["turn"]

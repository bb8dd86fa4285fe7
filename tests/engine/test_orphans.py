# SPDX-License-Identifier: Apache-2.0
"""A goal that is given up before its server has reported a word of it is canceled all the same."""

from __future__ import annotations

from rai_missions.engine import Chart
from rai_missions.engine.step import CancelGoal
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

MOVING = Mission.model_validate({
    "name": "moving", "initial": "moving", "events": ["leave"],
    "states": {"moving": {"action": "move", "timeout_s": 60, "cancel_s": 3,
                          "transitions": [{"on": "leave", "to": "gone"}]},
               "gone": {"transitions": [{"on": "leave", "to": "over"}]}, "over": {"final": "canceled"}},
})  # fmt: skip


def test_a_goal_that_was_never_accepted_is_canceled_when_it_is_given_up() -> None:
    chart = Chart(MOVING)
    chart.start(0.0)
    assert not any(isinstance(each, CancelGoal) for each in chart.send(Event("leave", 1.0)).effects)
    step = chart.send(Tick(4.0))
    assert step.effects == (CancelGoal(1, "move"),)
    assert any("orphaned" in note for note in step.notes)

# SPDX-License-Identifier: Apache-2.0
"""What a person reads of a step has the words of the pages; what a journal keeps has those of the file."""

from __future__ import annotations

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.description import describe
from rai_missions.event import Event
from rai_missions.mission.mission import Mission

MISSION = Mission.model_validate({
    "format": 1, "name": "m", "initial": "a", "states": {
        "a": {"control": "agent", "decision": {
            "question": "Which?", "options": {"left": {}, "right": {}}, "ask": ["agent", "rules"], "fallback": "left"},
            "transitions": [{"on": ["left", "right"], "to": "b"}]},
        "b": {"final": "aborted"}},
})  # fmt: skip


def test_a_step_names_who_gives_control_that_no_one_has() -> None:
    chart = Chart(MISSION)
    chart.start(at=0.0)
    assert describe(chart.send(Event("nobody", 1.0, {}, "control"))).remarks[0] == (
        "control: no one, until the operator gives it"
    )


def test_a_step_names_who_has_control_and_who_is_asked_as_the_pages_do() -> None:
    chart = Chart(MISSION)
    begun = chart.start(at=0.0)
    assert "ask for control to go to the mission itself" in describe(begun).effects
    handed = chart.send(Event("agent", 1.0, {}, "control"))
    assert describe(handed).remarks == ("control: the mission itself",)
    assert handed.notes == ("control: agent",)
    (asked,) = describe(handed).effects
    assert asked.startswith("ask the model (question ")
    question = chart.questions[0]
    answered = chart.propose(question.number, "left", at=2.0)
    assert describe(answered).event == "answered by the model"
    assert answered.event.name == "agent"


@pytest.mark.parametrize("reply", [{"absent": "no model configured"}, {"failed": "no answer within 2.0 s"}])
def test_who_gave_no_answer_has_not_answered(reply: dict[str, str]) -> None:
    chart = Chart(MISSION)
    chart.start(at=0.0)
    chart.send(Event("agent", 1.0, {}, "control"))
    (question,) = chart.questions
    step = chart.send(Event("agent", 2.0, reply, "proposal", question.number))
    assert describe(step).event == "no answer: the model"

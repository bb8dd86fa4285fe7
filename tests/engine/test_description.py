# SPDX-License-Identifier: Apache-2.0
"""A step as JSON for its readers."""

from __future__ import annotations

import json

from hypothesis import given

from rai_missions.engine import Chart
from rai_missions.engine.description import describe, step_json
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from tests.rigs.journals import steps

made = steps.map(lambda step: step._replace(verdicts=()))
"""Steps whose verdicts would name notes that are not in them."""


@given(made)
def test_a_step_is_json_with_the_words_of_its_description(step: Step) -> None:
    found, described = step_json(step), describe(step)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert [each["about"] for each in found["effects"]] == list(described.effects)
    assert (found["verdicts"], found["notes"]) == (list(described.verdicts), list(described.remarks))
    assert [found["exited"], found["entered"]] == [list(step.exited), list(step.entered)]


@given(made)
def test_a_field_that_a_reader_does_not_want_is_left_out_by_its_name(step: Step) -> None:
    whole = step_json(step)
    for name in whole:
        assert step_json(step, without=(name,)) == {word: value for word, value in whole.items() if word != name}


def test_time_is_named_with_the_outcome_or_the_event_that_it_brought() -> None:
    later = {"raise": "look_again", "after_s": 1}
    states = {
        "waiting": {"timeout_s": 5, "transitions": [{"on": "timed_out", "to": "pausing"}]},
        "pausing": {"transitions": [{"after_s": 1, "to": "planning"}]},
        "planning": {"entry": [later], "transitions": [{"on": "look_again", "to": "over"}]},
        "over": {"final": "aborted"},
    }
    given_mission = {"name": "late", "initial": "waiting", "events": ["look_again"], "states": states}
    chart = Chart(Mission.model_validate(given_mission))
    chart.start(0.0)
    words = [describe(chart.send(Event("tick", at, kind="tick"))).event for at in (1.0, 5.0, 6.0, 7.0)]
    assert words == ["time", "time: timed_out", "time", "time: look_again"]

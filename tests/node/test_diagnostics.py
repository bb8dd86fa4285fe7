# SPDX-License-Identifier: Apache-2.0
"""How bad it is: OK while it runs, WARN where someone should look, ERROR where it has failed."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rai_missions.agents.health import ERROR, OK, WARN
from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.decision import Question
from rai_missions.node.diagnostics import Symptoms, array_of, level
from rai_missions.node.status_message import OpenQuestion, StatusMessage, text_of
from rai_missions.plain_data import carried, text_fault
from rai_missions.runtime.readings import SourceState

RUNNING = StatusMessage(3, "/errand", "ab", "active", "errand", "1.0", "r1", "running", "autonomy", ("moving",))
LOOSE = (OpenGoal(3, "drive", "moving", "refused"),)
MOVING = "the robot may still move: goal 3 of 'drive' (its server refuses to cancel it)"
ASKED = (OpenQuestion(Question(4, "asking", "operator", "Which way?", ()), 5.0),)


@pytest.mark.parametrize(
    ("changed", "around", "expected"),
    [
        ({}, {}, (OK, "running")),
        ({"mode": "idle"}, {}, (OK, "idle")),
        ({"mode": "succeeded", "outcome": "succeeded"}, {}, (OK, "succeeded")),
        ({"mode": "paused"}, {}, (WARN, "paused")),
        ({"mode": "canceling"}, {}, (WARN, "canceling")),
        ({"questions": ASKED}, {}, (WARN, "question 4 waits for operator: Which way?")),
        (
            {"questions": ASKED, "waits": "asking waits until control is with agent; autonomy has it"},
            {},
            (WARN, "asking waits until control is with agent; autonomy has it"),
        ),
        ({}, {"stale": ("battery", "pose")}, (WARN, "not fresh: battery, pose")),
        ({}, {"strangers": 1}, (WARN, "another node is called /errand too; give one of them another name with --node")),
        ({"mode": "failed", "why": "timed_out"}, {"stale": ("pose",)}, (ERROR, "failed: timed_out")),
        ({"mode": "aborted", "why": "e-stop by Ann"}, {}, (ERROR, "aborted: e-stop by Ann")),
        (
            {"mode": "failed", "why": "timed_out", "open_goals": LOOSE},
            {},
            (ERROR, f"failed: timed_out; {MOVING}"),
        ),
        ({"mode": "paused", "open_goals": LOOSE}, {}, (ERROR, MOVING)),
        ({"fault": "/initial: no state 'x'"}, {}, (ERROR, "/initial: no state 'x'")),
    ],
)
def test_the_level_reports_how_bad_it_is(
    changed: dict[str, Any], around: dict[str, Any], expected: tuple[int, str]
) -> None:
    status = RUNNING._replace(**changed)
    assert level(status, Symptoms(**around)) == expected
    (status,) = array_of(status, Symptoms(**around), at=1.0)["status"]
    assert (status["level"], status["message"]) == expected and status["name"] == "/errand: mission"


def test_a_bulletin_in_json_keeps_half_a_surrogate_as_its_escape() -> None:
    text = text_of(RUNNING._replace(mode="failed", fault="half \ud800").data())
    assert not text_fault(text) and json.loads(text)["fault"] == "half \ud800"


def test_a_report_has_only_texts_that_a_message_carries() -> None:
    fields = RUNNING._replace(mode="failed", why="half \ud800\0", active=("a\0",)).fields()
    assert carried(fields) == fields | {"why": "half \ufffd?", "active": ["a?"]}


def test_a_bulletin_names_the_goals_that_may_still_move_the_robot() -> None:
    reported = RUNNING._replace(open_goals=LOOSE).data()["open_goals"]
    assert reported == [{"number": 3, "action": "drive", "owner": "moving", "reason": "refused"}]


def test_a_bulletin_reports_its_question_with_the_time_left() -> None:
    reported = RUNNING._replace(questions=ASKED).data()
    assert reported["question"] == reported["questions"][0] and reported["question"]["left_s"] == 5.0


def test_sources_that_are_off_or_not_understood_are_named_with_their_values() -> None:
    off = {"pose": SourceState(5, -2.0), "battery": SourceState(5, 1.25), "there": SourceState(5, None)}
    assert level(RUNNING, Symptoms(sources=off)) == (
        WARN,
        "pose: its stamps are 2.0 s ahead, battery: its stamps are 1.2 s behind",
    )
    misread = {"pose": SourceState(5, misread="pose.position.x is nan")}
    assert level(RUNNING, Symptoms(sources=misread)) == (
        WARN,
        "received and not understood: pose: pose.position.x is nan",
    )
    (status,) = array_of(RUNNING, Symptoms(sources=off | misread), at=1.0, robot="tractor1")["status"]
    values = {each["key"]: each["value"] for each in status["values"]}
    assert values["clock offsets"] == "battery: its stamps are 1.2 s behind"
    assert values["not understood"] == "pose: pose.position.x is nan" and values["instance"] == "ab"
    assert status["hardware_id"] == "tractor1"
